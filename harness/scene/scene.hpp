#pragma once

#include "harness/scene/carried_conditions.hpp"
#include "harness/scene/file_grid.hpp"
#include "harness/scene/placement.hpp"
#include "harness/scene/points.hpp"
#include "harness/scene/sites.hpp"
#include "harness/scene/walls.hpp"
#include "kernels/data/modulus.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// When the iterations of a level end.
enum class Stop {
  fixed,  ///< after exactly `iterations`
  still,  ///< when no site changed, at the latest after `iterations`
  energy, ///< when the mean energy moved by less than `epsilon` (thesis 5.3), at the latest after
          ///< `iterations`
};

/// What scene files call them, in the order of the enumerators.
inline constexpr std::array<std::string_view, 3> stop_names{"fixed", "still", "energy"};
inline constexpr std::array<std::string_view, 2> integration_names{"full", "selective-reduced"};
inline constexpr std::array<std::string_view, 2> alignment_names{"corner", "center"};
inline constexpr std::array<std::string_view, 4> update_names{"simultaneous", "sequential", "coloured",
                                                              "four-coloured"};

/// Relaxation of the closed form.
struct Relaxation {
  double factor = 1.0; ///< of every sweep where reach is 0: 1 is the minimiser itself, 0 < factor < 2
  /// > 0: Chebyshev acceleration of two colours (as SOR with a factor per sweep) that damps waves up to
  /// `reach` times as long as the level's iterations carry information.
  double reach = 0.0;
  double largest = 2.0; ///< no factor above this
  int settling = 0;     ///< the last iterations of a level that has more than these go with factor 1
};

/// Cooling of the annealing: temperature(i) = highest * (lowest / highest)^(i / (iterations - 1)) on every
/// level.
struct Cooling {
  double highest = 1.0; ///< energy units, > 0
  double lowest = 1e-3; ///< > 0
};

struct RegisteredEnergy; // harness/scene/method.hpp
/// Returns the energy of a scene that names none: the thesis's.
[[nodiscard]] const RegisteredEnergy& usual_energy();

/// How the pyramid is run: thesis Alg. 3, from the coarsest level to the finest, each once. The order of
/// sites, the candidates and the seed are the level's. Of the elastic energy `iterations` counts steps on the
/// full resolution.
struct Schedule {
  std::string method = "icm"; ///< a name of harness/scene/method.hpp
  int iterations = 50;        ///< per level, exact or at most, see stop and growth; >= 0
  Stop stop = Stop::fixed;
  double epsilon = 1e-6;          ///< for Stop::energy
  std::optional<int> start_level; ///< first level computed, 0 = full resolution; none: the coarsest
  Alignment alignment = Alignment::corner;
  Rule rule = Rule::steps; ///< of the levels, which get it with what it needs (LevelSequence)
  double growth = 0.0;     ///< a level of n sites a side gets iterations * (full side / n)^growth of them ...
  double most_per_side = 0.0; ///< ... but at most this times n, 0: no limit
  double skip_nearer =
      1.0; ///< a level is left out where the finer one has less than this times its sites a side
  bool mean_modulus =
      false; ///< coarse levels take the mean of the moduli they stand for, not the nearest one
  Relaxation relaxation{};
  Cooling cooling{};
};

/// How much the observation counts beside the prior. Only the ratio matters: U = alpha prior +
/// (1 - alpha) observation (3.17) has the minima of prior + (1 - alpha) / alpha observation.
struct ObservationWeight {
  double penalty = 1000.0;   ///< K of (4.17), > 0
  double prior_weight = 0.5; ///< alpha of (3.17), 0 < alpha < 1

  /// K (1 - alpha) / alpha as Level::penalty has it; exactly K where alpha = 0.5. Throws InputError where K
  /// or alpha is out of range or float cannot hold the product.
  [[nodiscard]] float product() const;
};

/// Tissue that was taken out of a loaded body.
struct Resected {
  std::size_t sites = 0; ///< that are void now
  double sag = 0.0;      ///< how far the loads of before had moved one of them at most, along an axis, pixels
  double seconds = 0.0;  ///< that it took to find what it bore
};

/// A problem at full resolution together with the way the thesis solves it.
struct Scene {
  std::string name;                 ///< "square"
  std::string source;               ///< the name or path it was loaded by; empty: no command line loads it
  std::string title;                ///< one line for people
  Level full;                       ///< the finest level: everything but the displacement
  std::optional<VectorField> start; ///< displacement to begin with, pixels; none: the null field
  ScalarField picture;   ///< gray values 0 ... 255, only to look at; empty where !is_inspected(extent())
  LabelField labels;     ///< the segmentation the moduli come from; empty where there was none, likewise
  double spacing = 1.0;  ///< millimetres per pixel, of its shortest side
  Placement placement{}; ///< of the pixels in the patient
  std::optional<FileGrid> oblong{};            ///< its file's own pixels, where their sides are not the same
  Stated stated = Stated::sides;               ///< what its files say of spacing and placement
  std::optional<CarriedConditions> observed{}; ///< the pixels of its images of targets; none: it has no such
  std::vector<KnownPoint> points{};            ///< known displacements between the sites
  std::vector<std::string> idle{};             ///< what of its file has no effect, and why
  const RegisteredEnergy* energy = &usual_energy(); ///< that the displacement minimises; never null
  const RegisteredEnergy* stated_energy = nullptr;  ///< that the scene file names itself; null: none
  ElasticModel elastic{}; ///< for finite elements and the elastic energy; HDM has no such thing
  /// The body before tissue was taken out of it: what holds it, and the loads that act on it all the time.
  /// None: nothing was, or unload() (harness/solve/unloading.hpp) has made forces of what that carried.
  std::optional<Level> before{};
  std::optional<Resected> resected{}; ///< what unload() took out; none: nothing
  /// Declared, and checked by verify: every intermediate of every sweep is exact in float32, so that no
  /// compiler's choice of operations can change a bit.
  bool exact = false;
  bool has_own_normals = false; ///< of walls, from an image, not from pixels of labels
  /// None: there are no walls, or somebody has said how far their normals look, or what they are.
  std::optional<TurnOfNormals> turn_of_normals{};
  Schedule schedule;
  ObservationWeight weight; ///< changed by set_weight, whose product is full.penalty

