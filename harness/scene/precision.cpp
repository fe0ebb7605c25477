#include "harness/scene/precision.hpp"

#include "kernels/data/elastic/springs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

/// Whether a matrix of so many axes has no negative eigenvalue beyond the rounding of its entries: Gaussian
/// elimination finds no negative pivot, and nothing beside one that is 0.
bool is_semidefinite(std::array<std::array<double, 3>, 3> matrix, std::size_t axes) {
  double trace = 0.0;
  for (std::size_t a = 0; a < axes; ++a) {
    trace += std::max(0.0, matrix[a][a]);
  }
  const double rounding = 1e-6 * trace;
  for (std::size_t pivot = 0; pivot < axes; ++pivot) {
    if (!(matrix[pivot][pivot] >= -rounding)) {
      return false;
    }
    for (std::size_t row = pivot + 1; row < axes; ++row) {
      if (matrix[pivot][pivot] <= rounding) {
        // An entry of a semidefinite matrix is at most the root of the product of the two on its diagonal.
        if (std::abs(matrix[row][pivot]) > std::sqrt(2.0 * rounding * trace)) {
          return false;
        }
        continue;
      }
      const double factor = matrix[row][pivot] / matrix[pivot][pivot];
      for (std::size_t column = pivot + 1; column < axes; ++column) {
        matrix[row][column] -= factor * matrix[pivot][column];
      }
    }
  }
  return true;
}

} // namespace

std::optional<std::size_t> find_impossible(const Precision& precision) {
  const std::size_t axes = precision.target.extent.axes();
  for (std::size_t site = 0; site < precision.entries[0].size(); ++site) {
    std::array<std::array<double, 3>, 3> matrix{};
    bool is_finite = true;
    for (std::size_t a = 0; a < axes; ++a) {
      for (std::size_t b = 0; b < axes; ++b) {
        const float entry = precision.entries[symmetric_entry(axes, a, b)][site];
        is_finite = is_finite && std::isfinite(entry);
        matrix[a][b] = double{entry};
      }
    }
    if (!is_finite || !is_semidefinite(matrix, axes)) {
      return site;
    }
  }
  return std::nullopt;
}

CarriedConditions add_precision(Precision precision, Level& level) {
  const std::size_t axes = level.extent.axes();
  level.springs = std::move(precision.entries);
  CarriedConditions carried;
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    std::array<double, 3> pull{};
    std::array<double, 3> otherwise{};
    bool is_observed = false;
    bool is_free = false;
    for (std::size_t a = 0; a < axes; ++a) {
      const float confidence = level.confidence[a][site];
      is_observed = is_observed || level.springs[symmetric_entry(axes, a, a)][site] > 0.0F;
      is_free = is_free || confidence < 1.0F;
      otherwise[a] = double{confidence > 0.0F ? level.target[a][site] : precision.target[a][site]};
      pull[a] = weight_of_confidence(confidence) * double{level.target[a][site]};
      for (std::size_t b = 0; b < axes; ++b) {
        pull[a] +=
            double{level.springs[symmetric_entry(axes, a, b)][site]} * double{precision.target[b][site]};
      }
    }
    if (!is_observed) {
      continue;
    }
    ++carried.given;
    carried.acting += is_free ? 1 : 0;
    const std::array<double, 3> rest = rest_of_springs(level, site, pull, otherwise);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      level.target[axis][site] = static_cast<float>(rest[axis]);
    }
  }
  return carried;
}

} // namespace hdmbench
