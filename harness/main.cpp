#include "backends/backend.hpp"
#include "harness/commands/arguments.hpp"
#include "harness/commands/commands.hpp"
#include "kernels/input_error.hpp"

#include <build_information.hpp>
#include <fmt/format.h>

#include <cstdlib>
#include <string>

namespace {

bool has_command(const CLI::App& program, const std::string& name) {
  const auto commands =
      program.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  return !commands.empty();
}

} // namespace

int main(int argc, char** argv) {
  using namespace hdmbench;
  const std::string arguments = commands::command_line(argc, argv);
  int status = commands::success;
  CLI::App program(
      "hdmbench: one soft-tissue displacement model on CPU, OpenGL and Vulkan, cross-checked to the bit and "
      "timed.\nCOMMAND --help explains each command.");
  program.set_version_flag("--version", std::string(build::version));
  program.require_subcommand(1);
  try {
    commands::add_devices(program, arguments, status);
    commands::add_methods(program);
    commands::add_run(program, arguments, status);
    commands::add_verify(program, arguments, status);
    commands::add_faults(program, arguments, status);
    commands::add_golden(program, arguments, status);
    commands::add_bench(program, arguments, status);
    commands::add_accuracy(program, arguments, status);
    commands::add_atlas(program, arguments);
    commands::add_tradeoff(program, arguments, status);
    commands::add_report(program, status);
    commands::add_export(program);
    commands::add_fem_to_image(program);
    commands::add_positions_to_displacements(program);
    commands::add_energy_plot(program);
    commands::add_tune(program);
    if (argc > 1 && argv[1][0] != '-' && !has_command(program, argv[1])) {
      throw InputError(fmt::format("there is no command \"{}\"; hdmbench --help lists them", argv[1]));
    }
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? commands::success : commands::bad_input;
  } catch (const InputError& error) {
    fmt::print(stderr, "hdmbench: {}\n", error.what());
    return commands::bad_input;
  } catch (const DeviceError& error) {
    fmt::print(stderr, "hdmbench: {}\n", error.what());
    return commands::bad_input;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "hdmbench: out of memory\n");
    return commands::bad_input;
  } catch (const std::exception& error) {
    fmt::print(stderr, "hdmbench: internal error: {}\n", error.what());
    return commands::bad_input;
  }
  return status;
}
