#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace hdmbench {
class Ranks;
}

/// One function per subcommand: declares it and, if the user calls it, runs it. `status` receives an
/// ExitStatus; `arguments` is the command line for the results' context. Callbacks throw InputError and
/// DeviceError, which main() reports. `ranks`: the processes that were started together, null where this one
/// is alone; commands without it run alone.
namespace hdmbench::commands {

void add_devices(CLI::App& program, const std::string& arguments, int& status, Ranks* ranks);
void add_methods(CLI::App& program);
void add_run(CLI::App& program, const std::string& arguments, int& status, Ranks* ranks);
void add_register(CLI::App& program, const std::string& arguments, int& status);
void add_detect(CLI::App& program, const std::string& arguments, int& status);
void add_rivals(CLI::App& program, const std::string& arguments, int& status);
void add_verify(CLI::App& program, const std::string& arguments, int& status, Ranks* ranks);
void add_implementations(CLI::App& program, const std::string& arguments, int& status);
void add_probe(CLI::App& program, const std::string& arguments);
void add_browser(CLI::App& program, const std::string& arguments);
void add_golden(CLI::App& program, const std::string& arguments, int& status);
void add_accuracy(CLI::App& program, const std::string& arguments, int& status);
void add_continuum(CLI::App& program, const std::string& arguments, int& status);
void add_faults(CLI::App& program, const std::string& arguments, int& status, Ranks* ranks);
void add_atlas(CLI::App& program, const std::string& arguments);
void add_tradeoff(CLI::App& program, const std::string& arguments, int& status);
void add_bench(CLI::App& program, const std::string& arguments, int& status, Ranks* ranks);
void add_report(CLI::App& program, int& status);
void add_export(CLI::App& program);
void add_fem_to_image(CLI::App& program);
void add_positions_to_displacements(CLI::App& program);
void add_energy_plot(CLI::App& program);
void add_tune(CLI::App& program);

} // namespace hdmbench::commands
