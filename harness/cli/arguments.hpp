#pragma once

#include "backends/registry.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/schedule_overrides.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// What every command needs.
namespace hdmbench::commands {

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

/// Loads a scene, which may be large. None, with a line on standard output, where nobody named it and its
/// files are not on this machine.
using SceneLoader = std::function<std::optional<Scene>()>;

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

/// "300" is 300 x 300, "257x130" and "64x64x64" are that. Throws InputError.
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

} // namespace hdmbench::commands
