#pragma once

#include "kernels/data/field.hpp"

#include <array>
#include <cstddef>
#include <string_view>

/// What everyone outside kernels/ sees of an energy. kernels/README.md has what one must provide.
namespace hdmbench {

struct Level;

/// Which numbers of a site are the same as its neighbours', or not there.
enum class SiteKind {
  general,           ///< observed in a component, the moduli around it differ
  unobserved,        ///< both confidences are 0: no term of the observation is left
  uniform,           ///< all nine moduli are equal: the stiffness ratios and curvatures are constants
  uniform_unobserved ///< both
};
inline constexpr std::size_t site_kinds = 4;

/// Arithmetic of one update by candidates: float additions, subtractions, multiplications, absolute values
/// and comparisons, each one operation, as the texts write them: what occurs twice counts once, what is the
/// same at all sites (candidates, K; with uniform moduli ratios and curvatures) is done once for all and
/// counts nothing, nor does what is multiplied by a confidence of 0. The first candidate is compared with
/// nothing, which `fixed` makes up for.
struct SiteCost {
  int fixed;
  int per_candidate;

  [[nodiscard]] constexpr int operations(int candidates) const { return fixed + per_candidate * candidates; }
};

/// Half the gradient of the prior energy by a site's own displacement and half its second derivatives
/// (kernels/specification/site.inc).
struct PriorAtSite {
  std::array<float, 3> gradient{};  ///< by axis
  std::array<float, 3> curvature{}; ///< of each component by itself
};

/// What the host asks of an energy at one site of an image (z = 0) or a volume, compiled by
/// energy_on_host.cpp from the texts that devices run.
struct EnergyOnHost {
  PriorAtSite (*prior)(const Level& level, const VectorField& displacement, int x, int y, int z);
  /// U_t(d_t) with the observation.
  float (*site_energy)(const Level& level, const VectorField& displacement, int x, int y, int z);
  /// Where one simultaneous sweep over the candidates moves the site to.
  std::array<float, 3> (*improved)(const Level& level, const VectorField& displacement, int x, int y, int z);
  /// The way from each component to the minimiser of its own energy, pixels: 0 at the fixed point. In double.
  std::array<double, 3> (*missing)(const Level& level, const VectorField& displacement, int x, int y, int z);
  /// Row y of slice z of Level::inverse_curvature, which has its size.
  void (*set_inverse_curvature)(Level& level, int y, int z);
};

struct EnergyPrograms; // backends/shared/energy_programs.hpp
struct EnergyProofs;   // harness/check/certificate.hpp

/// One energy. Lives as long as the program.
struct Energy {
  std::string_view name; ///< as on the command line: "hdm"
  int inputs;            ///< Level::inputs that it reads, 0 ... 4
  bool couples;          ///< whether x and y see each other
  int coloured_sets;     ///< sets of sites that move in turn with Update::coloured: 2, or 4 and in volumes 8
  std::array<SiteCost, site_kinds> costs; ///< by SiteKind
  const EnergyOnHost* host;               ///< never null
  const EnergyPrograms* programs;         ///< null: those of the thesis's energy
  const EnergyProofs* proofs;             ///< likewise
};

/// The thesis's energy.
extern const Energy thesis_energy;

} // namespace hdmbench
