#include "harness/solve/methods/buckling.hpp"

#include "harness/solve/methods/law_solver.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/elastic/conditions.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace hdmbench {

namespace {

constexpr double step_of_difference = 0.05; ///< pixels, of the component that moves most
constexpr double stiff = 0.15;              ///< eigenvalue of the tangent times a cycle

/// Returns whether the component of a site of tissue may move.
bool moves(const Level& level, float least, std::size_t axis, std::size_t at) {
  return level.confidence[axis][at] < 1.0F && level.modulus.values[at] >= least;
}

/// Returns a load that has a part along every motion: noise, always the same.
VectorField any_load(const Level& level) {
  const float least = void_modulus(level);
  VectorField load(level.extent);
  std::minstd_rand random(1);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    for (std::size_t at = 0; at < level.extent.sites(); ++at) {
      const double value = static_cast<double>(random()) / std::minstd_rand::max() - 0.5;
      load[axis][at] = moves(level, least, axis, at) ? static_cast<float>(value) : 0.0F;
    }
  }
  return load;
}

/// A layer has at most so many pixels: half as many sites a side show thicker ones.
constexpr int thin = 16;
/// Its modulus is at least so many times that of the softer tissue.
constexpr float least_contrast = 1.5F;
/// A layer of a site's thickness through a block of so many sites a side is long enough for a wrinkle.
constexpr int block = 8;
/// It is looked at from such a share of the strain on at which it wrinkles by theory.
constexpr double looked_at_from = 0.8;

double wrinkling_strain(double soft_over_stiff) {
  return 0.25 * std::pow(3.0 * soft_over_stiff, 2.0 / 3.0);
}

/// Knows the layers of a level that are thin, and softer tissue beside them.
class Layers {
public:
  explicit Layers(const Level& level) : level_(level), least_(void_modulus(level)) {
    for (const float modulus : level.modulus.values) {
      softest_ = modulus >= least_ ? std::min(softest_, modulus) : softest_;
      stiffest_ = std::max(stiffest_, modulus);
    }
    least_strain_ = looked_at_from * wrinkling_strain(softest_ / stiffest_);
  }

  /// Returns whether a site is in a layer that is pressed far enough to be looked at.
  [[nodiscard]] bool may_wrinkle(const VectorField& displacement, const std::array<int, 3>& at) const {
    const float modulus = modulus_at(at);
    if (modulus < least_contrast * softest_ || modulus < least_) {
      return false;
    }
    const double pressed = pressed_by(displacement, at) / looked_at_from;
    if (pressed < wrinkling_strain(softest_ / modulus)) {
      return false;
    }
    for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
      const float softer = softer_beside(at, axis);
      if (softer > 0.0F && pressed >= wrinkling_strain(softer / modulus)) {
        return true;
      }
    }
    return false;
  }

private:
  [[nodiscard]] float modulus_at(const std::array<int, 3>& at) const {
    return level_.modulus.values[level_.extent.index(at[0], at[1], at[2])];
  }

  /// Returns the modulus of the softest tissue beside a layer that is thin along an axis; 0: it is not thin,
  /// or there is none.
  [[nodiscard]] float softer_beside(const std::array<int, 3>& at, std::size_t axis) const {
    const float modulus = modulus_at(at);
    int thickness = 1;
    float softer = 0.0F;
    for (const int way : {-1, 1}) {
      for (std::array<int, 3> next = at; thickness <= thin; ++thickness) {
        next.at(axis) += way;
        if (next.at(axis) < 0 || next.at(axis) >= level_.extent.sides()[axis]) {
          break;
        }
        const float beside = modulus_at(next);
        if (least_contrast * beside <= modulus) {
          softer = beside >= least_ && (softer == 0.0F || beside < softer) ? beside : softer;
          break;
        }
      }
    }
    return thickness <= thin ? softer : 0.0F;
  }

  /// Returns the largest strain that shortens the cell after a site; 0 at the last one, and where it is too
  /// small for any layer.
  [[nodiscard]] double pressed_by(const VectorField& displacement, const std::array<int, 3>& at) const {
    const std::size_t site = level_.extent.index(at[0], at[1], at[2]);
    const std::array<std::size_t, 3> steps{1, level_.extent.index(0, 1), level_.extent.index(0, 0, 1)};
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    for (std::size_t along = 0; along < level_.extent.axes(); ++along) {
      if (at.at(along) + 1 >= level_.extent.sides()[along]) {
        return 0.0;
      }
      for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
        const std::vector<float>& component = displacement[axis];
        gradient(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(along)) =
            (double{component[site + steps.at(along)]} - double{component[site]}) / level_.sides.at(along);
      }
    }
    if (gradient.squaredNorm() < least_strain_ * least_strain_) {
      return 0.0;
    }
    gradient += Eigen::Matrix3d::Identity();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> stretches;
    stretches.computeDirect(gradient.transpose() * gradient, Eigen::EigenvaluesOnly);
    return 1.0 - std::sqrt(std::max(stretches.eigenvalues()[0], 0.0));
  }

  const Level& level_;
  float least_;
  float softest_ = std::numeric_limits<float>::max();
  float stiffest_ = 0.0F;
  double least_strain_ = 0.0;
};

} // namespace

