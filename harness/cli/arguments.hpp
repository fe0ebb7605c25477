#pragma once

#include "backends/registry.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/names.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// What every command needs.
namespace hdmbench::commands {

/// What the user may change about every scene's schedule.
struct ScheduleOverrides {
  bool takes_energy = false;                ///< whether the command has --energy; say so before add_to()
  const RegisteredEnergy* energy = nullptr; ///< null: the scene's, or that of the method
  /// "method", and the values of schedule_keys(), by their names.
  std::map<std::string, std::string, std::less<>> given{};

  void add_to(CLI::App& command);
  /// With `other_method` in place of the one given, where there is one. Throws InputError.
  void apply(Scene& scene, const std::optional<std::string>& other_method = std::nullopt) const;
  /// The arguments that were given, each with a space before it: " --iterations 5", with `other_method` as
  /// above.
  [[nodiscard]] std::string text(const std::optional<std::string>& other_method = std::nullopt) const;
};

/// The names of the options of ScheduleOverrides that a command has, but those of `but`.
[[nodiscard]] std::vector<std::string> schedule_options(const CLI::App& command,
                                                        const std::vector<std::string>& but);

using nlohmann::json;

/// Arguments of the commands that solve one scene.
struct SceneArguments {
  std::string scene{};        ///< name or file
  std::string size{};         ///< "300" or "257x130"; empty: the scene's own
  std::string orientation{};  ///< of a brain; empty: the scene's own
  std::optional<int> slice{}; ///< of that orientation
  std::string backend = "openmp";
  SessionOptions session{};
  ScheduleOverrides schedule{};

  /// Which slice of a scene's brain.
  void add_orientation_to(CLI::App& command);
  /// Only the scene, its size and its schedule.
  void add_scene_to(CLI::App& command);
  /// Where it is computed.
  void add_backend_to(CLI::App& command);

  /// The scene at its size with its schedule. Throws InputError.
  [[nodiscard]] Scene load() const;
  /// The backend, which lives as long as the registry. Throws InputError where it is unknown or cannot update
  /// as the scene wants.
  [[nodiscard]] const Backend& choose(const std::vector<std::unique_ptr<Backend>>& registry,
                                      const Scene& scene_to_solve) const;
};

/// Loads a scene, which may be large.
using SceneLoader = std::function<std::optional<Scene>()>;

/// What `load` gives; none, with a line on standard output, where its files are not on this machine, unless
/// it `is_needed`: then throws MissingFile.
[[nodiscard]] std::optional<Scene> load_unless_missing(std::string_view name, bool is_needed,
                                                       const std::function<Scene()>& load);

/// Arguments of the commands that compare backends.
struct CommonArguments {
  std::vector<std::string> scenes{}; ///< names or files; empty: the command's own choice
  std::vector<std::string> sizes{};  ///< "300" or "257x130"; empty: each scene's own
  std::vector<std::string> backends{};
  std::vector<std::string> required{};
  SessionOptions session{};
  ScheduleOverrides schedule{};
  std::vector<std::string> methods{}; ///< names, or "all"; empty: one, see ScheduleOverrides
  bool quick = false;

  void add_to(CLI::App& command, Call& call);
  /// Only which scenes, at which sizes, solved how.
  void add_scenes_to(CLI::App& command);
  /// Only which backends, on which device, with how many threads.
  void add_backends_to(CLI::App& command);

  /// Whether a backend was named here or with --require.
  [[nodiscard]] bool needs(std::string_view backend) const;
  /// " --device 1 --threads 2" as far as they were given.
  [[nodiscard]] std::string session_words() const;
  /// The command line that repeats one comparison; where the scene has no source, with all others.
  [[nodiscard]] std::string repeat(std::string_view command, const Scene& scene,
                                   std::string_view backend) const;

