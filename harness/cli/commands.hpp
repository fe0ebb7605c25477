#pragma once

#include "harness/cli/command.hpp"

#include <string>

namespace hdmbench {
class Ranks;
}

/// One function per subcommand: declares it and, if the user calls it, runs it. `status` receives an
/// ExitStatus; `arguments` is the command line for the results' context. Callbacks throw InputError and
/// DeviceError, which main() reports. `ranks`: the processes that were started together, null where this one
/// is alone; commands without it run alone.
namespace hdmbench::commands {

void add_devices(const Command& program, const std::string& arguments, int& status, Ranks* ranks);
void add_methods(const Command& program);
void add_run(const Command& program, const std::string& arguments, int& status, Ranks* ranks);
void add_register(const Command& program, const std::string& arguments, int& status);
void add_detect(const Command& program, const std::string& arguments, int& status);
void add_rivals(const Command& program, const std::string& arguments, int& status);
void add_verify(const Command& program, const std::string& arguments, int& status, Ranks* ranks);
void add_implementations(const Command& program, const std::string& arguments, int& status);
void add_probe(const Command& program, const std::string& arguments, int& status);
void add_browser(const Command& program, const std::string& arguments);
void add_golden(const Command& program, const std::string& arguments, int& status);
void add_accuracy(const Command& program, const std::string& arguments, int& status);
void add_continuum(const Command& program, const std::string& arguments, int& status);
void add_faults(const Command& program, const std::string& arguments, int& status, Ranks* ranks);
void add_atlas(const Command& program, const std::string& arguments);
void add_tradeoff(const Command& program, const std::string& arguments, int& status);
void add_bench(const Command& program, const std::string& arguments, int& status, Ranks* ranks);
void add_report(const Command& program, int& status);
void add_export(const Command& program);
void add_fem_to_image(const Command& program);
void add_positions_to_displacements(const Command& program);
void add_energy_plot(const Command& program);
void add_tune(const Command& program);

} // namespace hdmbench::commands
