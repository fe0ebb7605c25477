#include "backends/backend.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "kernels/data/input_error.hpp"

#include <build_information.hpp>
#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <string>

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

/// fmt::print throws where standard error cannot be written to.
int refuse(std::string_view why) {
  std::fputs(fmt::format("hdmbench: {}\n", why).c_str(), stderr);
  return commands::bad_input;
}

/// Throws what the commands throw.
int run_program(int argc, char** argv) {
  const std::string arguments = commands::command_line(argc, argv);
  int status = commands::success;
  CLI::App program(
      "hdmbench: one soft-tissue displacement model on CPU, OpenGL and Vulkan, cross-checked to the bit and "
      "timed.\nCOMMAND --help explains each command.",
      "hdmbench");
  program.set_version_flag("--version", std::string(build::version));
  program.require_subcommand(1);
  commands::add_devices(program, arguments, status);
  commands::add_methods(program);
  commands::add_run(program, arguments, status);
  commands::add_register(program, arguments, status);
  commands::add_detect(program, arguments, status);
  commands::add_rivals(program, arguments, status);
  commands::add_verify(program, arguments, status);
  commands::add_probe(program, arguments);
  commands::add_implementations(program, arguments, status);
  commands::add_faults(program, arguments, status);
  commands::add_golden(program, arguments, status);
  commands::add_bench(program, arguments, status);
  commands::add_accuracy(program, arguments, status);
  commands::add_continuum(program, arguments, status);
  commands::add_atlas(program, arguments);
  commands::add_tradeoff(program, arguments, status);
  commands::add_browser(program, arguments);
  commands::add_report(program, status);
  commands::add_export(program);
  commands::add_fem_to_image(program);
  commands::add_positions_to_displacements(program);
  commands::add_energy_plot(program);
  commands::add_tune(program);
  if (argc < 2) {
    fmt::print("{}", program.help());
    return commands::bad_input;
  }
  try {
    const auto named =
        program.get_subcommands([&](const CLI::App* command) { return command->get_name() == argv[1]; });
    if (argv[1][0] != '-' && named.empty()) {
      throw InputError(fmt::format("there is no command \"{}\"; hdmbench --help lists them", argv[1]));
    }
    if (!named.empty()) {
      commands::require_whole_lists(*named.front(), {argv + 2, argv + argc});
    }
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? commands::success : commands::bad_input;
  }
  return status;
}

int run_and_explain(int argc, char** argv) {
  try {
    return run_program(argc, argv);
  } catch (const InputError& error) {
    return refuse(error.what());
  } catch (const DeviceError& error) {
    return refuse(error.what());
  } catch (const std::bad_alloc&) {
    return refuse("out of memory");
  } catch (const std::exception& error) {
    // fmt::print throws where standard output cannot be written to: main() says so.
    return std::ferror(stdout) != 0 ? commands::bad_input
                                    : refuse(fmt::format("internal error: {}", error.what()));
  }
}

} // namespace

int main(int argc, char** argv) {
  keep_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN); // a file that grows beyond its limit is then an error as any other
  const int status = run_and_explain(argc, argv);
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    return refuse("standard output cannot be written to (disk full, or closed?)");
  }
  return status;
}
