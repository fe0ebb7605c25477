#include "harness/scene/images/images.hpp"
#include "kernels/data/level.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// Where a point goes, and how that changes with the point.
struct Landing {
  Eigen::Vector3d at;
  Eigen::Matrix3d slope;
};

/// x + d(x), d linear between sites and beyond them that of the border. Of an image z stays 0.
class Motion {
public:
  explicit Motion(const VectorField& displacement)
      : displacement_(displacement), sides_(displacement.extent.sides()), axes_(displacement.extent.axes()) {}

  [[nodiscard]] Landing of(const Eigen::Vector3d& point) const {
    std::array<std::size_t, 3> first{};
    std::array<std::array<double, 2>, 3> share{{{1.0, 0.0}, {1.0, 0.0}, {1.0, 0.0}}};
    std::array<double, 3> change{}; // of the second share
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      const double at = point[static_cast<Eigen::Index>(axis)];
      const double last = sides_[axis] - 1.0;
      const double inside = std::clamp(at, 0.0, last);
      const double cell = std::min(std::floor(inside), std::max(last - 1.0, 0.0));
      first[axis] = static_cast<std::size_t>(cell);
      share[axis] = {1.0 - (inside - cell), inside - cell};
      change[axis] = at == inside && last > 0.0 ? 1.0 : 0.0;
    }
    Landing landing{point, Eigen::Matrix3d::Identity()};
    for (unsigned corner = 0; corner < 1U << axes_; ++corner) {
      const std::array<std::size_t, 3> bit{corner & 1U, corner >> 1U & 1U, corner >> 2U};
      const double weight = share[0][bit[0]] * share[1][bit[1]] * share[2][bit[2]];
      const Eigen::Vector3d slope(
          (bit[0] == 1 ? change[0] : -change[0]) * share[1][bit[1]] * share[2][bit[2]],
          (bit[1] == 1 ? change[1] : -change[1]) * share[0][bit[0]] * share[2][bit[2]],
          (bit[2] == 1 ? change[2] : -change[2]) * share[0][bit[0]] * share[1][bit[1]]);
      if (weight == 0.0 && slope.isZero(0.0)) {
        continue; // also where there is no such site
      }
      const auto place = [&](std::size_t axis) { return static_cast<int>(first[axis] + bit[axis]); };
      const std::size_t site = displacement_.extent.index(place(0), place(1), place(2));
      for (std::size_t axis = 0; axis < axes_; ++axis) {
        const double way = displacement_[axis][site];
        landing.at[static_cast<Eigen::Index>(axis)] += weight * way;
        landing.slope.row(static_cast<Eigen::Index>(axis)) += way * slope.transpose();
      }
    }
    return landing;
  }

private:
  const VectorField& displacement_;
  std::array<int, 3> sides_;
  std::size_t axes_;
};

constexpr double near_enough = 1e-4; ///< pixels: below what float tells of a large volume

/// A point and how far it lands from where it should.
struct Origin {
  Eigen::Vector3d point;
  double gap = 0.0; ///< along the axis where it is largest, pixels
};

/// Newton's steps from `start` towards the point that lands at `target`, none of which makes the gap larger.
Origin improve(const Motion& motion, const Eigen::Vector3d& start, const Eigen::Vector3d& target) {
  constexpr int most_steps = 40;
  constexpr int most_halvings = 6;
  constexpr double least_determinant = 0.02;
  constexpr double longest = 4.0; // pixels
  const auto gap_of = [&](const Landing& landing) { return (landing.at - target).lpNorm<Eigen::Infinity>(); };
  Origin origin{start, 0.0};
  Landing landing = motion.of(start);
  origin.gap = gap_of(landing);
  for (int count = 0; count < most_steps && origin.gap > near_enough; ++count) {
    const Eigen::Vector3d missing = landing.at - target;
    Eigen::Vector3d step =
        landing.slope.determinant() > least_determinant ? landing.slope.inverse() * missing : missing;
    step /= std::max(1.0, step.norm() / longest);
    int halvings = 0;
    for (; halvings < most_halvings; ++halvings, step *= 0.5) {
      const Eigen::Vector3d next = origin.point - step;
      landing = motion.of(next);
      if (const double gap = gap_of(landing); gap < origin.gap) {
        origin = {next, gap};
        break;
      }
    }
    if (halvings == most_halvings) {
      break;
    }
  }
  return origin;
}

/// Whether all corners of the cell around a point are tissue.
bool is_in_tissue(const Eigen::Vector3d& point, const ScalarField& tissue) {
  const std::array<int, 3> sides = tissue.extent.sides();
  std::array<int, 3> first{};
  std::array<int, 3> last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = std::clamp(point[static_cast<Eigen::Index>(axis)], 0.0, sides[axis] - 1.0);
    first[axis] = static_cast<int>(std::floor(at));
    last[axis] = static_cast<int>(std::ceil(at));
  }
  bool is_whole = true;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto at = [&](unsigned axis) { return (corner >> axis & 1U) != 0 ? last[axis] : first[axis]; };
    is_whole = is_whole && tissue.values[tissue.extent.index(at(0), at(1), at(2))] > 0.0F;
  }
  return is_whole;
}

} // namespace

Inverse invert(const VectorField& displacement, const ScalarField& tissue) {
  const Extent extent = displacement.extent;
  validate(displacement, extent, "the displacement to invert");
  const Motion motion(displacement);
  Inverse inverse{.displacement = VectorField(extent)};
  std::vector<Inverse> of_rows(static_cast<std::size_t>(extent.rows()));
  on_all_threads(of_rows.size(), extent.sites() > sites_worth_threads, [&](std::size_t number) {
    const int y = static_cast<int>(number) % extent.height;
    const int z = static_cast<int>(number) / extent.height;
    Eigen::Vector3d way = Eigen::Vector3d::Zero(); // back from the site before
    for (int x = 0; x < extent.width; ++x) {
      const Eigen::Vector3d site(x, y, z);
      Origin origin = improve(motion, 2.0 * site - motion.of(site).at, site);
      for (const Eigen::Vector3d& start : {Eigen::Vector3d(site + way), site}) {
        if (origin.gap > inverse_is_met) {
          const Origin other = improve(motion, start, site);
          origin = other.gap < origin.gap ? other : origin;
        }
      }
      way = origin.point - site;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        inverse.displacement[axis][extent.index(x, y, z)] =
            static_cast<float>(way[static_cast<Eigen::Index>(axis)]);
      }
      if (origin.gap > near_enough && !tissue.values.empty() && !is_in_tissue(origin.point, tissue)) {
        continue;
      }
      Inverse& row = of_rows[number];
      row.unmet += origin.gap > inverse_is_met ? 1 : 0;
      if (origin.gap > row.farthest) {
        row.farthest = origin.gap;
        row.at = {x, y, z};
      }
    }
  });
  for (const Inverse& row : of_rows) {
    inverse.unmet += row.unmet;
    if (row.farthest > inverse.farthest) {
      inverse.farthest = row.farthest;
      inverse.at = row.at;
    }
  }
  return inverse;
}

Inverse invert(const VectorField& displacement, const std::array<double, 3>& pixel,
               const ScalarField& tissue) {
  const std::optional<VectorField> steps = in_steps(displacement, pixel);
  Inverse inverse = invert(steps ? *steps : displacement, tissue);
  to_lengths(inverse.displacement, pixel);
  return inverse;
}

} // namespace hdmbench
