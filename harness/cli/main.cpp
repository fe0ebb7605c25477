#include "backends/cpu/cpu.hpp"
#include "backends/shared/kept_arithmetic.hpp"
#include "harness/check/machine_code/compilers.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/process.hpp"
#include "harness/cli/slicer_module.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/scene/images/images.hpp"

#include <build_information.hpp>
#include <fmt/ranges.h>

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <initializer_list>
#include <memory>
#include <sstream>

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

/// fmt::print throws where standard error cannot be written to. Where all ranks end for one reason the
/// first one says it; else a rank says it and ends all.
int refuse(std::string_view reason, Ranks* ranks) {
  const bool all_end = ranks == nullptr || ranks->all_end();
  if (all_end && ranks != nullptr && !ranks->is_first()) {
    return commands::bad_input;
  }
  const std::string who = all_end || ranks->is_first() ? "" : fmt::format("rank {}: ", ranks->rank());
  std::fputs(fmt::format("hdmbench: {}{}\n", who, printable(reason)).c_str(), stderr);
  if (!all_end) {
    std::fflush(stdout);
    ranks->end_all(commands::ended_by_main(commands::bad_input));
  }
  return commands::bad_input;
}

/// `--json -` sends results to standard output: what is printed for people then goes to standard error.
bool sends_results_to_standard_output(std::span<char*> words) {
  const auto is_option = [](const char* word) { return word == std::string_view("--json"); };
  const auto option = std::ranges::find_if(words, is_option);
  return contains(words, std::string_view("--json=-")) ||
         (option != words.end() && option + 1 != words.end() && *(option + 1) == std::string_view("-"));
}

/// Ranks that were started with other words would wait for each other in different places, for ever; and
/// other commands would do the same work several times, and write the same files. Collective.
void require_meaning_for_ranks(std::string_view command, const std::string& own, Ranks& ranks) {
  require_same(ranks, own, [](std::size_t rank, std::string_view text, std::string_view first) {
    return fmt::format(
        "rank {} was started as \"hdmbench {}\", but rank 0 as \"hdmbench {}\"; give all ranks "
        "the same arguments",
        rank, text, first);
  });
  constexpr std::array<std::string_view, 5> shared{"run", "verify", "faults", "bench", "devices"};
  if (!command.starts_with('-') && !contains(shared, command)) {
    throw InputError(
        fmt::format("{} runs in one process; mpirun is for {}", command, fmt::join(shared, ", ")));
  }
}

/// One line a command: the first one of its help.
class OneLineEach : public CLI::Formatter {
public:
  std::string make_subcommand(const CLI::App* command) const override {
    const std::string help = command->get_description();
    std::ostringstream line;
    CLI::detail::format_help(line, command->get_name(), help.substr(0, help.find('\n')), get_column_width());
    return line.str();
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return fmt::format("{}", fmt::join(wrapped(Formatter::make_option_desc(option), 70), "\n"));
  }
};

/// The commands, as --help lists them.
void add_commands(CLI::App& program, commands::Call& call) {
  using namespace commands;
  struct Group {
    const char* heading;
    std::initializer_list<AddCommand*> commands;
  };
  for (const Group& group : std::initializer_list<Group>{
           {"Solve", {add_run, add_register, add_detect, add_warp, add_dataset}},
           {"Check",
            {add_verify, add_probe, add_implementations, add_machine_code, add_golden, add_faults,
             add_browser}},
           {"Measure and judge",
            {add_bench, add_tradeoff, add_accuracy, add_continuum, add_atlas, add_rivals, add_report}},
           {"List and convert",
            {add_devices, add_methods, add_scenes, add_export, add_tune, add_energy_plot, add_fem_to_image,
             add_positions_to_displacements}}}) {
    for (AddCommand* const add : group.commands) {
      add(program, call);
      CLI::App& added = *program.get_subcommands({}).back();
      added.group(group.heading);
      if (contains(slicer_modules, added.get_name())) {
        add_slicer_description(added);
      }
    }
  }
}

/// Throws what the commands throw.
int run_program(std::span<char*> words, Ranks* ranks) {
  using namespace commands;
  Call call{.ranks = ranks};
  const bool speaks = call.speaks(); // results come from the first rank
  if (!speaks && std::freopen("/dev/null", "w", stdout) == nullptr) {
    throw InputError("/dev/null cannot be opened");
  }
  if (speaks && sends_results_to_standard_output(words)) {
    stdout = stderr;
  }
  print_printable();
  for (const char* const word : words.subspan(1)) {
    call.line += (call.line.empty() ? "" : " ") + shell_word(word);
  }
  const std::string_view asked = words.size() > 1 ? words[1] : "--help";
  if (ranks != nullptr) {
    require_meaning_for_ranks(asked, call.line, *ranks);
  }
  CLI::App program("hdmbench: one soft-tissue displacement on CPUs and GPUs, checked to the bit.\n"
                   "COMMAND --help explains each command.",
                   "hdmbench");
  program.set_version_flag("--version", std::string(build::version));
  program.require_subcommand(1);
  program.formatter(std::make_shared<OneLineEach>());
  add_commands(program, call);
  std::vector<std::string> names;
  for (CLI::App* const command : program.get_subcommands({})) {
    command->parse_complete_callback(
        [command, ranks] { let_first_check(ranks, [&] { require_outputs(*command); }); });
    names.push_back(command->get_name());
  }
  if (words.size() < 2) {
    fmt::print("{}", program.help());
    return bad_input;
  }
  if (ranks == nullptr) { // ranks are placed by who started them
    place_threads();
  }
  try {
    if (contains(names, asked)) {
      take_underscores(*program.get_subcommand(words[1]), words.subspan(2));
      require_known_options(*program.get_subcommand(words[1]), {words.begin() + 2, words.end()});
    } else if (!asked.starts_with('-')) {
      throw InputError(fmt::format("there is no command \"{}\"; {}", asked,
                                   did_you_mean(asked, names, "hdmbench --help lists them")));
    }
    program.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::ParseError& error) {
    std::ostringstream help;
    std::ostringstream why;
    const int code = program.exit(error, help, why);
    fmt::print("{}", help.str());
    std::fputs(speaks ? printable(why.str()).c_str() : "", stderr);
    return code == 0 ? success : bad_input;
  }
  return call.status;
}

int run_and_explain(std::span<char*> words) {
  std::unique_ptr<Ranks> ranks;
  const auto refuse_all = [&](std::string_view why) { return refuse(why, ranks.get()); };
  try {
    commands::require_limits();
    commands::explain_sudden_end();
    ranks = Ranks::of_this_process();
    return run_program(words, ranks.get());
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
  compile_apart(argc, argv);
  set_environment(argv);
  keep_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN); // a file that grows beyond its limit is then an error as any other
  const int status = run_and_explain({argv, static_cast<std::size_t>(argc)});
  (void)std::fflush(stdout); // what has been printed comes first
  for (const std::string& sentence : all_changed_arithmetic()) {
    std::fputs(fmt::format("hdmbench: {}\n", sentence).c_str(), stderr);
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    return commands::ended_by_main(
        refuse("standard output cannot be written to (disk full, or closed?)", nullptr));
  }
  return commands::ended_by_main(status);
}