  [[nodiscard]] Extent extent() const { return full.extent; }
  /// The start, null or not, with a value for every site.
  [[nodiscard]] VectorField start_field() const;
  /// The same at the sites of a level.
  [[nodiscard]] VectorField start_at(Extent level) const;
};

/// Returns the sum of all loads in the patient's space (LPS): newtons, of an image newtons per millimetre of
/// thickness.
[[nodiscard]] std::array<double, 3> resultant_of_loads(const Scene& scene);

/// Sets scene.weight and, to its product, scene.full.penalty. Throws InputError and changes nothing.
void set_weight(Scene& scene, const ObservationWeight& weight);

/// Sets scene.schedule.start_level. Throws InputError for one that the pyramid does not have.
void set_start_level(Scene& scene, int level);

/// What the command line may change about a scene file.
struct SceneOptions {
  std::optional<Extent> size{}; ///< pixels; none: the file's own
  /// The orientation of a [brain], in place of the file's: "axial", "coronal" or "sagittal". Empty: the
  /// file's, and its slice.
  std::string orientation{};
  std::optional<int> slice{};      ///< of that orientation; none: the one that shows most of the brain
  std::filesystem::path tissues{}; ///< of a scene that is an image of labels, as of scene_of_labels()
  std::vector<std::filesystem::path> points{}; ///< more than the file's own, as of apply_points()
  std::vector<PointPair> pairs{};              ///< the same, read already
  std::string law{}; ///< of all tissues that state none, in place of the file's: "neo-hookean". Empty: that
  std::optional<std::size_t> idle_point{}; ///< the one of Scene::points that does not act
  /// That it will minimise, whatever its file says; null: the file's. With the elastic energy, and without
  /// `size`, the pixels of an image stay rectangles and its voxels boxes (Level::sides), unless `as_cubes`.
  const RegisteredEnergy* energy = nullptr;
  bool as_cubes = false;
};

/// Returns 1 at the sites of tissue and 0 at those of void; empty where the scene has no void.
[[nodiscard]] ScalarField tissue_of(const Scene& scene);

/// Whether an image, of at most 4096 x 4096 sites, is looked at closely: its scene has a picture and labels,
/// `run` draws and diagnoses it. Beyond, that would take more time and memory than the solution itself.
[[nodiscard]] bool is_inspected(Extent extent);

/// Throws InputError for an image or a volume that this machine's memory cannot hold while the energy is
/// minimised, before the kernel kills the program for it.
void require_memory(Extent extent, const RegisteredEnergy& energy = usual_energy());
/// The same for what takes `per_site` bytes times the number of sites to a power. `who` begins the message.
void require_memory(Extent extent, double per_site, double power = 1.0, std::string_view who = {});
/// The same of a scene, with what its laws of large strains and the form of its pixels take.
void require_memory(const Scene& scene);

/// The shipped images in the order of the thesis, then the brain, then what is only for verify.
[[nodiscard]] std::vector<std::string> shipped_scenes();
/// The shipped volumes.
inline constexpr std::array<std::string_view, 4> shipped_volumes{"cube", "ball", "head", "sliding-head"};

/// A line of the list of scenes: what a shipped scene says of itself.
struct SceneSummary {
  std::string name;
  std::string title;
  std::string size; ///< "64 x 64 x 64", or that its files have it
};
/// All of them, images first.
[[nodiscard]] std::vector<SceneSummary> scene_summaries();

/// Returns whether the scene's file states a size of three sides; false where it states none, or cannot be
/// read.
[[nodiscard]] bool states_volume(const std::string& scene);
/// Returns whether a scene's own size is that of its files: of an [image], or a whole head; false where it
/// cannot be read.
[[nodiscard]] bool has_pixels_of_files(const std::string& scene);

/// The files that a scene is made of: the TOML file and what it names, where it is there. Nothing where it is
/// no scene.
[[nodiscard]] std::vector<std::filesystem::path> files_of_scene(const std::string& scene);

/// `scene` is the name of a shipped scene or the path of a TOML file (harness/scene/scenes/README.md), with
/// options.tissues that of an image of labels. Throws
/// InputError with file, line where there is one, and what to do; MissingFile where a file that the scene
/// refers to, or what is needed to read it, is not on this machine.
[[nodiscard]] Scene load_scene(const std::string& scene, const SceneOptions& options = {});

} // namespace hdmbench
