#pragma once

#include "harness/scene/scene.hpp"

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// So many that ten times as many are an int.
inline constexpr int largest_effort = 100'000'000;

/// A named way to solve a scene: a schedule over the specification, the same on every backend.
struct Method {
  std::string_view name;    ///< as on the command line and in results: "cascade"
  std::string_view summary; ///< one line for people
  std::string_view effort;  ///< what --iterations counts: "iterations per level", "cycles", ...
  int usual_effort;         ///< iterations where neither scene nor command line says; 0: the scene's own
  std::string_view takes;   ///< the keys that are its own (harness/scene/schedule_keys.hpp): "steps, update"
  /// Sets the schedule up; of the level it changes steps and update.
  void (*configure)(Schedule& schedule, Level& level);
  /// It is the usual one where no two neighbours differ by more: beyond it stalls.
  double most_contrast = std::numeric_limits<double>::infinity();
};

/// The methods that sweep over the sites of the levels, the thesis's own first. They minimise whatever energy
/// of sites a level has.
[[nodiscard]] std::span<const Method> methods();

inline constexpr std::string_view elastic_full_multigrid = "full-multigrid";
inline constexpr std::string_view elastic_conjugate_gradients = "conjugate-gradients";
inline constexpr std::string_view elastic_sweeps = "sweeps";

/// What the minimum of an energy comes near to.
enum class ReferenceSolution {
  fixed_point,     ///< of the energy's own sweeps
  finite_elements, ///< of plane stress with the scene's Poisson ratio
};

/// What a scene's displacement can minimise. All that scenes, methods and commands know of an energy is here.
struct RegisteredEnergy {
  std::string_view name;           ///< in scene files, on the command line and in results: "hdm"
  std::string_view summary;        ///< a few words for people
  std::span<const Method> methods; ///< that minimise it, at least one (usual_method)
  ReferenceSolution near = ReferenceSolution::fixed_point;
  /// What a Session sweeps over site by site. Null: the energy is one of the cells between sites, and an
  /// ElasticSession solves it.
  const Energy* of_sites = nullptr;
  /// Fills Level::inputs of the full resolution; null where of_sites reads none.
  void (*set_inputs)(Level& full) = nullptr;

  bool takes_volumes = false; ///< whether its methods solve volumes, too
  bool takes_boxes = false;   ///< whether it knows pixels that are no squares and voxels that are no cubes
  bool takes_forces = false;  ///< whether it knows Level::force
  bool takes_laws = false;    ///< whether it knows Level::stiffening
  /// Bytes of memory per site that loading a scene, its usual method on `openmp` and writing the field take
  /// in all, about, where no pictures are made. The peaks of `run square --size 4200` and
  /// `run ball --size 260x260x260` were 68 and 93, with the elastic energy 88 and 116; a volume of which no
  /// two rows are alike takes 14 more. Matrices of cells that conditions cut come on top, 2304 bytes each in
  /// a volume.
  int bytes_per_pixel = 60;
  int bytes_per_voxel = 110;

  [[nodiscard]] bool is_of_cells() const { return of_sites == nullptr; }
  /// Whether the method is one of its own.
  [[nodiscard]] bool has(const Method& method) const;
};

/// Returns all energies that can be named, usual_energy() first.
[[nodiscard]] std::span<const RegisteredEnergy* const> registered_energies();
/// Returns their names in the same order.
[[nodiscard]] std::vector<std::string_view> energy_names();
/// Adds an energy, which must live as long as the program, before anything asks for energies by name. Returns
/// true, so that a static object can be initialised with it. Throws std::logic_error where the name is taken.
bool register_energy(const RegisteredEnergy& energy);
/// Throws InputError that lists the names.
[[nodiscard]] const RegisteredEnergy& find_energy(std::string_view name);
/// Returns the first energy whose minimum comes near to such a solution.
[[nodiscard]] const RegisteredEnergy& energy_near(ReferenceSolution solution);
/// Returns the first energy that has the method.
[[nodiscard]] const RegisteredEnergy& energy_of(const Method& method);

/// No two methods have the same name. With `energy` only its own are looked at. Throws InputError that lists
/// the names.
[[nodiscard]] const Method& find_method(std::string_view name, const RegisteredEnergy* energy = nullptr);

/// Returns the first method of the scene's energy that takes the contrast of its moduli.
[[nodiscard]] const Method& usual_method(const Scene& scene);

/// Gives scene.full what scene.energy sweeps over: Level::energy and its inputs.
void set_energy_of_sites(Scene& scene);

/// Throws InputError where the pixels of the scene are no squares or cubes and the energy knows none else.
void require_known_pixels(const Scene& scene, const RegisteredEnergy& energy);

/// Makes `scene` minimise the energy: as its schedule says where the energy has that method, too, else by the
/// energy's usual one.
void use_energy(Scene& scene, const RegisteredEnergy& energy);

/// Makes `scene` use the method, and the first energy that has it where the scene's own does not: schedule,
/// and steps, update and seed of scene.full; `iterations` replaces the usual effort. What the scene says of
/// stop, start level, alignment and conditions stays, but where the energy is another one, to which the
/// schedule does not apply. Throws InputError.
void use_method(Scene& scene, const Method& method, std::optional<int> iterations = std::nullopt);

} // namespace hdmbench
