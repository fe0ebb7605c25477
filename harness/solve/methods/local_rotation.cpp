#include "harness/solve/methods/local_rotation.hpp"

#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

namespace hdmbench {

namespace {

constexpr int nodes_a_side = 40;  ///< at most twice as many
constexpr int nodes_to_look = 16; ///< at most, and one: where tissue hardly turns they cost little
constexpr double worth_a_look = 0.75;
constexpr double reach = 0.05; ///< of each of two means, one of the other, to each side, in longest sides
/// Between nodes that turn against each other there is no rotation.
constexpr float least_determinant = 0.25F;
/// Turns below do not matter, degrees. Where the axes of walls stay and those beside them turn, cycles take
/// more steps at first: test/walls_test counts them.
constexpr double least_turn = 20.0;
constexpr double least_turn_at_walls = 30.0;

int longest_side(Extent extent) {
  return std::max({extent.width, extent.height, extent.depth});
}

/// The sum of gradients of sites, and how many they are.
struct Sum {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  double sites = 0.0;

  void add(const Sum& other, double times = 1.0) {
    gradient += times * other.gradient;
    sites += times * other.sites;
  }
};

/// Makes every sum that of the nodes up to `radius` away along an axis.
void add_neighbours(Extent nodes, std::size_t axis, int radius, std::vector<Sum>& sums) {
  const std::array<std::size_t, 3> steps{1, nodes.index(0, 1), nodes.index(0, 0, 1)};
  const int length = nodes.sides()[axis];
  std::vector<Sum> line(static_cast<std::size_t>(length));
  for (std::size_t first = 0; first < sums.size(); ++first) {
    if (nodes.coordinates(first)[axis] != 0) {
      continue;
    }
    for (int i = 0; i < length; ++i) {
      Sum around;
      for (int j = std::max(i - radius, 0); j <= std::min(i + radius, length - 1); ++j) {
        around.add(sums[first + static_cast<std::size_t>(j) * steps[axis]]);
      }
      line[static_cast<std::size_t>(i)] = around;
    }
    for (std::size_t i = 0; i < line.size(); ++i) {
      sums[first + i * steps[axis]] = line[i];
    }
  }
}

/// Returns the rotation nearest to a gradient of places, by Newton's method (Higham 1986); none of one that
/// turns over.
Eigen::Matrix3d rotation_in(const Eigen::Matrix3d& gradient) {
  constexpr int most = 8;
  constexpr double enough = 1e-6; // floats are made of it
  Eigen::Matrix3d rotation = gradient;
  for (int step = 0; step < most; ++step) {
    if (!(rotation.determinant() > 0.0)) {
      return Eigen::Matrix3d::Identity();
    }
    const Eigen::Matrix3d half_way = 0.5 * (rotation.inverse().transpose() - rotation);
    rotation += half_way;
    if (half_way.squaredNorm() < enough * enough) {
      break;
    }
  }
  return rotation;
}

/// The derivatives of a displacement at sites: differences of both neighbours, at a border of one.
class Gradients {
public:
  Gradients(const Level& level, const VectorField& displacement)
      : level_(level), displacement_(displacement),
        least_(void_modulus(level)), steps_{1, level.extent.index(0, 1), level.extent.index(0, 0, 1)} {}

  /// Adds that of a site whose neighbours are tissue as it is.
  void add(const std::array<int, 3>& at, Sum& sum) const {
    const std::size_t site = level_.extent.index(at[0], at[1], at[2]);
    const std::size_t axes = level_.extent.axes();
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    for (std::size_t along = 0; along < axes; ++along) {
      const std::size_t before = at[along] > 0 ? site - steps_[along] : site;
      const std::size_t behind = at[along] + 1 < level_.extent.sides()[along] ? site + steps_[along] : site;
      if (before == behind || !is_tissue(before) || !is_tissue(behind)) {
        return;
      }
      const double way = level_.sides[along] * (before != site && behind != site ? 2.0 : 1.0);
      for (std::size_t axis = 0; axis < axes; ++axis) {
        gradient(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(along)) =
            (double{displacement_[axis][behind]} - double{displacement_[axis][before]}) / way;
      }
    }
    sum.gradient += gradient;
    sum.sites += 1.0;
  }

private:
  [[nodiscard]] bool is_tissue(std::size_t site) const { return level_.modulus.values[site] >= least_; }