std::optional<std::array<int, 3>> place_that_may_wrinkle(const Level& level,
                                                         const VectorField& displacement) {
  const Layers layers(level);
  const auto blocks_of = [](int sites) { return (sites + block - 1) / block; };
  const Extent extent = level.extent;
  const Extent blocks{blocks_of(extent.width), blocks_of(extent.height), blocks_of(extent.depth)};
  std::vector<int> sites_of(blocks.sites());
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < blocks.rows(); ++row) {
    const int bottom = row % blocks.height * block;
    const int front = row / blocks.height * block;
    for (int z = front; z < std::min(front + block, extent.depth); ++z) {
      for (int y = bottom; y < std::min(bottom + block, extent.height); ++y) {
        for (int x = 0; x < extent.width; ++x) {
          sites_of[blocks.index(x / block, row)] += layers.may_wrinkle(displacement, {x, y, z}) ? 1 : 0;
        }
      }
    }
  }
  const auto most = std::ranges::max_element(sites_of);
  if (*most < (extent.axes() == 3 ? block * block : block)) {
    return std::nullopt;
  }
  std::array<int, 3> centre = blocks.coordinates(static_cast<std::size_t>(most - sites_of.begin()));
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    centre.at(axis) = std::min(centre.at(axis) * block + block / 2, extent.sides()[axis] - 1);
  }
  return centre;
}

std::size_t farthest(const Level& level, const VectorField& motion) {
  const float least = void_modulus(level);
  std::size_t site = 0;
  double largest = 0.0;
  for (std::size_t at = 0; at < level.extent.sites(); ++at) {
    double square = 0.0;
    for (std::size_t axis = 0; axis < level.extent.axes() && level.modulus.values[at] >= least; ++axis) {
      square += double{motion[axis][at]} * double{motion[axis][at]};
    }
    if (square > largest) {
      site = at;
      largest = square;
    }
  }
  return site;
}

std::optional<std::size_t> site_that_buckles(const BalancedBody& body, int most, int fewest) {
  VectorField load = any_load(body.level);
  VectorField correction(body.level.extent);
  VectorField moved(body.level.extent);
  VectorField answer(body.level.extent);
  body.correct(load, correction);
  VectorField motion = correction;
  double product = dot(load, correction);
  SmallestEigenvalue smallest;
  for (int step = 0; step < most && product > 0.0; ++step) {
    const double length = step_of_difference / largest_component(motion);
    advance(moved, body.displacement, static_cast<float>(length), motion);
    body.residual_of(moved, answer);
    advance(answer, body.residual, -1.0F, answer); // what resists the motion
    const double resisted = dot(motion, answer) / length;
    if (!std::isfinite(resisted)) {
      return std::nullopt;
    }
    if (!(resisted > 0.0)) {
      return farthest(body.level, motion);
    }
    const double factor = product / resisted;
    smallest.add(factor, product);
    if (step + 1 >= fewest && smallest.value() > stiff) {
      return std::nullopt;
    }
    advance(load, load, static_cast<float>(-factor / length), answer);
    body.correct(load, correction);
    const double next = dot(load, correction);
    advance(motion, correction, static_cast<float>(next / product), motion);
    product = next;
  }
  return std::nullopt;
}

} // namespace hdmbench
