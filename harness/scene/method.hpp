#pragma once

#include "harness/scene/scene.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// So many that ten times as many are an int.
inline constexpr int largest_effort = 100'000'000;

/// What a user may say beside a method's name. A method takes some of these and refuses the others.
struct MethodOptions {
  std::optional<int> iterations{};    ///< the method's effort, 0 ... largest_effort
  std::optional<StepSet> steps{};     ///< the candidates
  std::optional<Update> update{};     ///< of icm, for which it is short for another method's name
  std::optional<double> relaxation{}; ///< of the closed form, 0 < w < 2
  std::optional<Cooling> cooling{};   ///< of annealing
  std::optional<int> seed{};          ///< of annealing, 0 ... 4092
};

/// What a method may take beside its effort, as bits of a set.
enum MethodOption : unsigned {
  no_options = 0,
  takes_steps = 1,
  takes_update = 2,
  takes_relaxation = 4,
  takes_temperatures = 8,
  takes_seed = 16,
};

/// A named way to solve a scene: a schedule over the specification, the same on every backend.
struct Method {
  std::string_view name;    ///< as on the command line and in results: "cascade"
  std::string_view summary; ///< one line for people
  std::string_view effort;  ///< what --iterations counts: "iterations per level", "cycles", ...
  int usual_effort;         ///< iterations where neither scene nor command line says; 0: the scene's own
  unsigned options;         ///< a sum of MethodOption
  /// Of the level it changes steps and update.
  void (*configure)(Schedule& schedule, Level& level);
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
  std::span<const Method> methods; ///< that minimise it, at least one, the usual one first
  ReferenceSolution near = ReferenceSolution::fixed_point;
  /// What a Session sweeps over site by site. Null: the energy is one of the cells between sites, and an
  /// ElasticSession solves it.
  const Energy* of_sites = nullptr;
  /// Fills Level::inputs of the full resolution; null where of_sites reads none.
  void (*set_inputs)(Level& full) = nullptr;

  bool takes_volumes = false; ///< whether its methods solve volumes, too

  [[nodiscard]] bool is_of_cells() const { return of_sites == nullptr; }
  /// Whether the method is one of its own.
  [[nodiscard]] bool has(const Method& method) const;
};

/// Returns all energies that can be named, usual_energy() first.
[[nodiscard]] std::span<const RegisteredEnergy* const> energies();
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

/// The options of a set as the command line calls them: "steps, update"; empty for none.
[[nodiscard]] std::string option_names(unsigned options);

/// No two methods have the same name. With `energy` only its own are looked at. Throws InputError that lists
/// the names.
[[nodiscard]] const Method& find_method(std::string_view name, const RegisteredEnergy* energy = nullptr);

/// Gives scene.full what scene.energy sweeps over: Level::energy and its inputs.
void set_energy_of_sites(Scene& scene);

/// Makes `scene` minimise the energy: as its schedule says where the energy has that method, too, else by the
/// energy's usual one.
void use_energy(Scene& scene, const RegisteredEnergy& energy);

/// Makes `scene` use the method, and the first energy that has it where the scene's own does not: schedule,
/// and steps, update and seed of scene.full; `iterations` replaces the usual effort. What the scene says of
/// stop, start level, alignment and conditions stays, but where the energy is another one, to which the
/// schedule does not apply. Throws InputError.
void use_method(Scene& scene, const Method& method, std::optional<int> iterations = std::nullopt);

/// Changes the method that the scene has (scene.schedule.method). Throws InputError, and changes nothing,
/// where that method does not take what is said or a value is out of range.
void set_options(Scene& scene, const MethodOptions& options);

} // namespace hdmbench
