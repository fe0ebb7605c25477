#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace hdmbench {
class Ranks;
}

/// One function per subcommand (AddCommand): declares it and, if the user calls it, runs it. What runs throws
/// InputError and DeviceError, which main() reports.
namespace hdmbench::commands {

/// The program ends with one of these.
enum ExitStatus : int { success = 0, disagreement = 1, bad_input = 2 };

/// How the program was called, and with what it ends.
struct Call {
  std::string line{};           ///< the words after the program's name, as a shell would take them again
  Ranks* ranks = nullptr;       ///< the processes that were started together; null: this one is alone
  int status = success;         ///< an ExitStatus
  CLI::App* command = nullptr;  ///< that runs
  std::filesystem::path json{}; ///< where --json sends the results; empty: nobody asked for them

  /// Whether this process is alone or the first rank: it shows progress and writes results.
  [[nodiscard]] bool speaks() const;
  /// Writes the rows where --json sends them, if this process speaks, as results of the command that runs, or
  /// of `kind`. Throws InputError.
  void write(nlohmann::json rows, bool quick = false, std::string_view kind = {}) const;
};

/// A subcommand, and its arguments, which live as long as it does.
template <typename Arguments>
struct Declared {
  CLI::App& command;
  Arguments& own;
};

/// Declares a subcommand that ends with the ExitStatus of `run`.
template <typename Arguments>
Declared<Arguments> declare(CLI::App& program, Call& call, const char* name, const char* help,
                            int (*run)(Arguments&, Call&)) {
  CLI::App* const command = program.add_subcommand(name, help);
  const auto own = std::make_shared<Arguments>();
  command->callback([own, run, command, &call] {
    call.command = command;
    call.status = run(*own, call);
  });
  return {*command, *own};
}

/// CLI11's add_option and add_flag, compiled once, in arguments.cpp: their templates take ten seconds in
/// every file that instantiates them.
template <typename Value>
CLI::Option* add_option(CLI::App& command, const std::string& names, Value& variable,
                        const std::string& help);
CLI::Option* add_flag(CLI::App& command, const std::string& names, bool& variable, const std::string& help);

/// A file that the command writes: require_outputs() looks at it before the command runs.
CLI::Option* add_output(CLI::App& command, const std::string& names, std::filesystem::path& file,
                        const std::string& help);
/// A folder likewise, whose files the command has to look at itself: require_folder() does.
CLI::Option* add_output_folder(CLI::App& command, std::filesystem::path& folder,
                               const std::string& help = "Folder for the files, made if missing");
/// --json, of almost every command.
CLI::Option* add_json(CLI::App& command, Call& call,
                      const std::string& help = "Write the results to this file");

/// Options that a command declares while this lives stand under a heading of their own in its help.
class OptionGroup {
public:
  OptionGroup(CLI::App& command, const std::string& heading) : command_(command) {
    command_.option_defaults()->group(heading);
  }
  OptionGroup(const OptionGroup&) = delete;
  OptionGroup& operator=(const OptionGroup&) = delete;
  ~OptionGroup() { command_.option_defaults()->group("Options"); }

private:
  CLI::App& command_;
};

using AddCommand = void(CLI::App& program, Call& call);
AddCommand add_devices, add_methods, add_run, add_register, add_detect, add_rivals, add_verify,
    add_implementations, add_probe, add_browser, add_golden, add_accuracy, add_continuum, add_faults,
    add_atlas, add_tradeoff, add_bench, add_report, add_export, add_fem_to_image,
    add_positions_to_displacements, add_energy_plot, add_tune;

} // namespace hdmbench::commands
