#pragma once

#include "harness/scene/schedule_overrides.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <any>
#include <array>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace hdmbench {
class Ranks;
struct SessionOptions;
} // namespace hdmbench

/// One function per subcommand (AddCommand), which says what it is called, what it takes and what it runs.
/// What runs throws InputError and DeviceError, which main() reports.
namespace hdmbench::commands {

/// The program ends with one of these.
enum ExitStatus : int { success = 0, disagreement = 1, bad_input = 2 };

/// A file that the command writes: require_outputs() looks at it before the command runs.
struct OutputFile : std::filesystem::path {
  using path::path;
  using path::operator=;
};
/// Likewise a folder, whose files the command has to look at itself: require_folder() does.
struct OutputFolder : std::filesystem::path {
  using path::path;
};

/// What a file has that an option names: its word in the help, and the element of 3D Slicer's description.
enum class Content { unsaid, toml, image, labels, points, transform };
inline constexpr std::array<std::string_view, 6> content_names{"",       "TOML",   "IMAGE",
                                                               "LABELS", "POINTS", "TRANSFORM"};

/// An option of one or more commands, or where its name has no dashes a word by its place; and the key by
/// which a Call has its value. One of bool is a flag.
template <typename Value>
struct Option {
  explicit Option(const char* names_, const char* help_, Value standard_ = {}, CLI::Validator check_ = {},
                  int count_ = 0)
      : names(names_), help(help_), standard(std::move(standard_)), check(std::move(check_)), count(count_) {}
  /// An option whose value is the name of a file that has `content_`.
  Option(const char* names_, const char* help_, Content content_)
      : names(names_), help(help_), content(content_) {}

  const char* names; ///< "--sizes,--size"
  const char* help;
  Value standard{};       ///< where it is not given
  CLI::Validator check{}; ///< of each value
  int count = 0;          ///< of a list: so many values; 0: any number
  Content content = Content::unsaid;
};

/// How the program was called, and with what it ends.
struct Call {
  std::string line{};           ///< the words after the program's name, as a shell would take them again
  Ranks* ranks = nullptr;       ///< the processes that were started together; null: this one is alone
  int status = success;         ///< an ExitStatus
  CLI::App* command = nullptr;  ///< that runs
  ScheduleOverrides schedule{}; ///< what schedule_options() were given
  std::optional<std::size_t> idle_point{}; ///< as of SceneOptions, of the scenes that are loaded
  std::map<std::string, std::any, std::less<>> values{}; ///< of the command's options, by Option::names

  /// The value of an option: its standard where the command does not have it.
  template <typename Value>
  [[nodiscard]] Value& operator[](const Option<Value>& option) {
    std::any& value = values[option.names];
    return std::any_cast<Value&>(value.has_value() ? value : value = option.standard);
  }
  template <typename Value>
  [[nodiscard]] const Value& operator[](const Option<Value>& option) const {
    const auto found = values.find(option.names);
    return found == values.end() ? option.standard : std::any_cast<const Value&>(found->second);
  }

  /// Whether this process is alone or the first rank: it shows progress and writes results.
  [[nodiscard]] bool speaks() const;
  /// What --device and --threads say.
  [[nodiscard]] SessionOptions session() const;
  /// Writes the rows where --json sends them, if this process speaks, as results of the command that runs, or
  /// of `kind`. Throws InputError.
  void write(nlohmann::json rows, std::string_view kind = {}) const;
  /// The rows so far, marked as cut, for who ends the command before it has written all.
  void keep(const nlohmann::json& rows, std::string_view kind = {}) const;
};

/// Adds an option to a command, whose value the call then has. Compiled once, in commands.cpp: CLI11's
/// templates take ten seconds in every file that instantiates them.
template <typename Value>
void add_option(CLI::App& command, Call& call, const Option<Value>& option);

/// Options that a command takes: one, with a help or a standard of the command's own where given, or several.
class Options {
public:
  template <typename Value>
  Options(Option<Value> option, const char* help = nullptr,
          const std::type_identity_t<std::optional<Value>>& standard = std::nullopt) {
    option.help = help == nullptr ? option.help : help;
    option.standard = standard.value_or(option.standard);
    all_.push_back(
        {option.names, [option](CLI::App& command, Call& call) { add_option(command, call, option); }});
  }
  Options(std::initializer_list<Options> several) {
    for (const Options& one : several) {
      all_.insert(all_.end(), one.all_.begin(), one.all_.end());
    }
  }
  /// One that is no Option.
  Options(std::string name, std::function<void(CLI::App& command, Call& call)> add) {
    all_.push_back({std::move(name), std::move(add)});
  }

  [[nodiscard]] Options without(std::initializer_list<std::string_view> names) const;
  /// With a heading of their own in the help.
  [[nodiscard]] Options under(const char* heading) const;
  void add_to(CLI::App& command, Call& call) const;

private:
  struct One {
    std::string names;
    std::function<void(CLI::App& command, Call& call)> add;
    const char* heading = "Options";
  };
  std::vector<One> all_;
};

/// Adds a subcommand, which ends with the ExitStatus of `run`. The first line of `help` is what the program's
/// list of commands says of it. A rule is "scene is required", "--spread needs
/// --detection" or "--list excludes --json --quick". `takes_energies`: as ScheduleOverrides has it.
void add_command(CLI::App& program, Call& call, const char* name, int (*run)(Call& call), const char* help,
                 const Options& options, const std::vector<std::string>& rules = {},
                 bool takes_energies = true);

/// No option is silently ignored: throws InputError that names those of `options` that the user gave. `why`
/// is a sentence: "--halo is for several processes".
void refuse_idle(const CLI::App& command, const std::vector<std::string>& options, std::string_view why);

/// Throws InputError for an option among `words`, the arguments of `command`, that the command does not have,
/// naming the one that it may have been, and for a list with a word missing: CLI11 takes "16,,32" for 16
/// and 32.
void require_known_options(const CLI::App& command, const std::vector<std::string>& words);

/// Throws InputError where a file or folder that `command`, which has been parsed, would write (OutputFile,
/// OutputFolder) is one of those that it reads: what its other arguments name, result files in a folder and
/// the images of a scene among them. Also where a file cannot be written to.
void require_outputs(const CLI::App& command);

using AddCommand = void(CLI::App& program, Call& call);
AddCommand add_devices, add_methods, add_run, add_register, add_detect, add_rivals, add_verify,
    add_implementations, add_machine_code, add_probe, add_browser, add_golden, add_accuracy, add_continuum,
    add_faults, add_atlas, add_tradeoff, add_bench, add_report, add_export, add_fem_to_image,
    add_positions_to_displacements, add_energy_plot, add_tune, add_scenes, add_warp, add_dataset;

} // namespace hdmbench::commands