  /// Scenes at sizes in the order they are asked for, each with every method asked for; those of `by_default`
  /// where no scene is on the command line. Throws InputError.
  [[nodiscard]] std::vector<SceneLoader> scene_loaders(const std::vector<std::string>& by_default) const;
  [[nodiscard]] std::vector<Scene> load_scenes(const std::vector<std::string>& by_default) const;
  /// The reference first, then the chosen backends (all if none was named) without it; scalar is the
  /// reference where `reference` is empty, none is where it is "none". Throws InputError for an unknown name,
  /// or where nothing is left to run, and DeviceError for one that was named here or with --require and is
  /// not there.
  [[nodiscard]] std::vector<const Backend*> choose(const std::vector<std::unique_ptr<Backend>>& registry,
                                                   const std::string& reference = {}) const;
};

/// "300" is 300 x 300, "257x130" and "64x64x64" are that. Throws InputError, also where no scene of that size
/// fits into memory.
[[nodiscard]] Extent parse_size(const std::string& text);
/// The same; none where `text` is empty.
[[nodiscard]] std::optional<Extent> parse_any_size(const std::string& text);

/// "0.2px" or "0.2": pixels, > 0; where it is known how many millimetres a pixel has, also "0.1mm". Throws
/// InputError.
[[nodiscard]] double parse_pixels(const std::string& text, std::optional<double> spacing = {});
/// "10ms", "2s" or "2": seconds, > 0. Throws InputError.
[[nodiscard]] double parse_seconds(const std::string& text);

/// How the result file `results` names a file of `folder`; the bare name where there is no result file.
[[nodiscard]] std::string beside(const std::filesystem::path& results, const std::filesystem::path& folder,
                                 const std::string& name);

/// The lists of all ranks as one, by rank, on the first one; nothing on the others. Collective.
[[nodiscard]] nlohmann::json gather_rows(const nlohmann::json& own, Ranks& ranks);
/// The network's name of this machine; empty where it has none.
[[nodiscard]] std::string machine_name();

/// A word as a shell takes it: in quotes where it has to be.
[[nodiscard]] std::string shell_word(std::string_view word);

/// Takes options away that have no effect in this command.
void remove_options(CLI::App& command, std::initializer_list<const char*> options);

/// No option is silently ignored: throws InputError that names those of `options` that the user gave. `why`
/// is a sentence: "--halo is for several processes".
void refuse_idle(const CLI::App& command, const std::vector<std::string>& options, std::string_view why);

/// Throws InputError for an option among `words`, the arguments of `command`, that the command does not have,
/// naming the one that it may have been, and for a list with a word missing: CLI11 takes "16,,32" for 16
/// and 32.
void require_known_options(const CLI::App& command, const std::vector<std::string>& words);

/// Throws InputError where a file or folder that `command`, which has been parsed, would write (add_output)
/// is one of those that it reads: what its other arguments name, result files in a folder and the images of a
/// scene among them. If it `writes` them, also where a file cannot be written to.
void require_outputs(const CLI::App& command, bool writes);

/// What a continuous integration of drivers asks of a command beyond its own verdict: nothing that was not
/// compared may pass.
class Gates {
public:
  /// --require-hardware and --fail-on-skip, and --baseline of `verify`.
  void add_to(CLI::App& command, bool with_baseline = false);

  /// Before the command runs. Where hardware is required, leaves backends with software only out of
  /// `arguments`, with a line on standard output; scalar and openmp, which claim to be no GPU, stay. Where
  /// there is a baseline, `call` gets a file for the results. Throws DeviceError where a backend that was
  /// named has software only, or no hardware is left, and InputError for a baseline that cannot be read.
  void prepare(CommonArguments& arguments, Call& call);

  /// After it: `status`, or disagreement where that was success and a backend was skipped or something that
  /// agreed in the baseline does not agree, or is not there, in the results. Says which. Throws InputError.
  /// The baseline is compared by the process that speaks.
  [[nodiscard]] int judge(int status, const Call& call) const;

private:
  bool require_hardware_ = false;
  bool fail_on_skip_ = false;
  std::filesystem::path baseline_; ///< empty: none
  std::string skipped_;            ///< lines: backends, and why
  std::optional<TemporaryDirectory> folder_{};
};

} // namespace hdmbench::commands
