#pragma once

#include "backends/registry.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/names.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/request.hpp"
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

using nlohmann::json;

/// Those that several commands have.
namespace option {
inline const Option<std::string> scene("scene", "Scene by name or TOML file");
inline const Option<std::vector<std::string>>
    scenes("scenes", "Scenes by name or TOML file (none: all that the command is made for)");
inline const Option<std::string> size("--size", "Size: 300 (square), 257x130 or, of a volume, 64x64x64");
inline const Option<std::vector<std::string>>
    sizes("--sizes,--size", "Sizes: 300 (square), 257x130 or, of volumes, 64x64x64, several with commas");
inline const Option<std::vector<std::string>>
    methods("--methods",
            "Several methods with commas, or all of them, instead of --method (tradeoff: rivals too)");
inline const Option<std::string>
    orientation("--orientation", "Of a [brain]: axial, coronal or sagittal, in place of the scene's own", {},
                CLI::IsMember(std::vector<std::string>(orientation_names.begin(), orientation_names.end())));
inline const Option<std::optional<int>>
    slice("--slice", "Of that orientation; default: the one that shows most of the brain");
inline const Option<std::filesystem::path>
    tissues("--tissues",
            "The scene is an image of labels, and this file has the [[tissue]] of each of them, and what "
            "else of a scene is not to be as usual (elastic, the border held); or synthseg or brain, whose "
            "moduli are shipped",
            Content::toml);
inline const Option<std::string>
    law("--law",
        "Law of all tissues whose [[tissue]] states none: linear, or neo-hookean, which holds for large "
        "strains, with the elastic energy",
        {}, CLI::IsMember({"linear", "neo-hookean"}));
inline const Option<std::vector<std::filesystem::path>> points(
    "--points,--landmarks",
    "Points that have moved: a file of 3D Slicer's of before and one of after (.fcsv, .mrk.json), "
    "or one with lines of x y z dx dy dz (mm, LPS); or a surface before and after (.vtk, .ply, .obj, .stl) "
    "with SPACE=LPS or RAS in its header",
    Content::points);
inline const Option<std::string> backend("--backend", "Backend that computes", "openmp");
inline const Option<std::vector<std::string>>
    backends("--backends", "Backends with commas (none: all; one that is named must be there)");
inline const Option<std::vector<std::string>> require("--require",
                                                      "Backends that must be there, others may be skipped");
inline const Option<std::string> device("--device", "Device by part of its name or by number (see devices)");
inline const Option<int> threads("--threads", "CPU threads (0: all)", 0, CLI::Range(0, 4096));
inline const Option<bool> quick("--quick", "A shorter run; the results say so");
inline const Option<bool> list("--list", "Name the entries and stop");
inline const Option<int> repeat("--repeat", "Samples per backend, scene and size", 3,
                                CLI::Range(1, 1'000'000));
inline const Option<OutputFile> json("--json", "Write the results to this file");
inline const Option<OutputFolder> output("--output", "Folder for the files, made if missing",
                                         "hdmbench-output");
inline const Option<std::string> format("--format",
                                        "Format of fields and images: nrrd, mha or nii.gz (NIfTI)", "nrrd",
                                        CLI::IsMember({"nrrd", "mha", "nii.gz"}));
} // namespace option

/// --method and the schedule_keys(); with --energy where the command takes_energies.
[[nodiscard]] Options schedule_options(bool takes_energies);
/// The names of those that a command has, but those of `but`.
[[nodiscard]] std::vector<std::string> schedule_names(const CLI::App& command,
                                                      const std::vector<std::string>& but);
/// Where one scene is computed.
[[nodiscard]] Options backend_options();
/// Which backends are compared, on which device, with how many threads.
[[nodiscard]] Options backends_options();
/// Which scenes at which sizes, solved how.
[[nodiscard]] Options scenes_options();
/// All that commands have that compare backends on scenes.
[[nodiscard]] Options comparison_options();

/// The scene that `name` says, at the call's size with its schedule. Throws InputError.
[[nodiscard]] Scene scene_of(const Call& call, const Option<std::string>& name = option::scene);
/// Throws InputError on all ranks where one has other scenes than the first, another file by the same name
/// among them, or another build. Collective; nothing in one process.
void require_same_scenes(const Call& call, std::span<const Scene> scenes);
/// The one backend of a call, which lives as long as the registry. Throws InputError where it is unknown or
/// cannot update as the scene wants.
[[nodiscard]] const Backend&
choose_backend(const Call& call, const std::vector<std::unique_ptr<Backend>>& registry, const Scene& scene);

