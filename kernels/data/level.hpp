#pragma once

#include "kernels/data/energy.hpp"
#include "kernels/data/field.hpp"
#include "kernels/data/step_set.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace hdmbench {

/// In which order the sites move.
enum class Update {
  simultaneous, ///< all sites read the old field and write the new one: the design for GPUs
  sequential,   ///< raster order, in place: the thesis's CPU design
  coloured,     ///< as many sets in turn as the energy needs, so that within a set no site sees another:
                ///< Energy::coloured_sets, two for the thesis's (update.inc)
  four_coloured ///< four sets in turn, the sites by the parity of column and row (thesis 9.6.2); eight in a
                ///< volume, by that of the slice, too
};

/// Where a site moves to: the rules of update.inc, in their order.
enum class Rule {
  steps,       ///< the best of the candidates: ICM
  closed_form, ///< the exact minimiser of the site's energy, relaxed
  annealing    ///< a candidate at random, taken by its energy and the temperature (thesis Alg. 1)
};

struct Law;

/// The most that the longest side of a pixel or a voxel is over the shortest: methods take the longer, the
/// longer boxes are (the atlas's volume-elastic-boxes).
inline constexpr double most_oblong = 10.0;

/// One level of the pyramid: all that a sweep reads and does not write.
struct Level {
  Extent extent;
  const Energy* energy = &thesis_energy; ///< never null
  VectorField target{};                  ///< y, pixels of the full resolution image
  VectorField confidence{};              ///< c in [0, 1] per component, 0 = unknown
  ScalarField modulus{};                 ///< m > 0, MPa
  ScalarField inverse_modulus{};         ///< 1 / m rounded to float
  std::vector<ScalarField> inputs{};     ///< Energy::inputs of them, the energy's own numbers of a site
  float penalty = 1.0F;                  ///< K > 0
  StepSet steps{};                       ///< of Rule::steps and annealing
  Update update = Update::simultaneous;
  Rule rule = Rule::steps;
  VectorField inverse_curvature{}; ///< 1 / A per component; needed by closed_form, else empty
  /// Per sweep since load(), the last one for all that follow: relaxation (0 < w < 2) of
  /// closed_form, 1 / temperature (>= 0) of annealing. Empty for Rule::steps.
  std::vector<float> strengths{};
  int seed = 0; ///< of annealing, 0 ... 4092; of rows of an image it carries the row, too (update.inc)
  /// The sides of a pixel or a voxel over the shortest of them, which is the unit of displacements: 1 of
  /// squares and cubes, which the thesis's energy knows alone; of an image the third is 1.
  std::array<double, 3> sides{1.0, 1.0, 1.0};
  /// The load on every site, over the area or the volume of a pixel or voxel whose sides are those: MPa over
  /// a shortest side. Empty: there is none. Elastic energies alone know it.
  VectorField force{};
  const Law* law = nullptr; ///< how tissue answers to large strains; null: as law_of() says
  /// The law's parameter at every site, which of the shipped one is 0 for neo-Hookean tissue and above 0
  /// where it stiffens with the strain. Below 0 the tissue is linear. Empty: all is. Elastic energies alone
  /// know it.
  ScalarField law_parameter{};
  /// The fibres of every site's tissue: a unit vector along them, times the fourth root of their modulus over
  /// the tissue's (specification/laws/fibres.inc). Empty: there are none. Laws of large strains alone know
  /// it.
  VectorField fibre{};
  ScalarField
      fibre_compression{}; ///< 0: they bear tension only; 1: they bear the same when they are shortened
  /// What pulls a site to its target by direction, times the modulus of the site: symmetric_entry() of a
  /// matrix (elastic/springs.hpp). Empty: there is none. Elastic energies alone know it.
  std::vector<std::vector<float>> springs{};
  /// What keeps a site on walls along which tissue slides, with entries like those of `springs`, at rest on
  /// the wall. Empty: there are none.
  std::vector<std::vector<float>> walls{};
  bool has_walls = false; ///< whether there are walls, also where these arrays are elsewhere
};

