#include "harness/scene/precision.hpp"

#include "kernels/data/elastic/springs.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

/// Whether a matrix has no negative eigenvalue beyond the rounding of its entries.
bool is_semidefinite(const Eigen::Matrix3d& matrix) {
  const double rounding = 1e-6 * std::max(0.0, matrix.trace());
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[0] >=
         -rounding;
}

} // namespace

std::optional<std::size_t> find_impossible(const Precision& precision) {
  const std::size_t axes = precision.target.extent.axes();
  for (std::size_t site = 0; site < precision.entries[0].size(); ++site) {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    bool is_finite = true;
    for (std::size_t a = 0; a < axes; ++a) {
      for (std::size_t b = 0; b < axes; ++b) {
        const float entry = precision.entries[symmetric_entry(axes, a, b)][site];
        is_finite = is_finite && std::isfinite(entry);
        matrix(static_cast<int>(a), static_cast<int>(b)) = double{entry};
      }
    }
    if (!is_finite || !is_semidefinite(matrix)) {
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
      if (is_on_wall(level, site)) {
        set_rest_on_wall(level, site);
      }
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
