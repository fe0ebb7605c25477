// Manufactured solutions of laws of large strains: a displacement is chosen, and the load that holds it is
// found from the law as its header has it.

#include "harness/judge/truths.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/laws.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace hdmbench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A body of side 1 and modulus 1 that is displaced by a smooth field, with slopes of up to .3.
struct Manufactured {
  bool is_volume = false;
  double stiffening = 0.0;
  double poisson = 0.3;

  [[nodiscard]] Vector3d displacement(const Vector3d& at) const {
    const double z = is_volume ? at.z() : 0.0;
    return {0.15 * std::sin(2.0 * at.x() + at.y() - z), 0.12 * std::cos(at.x() - 2.5 * at.y() + 0.5 * z),
            is_volume ? 0.1 * std::sin(3.0 * z + at.x()) : 0.0};
  }
  [[nodiscard]] Matrix3d deformation(const Vector3d& at) const {
    const double z = is_volume ? at.z() : 0.0;
    const double a = 0.15 * std::cos(2.0 * at.x() + at.y() - z);
    const double b = -0.12 * std::sin(at.x() - 2.5 * at.y() + 0.5 * z);
    const double c = is_volume ? 0.1 * std::cos(3.0 * z + at.x()) : 0.0;
    Matrix3d slopes;
    slopes << 2.0 * a, a, -a, b, -2.5 * b, 0.5 * b, c, 0.0, 3.0 * c;
    if (!is_volume) {
      slopes.row(2).setZero();
      slopes.col(2).setZero();
    }
    return Matrix3d::Identity() + slopes;
  }
  /// W = mu / (2 b) ((1 + b Q / 8)^8 - 1) + lame / 2 L^2; Q = I1 - 3 - 2 L, L = (J - 1 / J) / 2.
  [[nodiscard]] Matrix3d stress(const Vector3d& at) const {
    const Matrix3d f = deformation(at);
    const double mu = 0.5 / (1.0 + poisson);
    const double lame = is_volume ? poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
                                  : poisson / (1.0 - poisson * poisson); // a membrane
    const double j = f.determinant();
    const double log = 0.5 * (j - 1.0 / j);
    const Matrix3d of_log = 0.5 * (1.0 + 1.0 / (j * j)) * j * f.inverse().transpose();
    const double stretch = 1.0 + stiffening / 8.0 * (f.squaredNorm() - 3.0 - 2.0 * log);
    return mu * std::pow(stretch, 7.0) * (f - of_log) + lame * log * of_log;
  }
  /// Returns the load that keeps the body so, over its volume.
  [[nodiscard]] Vector3d load(const Vector3d& at) const {
    constexpr double step = 1e-4;
    Vector3d sum = Vector3d::Zero();
    for (int axis = 0; axis < (is_volume ? 3 : 2); ++axis) {
      const Vector3d way = step * Vector3d::Unit(axis);
      sum -= (stress(at + way) - stress(at - way)).col(axis) / (2.0 * step);
    }
    return sum;
  }
};

/// Returns how far the solution on so many sites a side is from the field, RMS, over the side of the body.
double error_on(const Manufactured& body, int sites, double times = 1.0) {
  const double cells = sites - 1;
  Level level = test::plain_level({sites, sites, body.is_volume ? sites : 1}, 1.0F);
  level.law_parameter = ScalarField(level.extent);
  std::ranges::fill(level.law_parameter.values, static_cast<float>(body.stiffening));
  level.force = VectorField(level.extent);
  ReferenceField truth(level.extent);
  for_each_site(level.extent, [&](int x, int y, int z) {
    const std::size_t site = level.extent.index(x, y, z);
    const Vector3d at(x / cells, y / cells, z / cells);
    const Vector3d way = cells * body.displacement(at); // pixels
    const Vector3d load = times * body.load(at) / cells;
    bool is_border = x == 0 || y == 0 || x + 1 == sites || y + 1 == sites;
    is_border = is_border || (body.is_volume && (z == 0 || z + 1 == sites));
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      const auto component = static_cast<Eigen::Index>(axis);
      truth[axis][site] = way[component];
      level.force[axis][site] = static_cast<float>(load[component]);
      level.target[axis][site] = is_border ? static_cast<float>(way[component]) : 0.0F;
      level.confidence[axis][site] = is_border ? 1.0F : 0.0F;
    }
  });
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  const Solution found = solve_by_laws(level, {body.poisson}, *session, 2e-5, [](const LawStep&) {});
  EXPECT_EQ(found.failure, "");
  return rmsd(ReferenceField(found.displacement), truth) / cells;
}

TEST(Laws, ManufacturedSolutionsAreMetInSecondOrder) {
  for (const bool is_volume : {false, true}) {
    for (const double stiffening : {0.0, 3.0}) {
      const Manufactured body{.is_volume = is_volume, .stiffening = stiffening};
      const std::array<int, 3> sides = is_volume ? std::array{5, 9, 17} : std::array{9, 17, 33};
      std::array<double, 3> errors{};
      std::ranges::transform(sides, errors.begin(), [&](int sites) { return error_on(body, sites); });
      const double order = std::log2(errors[1] / errors[2]);
      fmt::print("{}, stiffening {}: {:.2e}, {:.2e}, {:.2e} of the side, order {:.2f}\n",
                 is_volume ? "volume" : "image", stiffening, errors[0], errors[1], errors[2], order);
      EXPECT_GT(order, 1.9);
      EXPECT_GT(std::log2(errors[0] / errors[1]), 1.7);
      EXPECT_GT(error_on(body, sides[2], 1.05), 5.0 * errors[2]) << "a load that is off by 5 % is not seen";
    }
  }
}

} // namespace
} // namespace hdmbench