/// Loads a scene, which may be large.
using SceneLoader = std::function<std::optional<Scene>()>;

/// What `load` gives; none, with a line on standard output, where its files are not on this machine, unless
/// it `is_needed`: then throws MissingFile.
[[nodiscard]] std::optional<Scene> load_unless_missing(std::string_view name, bool is_needed,
                                                       const std::function<Scene()>& load);
/// The scenes of a call at its sizes in the order they are asked for, each with every method asked for; those
/// of `by_default` where no scene is on the command line. Valid as long as the call. Throws InputError.
[[nodiscard]] std::vector<SceneLoader> scene_loaders(const Call& call,
                                                     const std::vector<std::string>& by_default);
[[nodiscard]] std::vector<Scene> load_scenes(const Call& call, const std::vector<std::string>& by_default);

/// Whether a backend was named with --backends or --require.
[[nodiscard]] bool needs(const Call& call, std::string_view backend);
/// The reference first, then the chosen backends (all if none was named) without it; scalar is the
/// reference where `reference` is empty, none is where it is "none". Throws InputError for an unknown name,
/// or where nothing is left to run, and DeviceError for one that was named and is not there.
[[nodiscard]] std::vector<const Backend*>
choose_backends(const Call& call, const std::vector<std::unique_ptr<Backend>>& registry,
                const std::string& reference = {});

/// What a check ends with: disagreement where it is not `good`. `missing` says what was asked for and not
/// compared, empty where nothing is: then it has not passed either, which is said, and the environment or the
/// input is at fault.
[[nodiscard]] ExitStatus ended(const Call& call, bool good, std::string_view missing);

/// " --device 1 --threads 2" as far as they were given.
[[nodiscard]] std::string session_words(const SessionOptions& session);
/// The arguments that a schedule was given, each with a space before it: " --iterations 5"; with
/// `other_method` in place of the one given, where there is one.
[[nodiscard]] std::string schedule_words(const ScheduleOverrides& schedule,
                                         const std::optional<std::string>& other_method = std::nullopt);
/// " --size 300x300", by which a command takes the scene as it is; empty where its pixels are those of a
/// file that are no squares: a size would make squares of them.
[[nodiscard]] std::string size_words(const Scene& scene);
/// The command line that repeats what one backend did, with so many threads where that is above 0; where the
/// scene has no source, with all others.
[[nodiscard]] std::string repeat_line(const Call& call, const Scene& scene, std::string_view backend,
                                      int threads = 0);

/// "300" is 300 x 300, "257x130" and "64x64x64" are that. Throws InputError, also where no scene of that size
/// fits into memory.
[[nodiscard]] Extent parse_size(const std::string& text);
/// The same; none where `text` is empty.
[[nodiscard]] std::optional<Extent> parse_any_size(const std::string& text);

/// How the result file `results` names a file of `folder`; the bare name where there is no result file.
[[nodiscard]] std::string beside(const std::filesystem::path& results, const std::filesystem::path& folder,
                                 const std::string& name);

/// The lists of all ranks as one, by rank, on the first one; nothing on the others. Collective.
[[nodiscard]] nlohmann::json gather_rows(const nlohmann::json& own, Ranks& ranks);
/// The network's name of this machine; empty where it has none.
[[nodiscard]] std::string machine_name();

/// A word as a shell takes it: in quotes where it has to be.
[[nodiscard]] std::string shell_word(std::string_view word);

/// --require-hardware and --fail-on-skip, and --baseline of `verify`.
[[nodiscard]] Options gate_options(bool with_baseline = false);

/// What a continuous integration of drivers asks of a command beyond its own verdict: nothing that was not
/// compared may pass.
class Gates {
public:
  /// Before the command runs. Where hardware is required, leaves backends with software only out of those of
  /// the call, with a line on standard output; scalar and openmp, which claim to be no GPU, stay. Where there
  /// is a baseline, the call gets a file for the results. Throws DeviceError where a backend that was named
  /// has software only, or no hardware is left, and InputError for a baseline that cannot be read.
  explicit Gates(Call& call);

  /// After it: `status`, or disagreement where that was success and a backend was skipped or something that
  /// agreed in the baseline does not agree, or is not there, in the results. Says which. Throws InputError.
  /// The baseline is compared by the process that speaks.
  [[nodiscard]] int judge(int status, const Call& call) const;

private:
  std::string skipped_; ///< lines: backends, and why
  std::optional<TemporaryDirectory> folder_{};
};

} // namespace hdmbench::commands
