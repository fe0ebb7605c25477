#pragma once

#include "backends/backend.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/progress.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// How far two displacements are apart over all sites, pixels.
struct Distance {
  double rmsd = 0.0;
  double largest = 0.0; ///< of any site
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Distance, rmsd, largest)

/// One row of `continuum`'s results: a sheet with a round inclusion, whose displacement is known in closed
/// form (reference/circular_inclusion.hpp), on one mesh of pixels. The border is prescribed exactly.
struct ContinuumRow {
  std::string energy = "elastic"; ///< of energy_names
  std::int64_t width = 0;
  std::int64_t height = 0;
  double contrast = 1.0; ///< modulus of the inclusion over that around it
  double poisson = 0.0;
  double stretch = 0.0; ///< how much longer the image gets, pixels
  std::string backend{};
  std::string device{};
  std::string method{};          ///< whose error is `algebraic`, at its usual effort
  Distance discretisation{};     ///< finite elements on the pixels, direct, double, from the closed form
  Distance algebraic{};          ///< our field from these finite elements
  Distance rounding{};           ///< our field when no step changes it any more, float32, from them
  Distance total{};              ///< our field from the closed form
  std::optional<double> order{}; ///< in the width, of discretisation.rmsd since the first size; there: none
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ContinuumRow, energy, width, height, contrast, poisson, stretch, backend,
                                   device, method, discretisation, algebraic, rounding, total, order)

/// Images of these sides, rising, at least 8 pixels each. Throws InputError, and what a session throws.
[[nodiscard]] std::vector<ContinuumRow> measure_continuum(double contrast, std::span<const int> sides,
                                                          const Backend& backend,
                                                          const SessionOptions& options, Progress& progress);

} // namespace hdmbench
