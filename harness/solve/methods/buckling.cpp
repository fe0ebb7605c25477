#include "harness/solve/methods/buckling.hpp"

#include "harness/solve/methods/law_solver.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/elastic/conditions.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace hdmbench {

namespace {

constexpr double step_of_difference = 0.05; ///< pixels, of the component that moves most
constexpr int fewest_steps = 4;
constexpr double stiff = 0.15; ///< eigenvalue of the tangent times a cycle

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

} // namespace

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

std::optional<std::size_t> site_that_buckles(const BalancedBody& body, int most) {
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
    if (step + 1 >= fewest_steps && smallest.value() > stiff) {
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