  const Level& level_;
  const VectorField& displacement_;
  float least_;
  std::array<std::size_t, 3> steps_;
};

/// Returns the mean gradient around every node of a coarse grid.
std::vector<Eigen::Matrix3d> mean_gradients(const Level& level, const VectorField& displacement, int stride,
                                            Extent nodes) {
  std::vector<Sum> sums(nodes.sites());
  const Gradients gradients(level, displacement);
#pragma omp parallel for if (level.extent.sites() > sites_worth_threads)
  for (int row = 0; row < nodes.rows(); ++row) { // all sites that are nearest to its nodes
    const auto sites_of = [&](int node, int all) {
      return std::pair{std::max(node * stride - stride / 2, 0),
                       std::min(node * stride - stride / 2 + stride, all)};
    };
    const auto [top, bottom] = sites_of(row % nodes.height, level.extent.height);
    const auto [front, back] = sites_of(row / nodes.height, level.extent.depth);
    const int every = std::max(stride / 2, 1); // a mean needs no more sites
    for (int z = front; z < back; z += every) {
      for (int y = top; y < bottom; y += every) {
        for (int x = 0; x < level.extent.width; x += every) {
          const int node = std::min((x + stride / 2) / stride, nodes.width - 1);
          gradients.add({x, y, z}, sums[nodes.index(node, row)]);
        }
      }
    }
  }
  const int radius =
      static_cast<int>(std::lround(reach * static_cast<double>(longest_side(level.extent)) / stride));
  for (int time = 0; time < 2; ++time) {
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      add_neighbours(nodes, axis, radius, sums);
    }
  }
  std::vector<Eigen::Matrix3d> means(sums.size());
  std::ranges::transform(sums, means.begin(), [](const Sum& sum) -> Eigen::Matrix3d {
    return sum.gradient / std::max(sum.sites, 1.0);
  });
  return means;
}

} // namespace

LocalRotation::LocalRotation(const Level& level, const VectorField& displacement, int stride)
    : level_(&level), stride_(stride) {
  const auto nodes = [&](int sites) { return (sites - 2 + stride_) / stride_ + 1; };
  nodes_ = {nodes(level.extent.width), nodes(level.extent.height), nodes(level.extent.depth)};
  for (const Eigen::Matrix3d& mean : mean_gradients(level, displacement, stride_, nodes_)) {
    const Eigen::Matrix3d rotation = rotation_in(Eigen::Matrix3d::Identity() + mean);
    const double degrees =
        std::acos(std::clamp(0.5 * (rotation.trace() - 1.0), -1.0, 1.0)) * 180.0 / std::numbers::pi;
    if (degrees > largest_.degrees) {
      const std::array<int, 3> node = nodes_.coordinates(rotations_.size());
      const auto site = [&](std::size_t axis) {
        return std::min(node.at(axis) * stride_, level.extent.sides()[axis] - 1);
      };
      largest_ = {.degrees = degrees, .site = level.extent.index(site(0), site(1), site(2))};
    }
    Eigen::Map<Eigen::Matrix3f>(rotations_.emplace_back().data()) = rotation.cast<float>();
  }
}

std::optional<LocalRotation> LocalRotation::of(const Level& level, const VectorField& displacement) {
  const double least = level.has_walls ? least_turn_at_walls : least_turn;
  const int longest = longest_side(level.extent);
  const int stride = std::max(longest / nodes_a_side, 1);
  const int to_look = (longest + nodes_to_look - 1) / nodes_to_look;
  if (to_look > stride &&
      LocalRotation(level, displacement, to_look).largest().degrees < worth_a_look * least) {
    return std::nullopt;
  }
  LocalRotation result(level, displacement, stride);
  return result.largest().degrees < least ? std::nullopt : std::optional(std::move(result));
}

void LocalRotation::apply(VectorField& vectors, bool back) const {
  const Extent extent = level_->extent;
  const std::size_t axes = extent.axes();
  const auto stride = static_cast<float>(stride_);
  const auto between = [&](int site, int nodes) { // two nodes and the share of the second
    const int first = site / stride_;
    return std::tuple{first, std::min(first + 1, nodes - 1), static_cast<float>(site % stride_) / stride};
  };
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    const auto [top, bottom, down] = between(row % extent.height, nodes_.height);
    const auto [front, behind, deep] = between(row / extent.height, nodes_.depth);
    std::vector<Eigen::Matrix3f> of_row;
    for (int node = 0; node < nodes_.width; ++node) {
      const auto at = [&](int y, int z) {
        return Eigen::Map<const Eigen::Matrix3f>(rotations_[nodes_.index(node, y, z)].data());
      };
      of_row.emplace_back((1.0F - deep) * ((1.0F - down) * at(top, front) + down * at(bottom, front)) +
                          deep * ((1.0F - down) * at(top, behind) + down * at(bottom, behind)));
      if (back) {
        of_row.back().transposeInPlace();
      }
    }
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t site = extent.index(x, row);
      bool is_held = is_on_wall(*level_, site);
      for (std::size_t axis = 0; axis < axes; ++axis) {
        is_held = is_held || level_->confidence[axis][site] >= 1.0F;
      }
      if (is_held) {
        continue;
      }
      const auto [left, right, over] = between(x, nodes_.width);
      const Eigen::Matrix3f rotation = (1.0F - over) * of_row[static_cast<std::size_t>(left)] +
                                       over * of_row[static_cast<std::size_t>(right)];
      if (rotation.determinant() < least_determinant) {
        continue;
      }
      Eigen::Vector3f vector = Eigen::Vector3f::Zero();
      for (std::size_t axis = 0; axis < axes; ++axis) {
        vector[static_cast<Eigen::Index>(axis)] = vectors[axis][site];
      }
      vector = rotation * vector;
      for (std::size_t axis = 0; axis < axes; ++axis) {
        vectors[axis][site] = vector[static_cast<Eigen::Index>(axis)];
      }
    }
  }
}

} // namespace hdmbench
