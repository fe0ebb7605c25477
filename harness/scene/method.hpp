#pragma once

#include "harness/scene/scene.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>

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
  EnergyModel energy = EnergyModel::hdm; ///< which it is for
};

/// All methods of the thesis's energy, its own first.
[[nodiscard]] std::span<const Method> methods();

inline constexpr std::string_view elastic_full_multigrid = "full-multigrid";
inline constexpr std::string_view elastic_conjugate_gradients = "conjugate-gradients";
inline constexpr std::string_view elastic_sweeps = "sweeps";
/// Those of the elastic energy, the usual one first.
[[nodiscard]] std::span<const Method> elastic_methods();

/// The options of a set as the command line calls them: "steps, update"; empty for none.
[[nodiscard]] std::string option_names(unsigned options);

/// No two methods have the same name. With `energy` only its own are looked at. Throws InputError that lists
/// the names.
[[nodiscard]] const Method& find_method(std::string_view name,
                                        std::optional<EnergyModel> energy = std::nullopt);
/// Where nobody says: the first of the energy's.
[[nodiscard]] const Method& usual_method(EnergyModel energy);

/// Makes `scene` use the method and its energy: schedule, and steps, update and seed of scene.full;
/// `iterations` replaces the usual effort. What the scene says of stop, start level, alignment and conditions
/// stays, but for a method of the other energy, to which the schedule does not apply. Throws InputError.
void use_method(Scene& scene, const Method& method, std::optional<int> iterations = std::nullopt);

/// Changes the method that the scene has (scene.schedule.method). Throws InputError, and changes nothing,
/// where that method does not take what is said or a value is out of range.
void set_options(Scene& scene, const MethodOptions& options);

} // namespace hdmbench