/// Whether some tissue has a law of large strains.
[[nodiscard]] inline bool has_laws(const Level& level) {
  return !level.law_parameter.values.empty();
}

[[nodiscard]] inline bool has_fibres(const Level& level) {
  return !level.fibre[0].empty();
}

/// Whether anything but conditions moves the sites.
[[nodiscard]] inline bool has_forces(const Level& level) {
  return !level.force[0].empty();
}

/// What update.inc's Sweep holds, for sweep `number` (from 0) since the level was loaded.
struct SweepState {
  float colour = 0.0F;
  float strength = 0.0F;
  float number = 0.0F;
  float seed = 0.0F;
};

/// How many sweeps make one iteration, every component once: as many as there are sets of sites that move in
/// turn.
[[nodiscard]] inline int sweeps_per_iteration(const Level& level) {
  const int by_all_parities = level.extent.axes() > 2 ? 8 : 4;
  switch (level.update) {
  case Update::coloured:
    return level.energy->coloured_sets == 2 ? 2 : by_all_parities;
  case Update::four_coloured:
    return by_all_parities;
  default:
    return 1;
  }
}

/// The level without its arrays: all that sweep_state() reads, cheap to keep.
[[nodiscard]] Level without_fields(const Level& level);

[[nodiscard]] inline SweepState sweep_state(const Level& level, int number) {
  SweepState state{.colour = static_cast<float>(number % sweeps_per_iteration(level)),
                   .number = static_cast<float>(number),
                   .seed = static_cast<float>(level.seed)};
  if (!level.strengths.empty()) {
    state.strength = level.strengths[std::min(static_cast<std::size_t>(number), level.strengths.size() - 1)];
  }
  return state;
}

/// Whether the rule reads inverse_curvature.
[[nodiscard]] constexpr bool needs_inverse_curvature(Rule rule) {
  return rule == Rule::closed_form;
}

/// Whether a site can only change in a sweep if it or one of its neighbours changed in the sweep
/// before: what lets Work::active (backends/backend.hpp) leave out the rest. True for candidates with
/// simultaneous updates; other rules differ from sweep to sweep.
[[nodiscard]] bool changes_spread_by_contact(const Level& level);

/// Fills inverse_modulus from modulus.
void set_inverse_modulus(Level& level);

/// Fills inverse_curvature from the moduli: 1 / A of every site and component, rounded to float.
void set_inverse_curvature(Level& level);

/// U = (1/|S|) * sum of U_t (5.2): each site's energy in float as the kernels define it, summed in double in
/// raster order, so the figure does not depend on threads or devices.
[[nodiscard]] double mean_energy(const Level& level, const VectorField& displacement);

/// Sites of one component that no known displacement reaches, however far it travels.
struct Undetermined {
  std::size_t sites = 0;
  std::size_t first = 0; ///< index of the first of them
};

/// A component sees the neighbours on both sides in its own direction, straight and diagonal: that connects
/// all sites of an image or volume at least two sites thick in that direction, and none of a thinner one.
/// `thickness` is the width for x, the height for y and the depth for z; one `confidence` per site, 0 =
/// unknown.
[[nodiscard]] Undetermined find_undetermined(int thickness, std::span<const float> confidence);

/// Throws InputError where a side of an image is < 1, or one of a volume < 2.
void require_sides(Extent extent);

/// Throws InputError naming the field and the first offending site: a size that does not match the extent, a
/// value that is not finite, modulus <= 0 or without a finite inverse, confidence outside [0, 1], K <= 0,
/// strengths or inverse_curvature that the rule needs and that are missing or out of range.
void validate(const Level& level);

/// Throws InputError where a component is not finite or the size is not `extent`; `what` names the field.
void validate(const VectorField& field, Extent extent, const char* what);

} // namespace hdmbench
