#pragma once

#include "backends/registry.hpp"
#include "harness/cli/schedule_overrides.hpp"
#include "harness/scene/scene.hpp"

#include "harness/cli/command.hpp"

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench::commands {

/// The program ends with one of these.
enum ExitStatus : int { success = 0, disagreement = 1, bad_input = 2 };

/// Arguments of the commands that solve one scene.
struct SceneArguments {
  std::string scene;        ///< name or file
  std::string size;         ///< "300" or "257x130"; empty: the scene's own
  std::string orientation;  ///< of a brain; empty: the scene's own
  std::optional<int> slice; ///< of that orientation
  std::string backend = "openmp";
  SessionOptions session;
  ScheduleOverrides schedule;

  /// Which slice of a scene's brain.
  void add_orientation_to(const Command& command);
  /// Only the scene, its size and its schedule.
  void add_scene_to(const Command& command);
  /// Where it is computed.
  void add_backend_to(const Command& command);

  /// The scene at its size with its schedule. Throws InputError.
  [[nodiscard]] Scene load() const;
  /// What it is made of.
  [[nodiscard]] std::vector<std::filesystem::path> files() const { return files_of_scene(scene); }
  /// The backend, which lives as long as the registry. Throws InputError where it is unknown or cannot update
  /// as the scene wants.
  [[nodiscard]] const Backend& choose(const std::vector<std::unique_ptr<Backend>>& registry,
                                      const Scene& scene_to_solve) const;

private:
  [[nodiscard]] SceneOptions options() const;
};

/// One scene to load.
struct SceneChoice {
  std::string name;                  ///< or file
  SceneOptions options;              ///< its size
  std::optional<std::string> method; ///< none: what --method or the scene says
  bool by_default = false;           ///< nobody named it: it may be left out
};

/// Arguments that verify and bench share.
struct CommonArguments {
  std::vector<std::string> scenes; ///< names or files; empty: the command's own choice
  std::vector<std::string> sizes;  ///< "300" or "257x130"; empty: each scene's own
  std::vector<std::string> backends;
  std::vector<std::string> required;
  SessionOptions session;
  ScheduleOverrides schedule;
  std::vector<std::string> methods; ///< names, or "all"; empty: one, see ScheduleOverrides
  bool quick = false;
  std::filesystem::path json;

  void add_to(const Command& command);
  /// Only which scenes, at which sizes, solved how.
  void add_scenes_to(const Command& command);
  /// Only which backends, on which device, with how many threads.
  void add_backends_to(const Command& command);

  /// Whether a backend was named here or with --require.
  [[nodiscard]] bool needs(std::string_view backend) const;

  /// The command line that repeats one comparison; where the scene has no source, with all others.
  [[nodiscard]] std::string repeat(std::string_view command, const Scene& scene,
                                   std::string_view backend) const;

  /// Scenes at sizes in the order they are asked for, each with every method asked for. Without scenes on the
  /// command line: `by_default`, of which one whose files are not on this machine is left out with a line on
  /// standard output. Throws InputError.
  [[nodiscard]] std::vector<Scene> load_scenes(const std::vector<std::string>& by_default) const;
  /// The same without loading them: large ones need not be in memory together.
  [[nodiscard]] std::vector<SceneChoice> scene_choices(const std::vector<std::string>& by_default) const;
  /// None, with a line on standard output, where one that nobody named is not on this machine.
  [[nodiscard]] std::optional<Scene> load(const SceneChoice& choice) const;
  /// The reference first, then the chosen backends (all if none was named) without it. Throws InputError for
  /// an unknown name and DeviceError for one that was named here or with --require and is not there.
  [[nodiscard]] std::vector<const Backend*>
  choose(const std::vector<std::unique_ptr<Backend>>& registry) const;

private:
  /// One entry per method of --methods; none: what --method or the scene says.
  [[nodiscard]] std::vector<std::optional<std::string>> chosen_methods() const;
};

/// Adds --no-cache; without it `session` keeps choices in the user's cache.
void add_choice_cache_to(const Command& command, SessionOptions& session);

/// "300" is 300 x 300, "257x130" is that. Throws InputError.
[[nodiscard]] Extent parse_size(const std::string& text);

/// A word as a shell takes it: in quotes where it has to be.
[[nodiscard]] std::string shell_word(std::string_view word);

/// For those that the command refuses, and says why.
void leave_out_of_help(const Command& command, std::initializer_list<const char*> options);

/// Options that have no effect in a call.
struct Idle {
  bool here = false; ///< whether they have none in this one
  std::vector<std::string> options;
  std::string why; ///< a sentence: "--halo is for several processes: mpirun -n 4 hdmbench run"
};

/// No option is silently ignored. Throws InputError that names those of the first entry that the user gave.
void refuse_idle(const Command& command, std::initializer_list<Idle> idle);

/// The names of the command's options of one group of its help, but those of `but`.
[[nodiscard]] std::vector<std::string> options_of_group(const Command& command, std::string_view group,
                                                        std::initializer_list<std::string_view> but = {});

/// Throws InputError for an option among `words`, the arguments of `command`, that the command does not have;
/// names the one that it may have been.
void require_known_options(const Command& command, const std::vector<std::string>& words);

/// CLI11 drops empty words of a list: it takes "16,,32" for 16 and 32. Throws InputError for such a list
/// among `words`, the arguments of `command`.
void require_whole_lists(const Command& command, const std::vector<std::string>& words);

/// Throws InputError where a file that `command`, which has been parsed, would write is one of those that it
/// reads: what its other arguments name, result files in a folder and the images of a scene among them.
void require_other_outputs(const Command& command);

/// The words after the program's name, as a shell would take them again.
[[nodiscard]] std::string command_line(int argc, const char* const* argv);

} // namespace hdmbench::commands
