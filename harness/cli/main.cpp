#include "backends/backend.hpp"
#include "backends/cpu/processor.hpp"
#include "backends/registry.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/ranks/launch.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/nearest_name.hpp"
#include "kernels/data/input_error.hpp"

#include <CLI/CLI.hpp>
#include <build_information.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace hdmbench;

/// A file that is opened while a standard stream is closed takes its place, and receives what is printed. In
/// its place stands what cannot be written to: then the end of main() notices.
void keep_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) == -1) {
      (void)open("/dev/null", O_RDONLY);
    }
  }
}

/// fmt::print throws where standard error cannot be written to. Among ranks it ends all of them.
int refuse(std::string_view why, Ranks* ranks) {
  const bool says_who = ranks != nullptr && !ranks->is_first();
  if (ranks != nullptr) {
    ranks->give_way();
  }
  std::fputs(says_who ? fmt::format("hdmbench: rank {}: {}\n", ranks->rank(), why).c_str()
                      : fmt::format("hdmbench: {}\n", why).c_str(),
             stderr);
  if (ranks != nullptr) {
    std::fflush(stdout);
    ranks->end_all(commands::bad_input);
  }
  return commands::bad_input;
}

/// Results come from the first rank.
void keep_silent(const Ranks* ranks) {
  if (ranks != nullptr && !ranks->is_first() && std::freopen("/dev/null", "w", stdout) == nullptr) {
    throw InputError("/dev/null cannot be opened");
  }
}

/// `--json -` sends results to standard output: what is printed for people then goes to standard error.
bool sends_results_to_standard_output(std::span<char*> words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string_view word = words[i];
    if (word == "--json=-" ||
        (word == "--json" && i + 1 < words.size() && words[i + 1] == std::string_view("-"))) {
      return true;
    }
  }
  return false;
}

/// Among ranks, other commands would do the same work several times, and write the same files.
void require_for_ranks(std::string_view command, const Ranks* ranks) {
  constexpr std::array<std::string_view, 5> shared{"run", "verify", "faults", "bench", "devices"};
  if (ranks != nullptr && std::ranges::find(shared, command) == shared.end()) {
    throw InputError(
        fmt::format("{} runs in one process; mpirun is for {}", command, fmt::join(shared, ", ")));
  }
}

/// Otherwise ranks would wait for each other in different places, for ever. Collective.
void require_same_arguments(const std::string& own, Ranks* ranks) {
  const std::vector<std::string> all = ranks != nullptr ? ranks->gather(own) : std::vector<std::string>{};
  for (std::size_t rank = 0; rank < all.size(); ++rank) {
    if (all[rank] != own) {
      throw InputError(fmt::format("rank {} was started as \"hdmbench {}\", but rank 0 as \"hdmbench {}\"; "
                                   "give all ranks the same arguments",
                                   rank, all[rank], own));
    }
  }
}

/// Throws what the commands throw.
int run_program(int argc, char** argv, Ranks* ranks) {
  keep_silent(ranks);
  if ((ranks == nullptr || ranks->is_first()) &&
      sends_results_to_standard_output({argv, static_cast<std::size_t>(argc)})) {
    stdout = stderr;
  }
  const std::string arguments = commands::command_line(argc, argv);
  require_same_arguments(arguments, ranks);
  int status = commands::success;
  CLI::App program(
      "hdmbench: one soft-tissue displacement model on CPU, OpenGL and Vulkan, cross-checked to the bit and "
      "timed.\nCOMMAND --help explains each command.",
      "hdmbench");
  program.set_version_flag("--version", std::string(build::version));
  program.require_subcommand(1);
  const commands::Command declared(program);
  commands::add_devices(declared, arguments, status, ranks);
  commands::add_methods(declared);
  commands::add_run(declared, arguments, status, ranks);
  commands::add_register(declared, arguments, status);
  commands::add_detect(declared, arguments, status);
  commands::add_rivals(declared, arguments, status);
  commands::add_verify(declared, arguments, status, ranks);
  commands::add_probe(declared, arguments, status);
  commands::add_implementations(declared, arguments, status);
  commands::add_faults(declared, arguments, status, ranks);
  commands::add_golden(declared, arguments, status);
  commands::add_bench(declared, arguments, status, ranks);
  commands::add_accuracy(declared, arguments, status);
  commands::add_continuum(declared, arguments, status);
  commands::add_atlas(declared, arguments);
  commands::add_tradeoff(declared, arguments, status);
  commands::add_browser(declared, arguments);
  commands::add_report(declared, status);
  commands::add_export(declared);
  commands::add_fem_to_image(declared);
  commands::add_positions_to_displacements(declared);
  commands::add_energy_plot(declared);
  commands::add_tune(declared);
  for (CLI::App* const command : program.get_subcommands({})) {
    command->parse_complete_callback(
        [command] { commands::require_other_outputs(commands::Command(*command)); });
  }
  if (argc < 2) {
    fmt::print("{}", program.help());
    return commands::bad_input;
  }
  if (ranks == nullptr) { // ranks are placed by who started them
    place_threads();
  }
  try {
    const auto named =
        program.get_subcommands([&](const CLI::App* command) { return command->get_name() == argv[1]; });
    if (argv[1][0] != '-' && named.empty()) {
      std::vector<std::string> names;
      std::ranges::transform(program.get_subcommands(nullptr), std::back_inserter(names),
                             &CLI::App::get_name);
      throw InputError(fmt::format("there is no command \"{}\"; {}", argv[1],
                                   did_you_mean(argv[1], names, "hdmbench --help lists them")));
    }
    if (!named.empty()) {
      require_for_ranks(argv[1], ranks);
      const std::vector<std::string> words(argv + 2, argv + argc);
      const commands::Command command(*named.front());
      commands::require_known_options(command, words);
      commands::require_whole_lists(command, words);
    }
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream unread;
    const bool speaks = ranks == nullptr || ranks->is_first();
    const int code = program.exit(error, std::cout, speaks ? std::cerr : unread);
    return code == 0 ? commands::success : commands::bad_input;
  }
  return status;
}

int run_and_explain(int argc, char** argv) {
  std::unique_ptr<Ranks> ranks;
  const auto refuse_all = [&](std::string_view why) { return refuse(why, ranks.get()); };
  try {
    ranks = Ranks::of_this_process();
    return run_program(argc, argv, ranks.get());
  } catch (const InputError& error) {
    return refuse_all(error.what());
  } catch (const DeviceError& error) {
    return refuse_all(error.what());
  } catch (const std::bad_alloc&) {
    return refuse_all("out of memory");
  } catch (const std::exception& error) {
    // fmt::print throws where standard output cannot be written to: main() says so.
    return std::ferror(stdout) != 0 ? commands::bad_input
                                    : refuse_all(fmt::format("internal error: {}", error.what()));
  }
}

} // namespace

int main(int argc, char** argv) {
  ask_drivers_apart(argc, argv);
  read_images_apart(argc, argv);
  watch_over_rank(argv, commands::bad_input);
  keep_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN); // a file that grows beyond its limit is then an error as any other
  const int status = run_and_explain(argc, argv);
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    return refuse("standard output cannot be written to (disk full, or closed?)", nullptr);
  }
  return status;
}
