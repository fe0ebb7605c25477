#include "kernels/level.hpp"

#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

void require_size(std::size_t values, Extent found, Extent extent, const char* what) {
  if (found != extent || values != extent.sites()) {
    throw InputError(fmt::format("{} is {} x {} with {} values, the scene is {} x {}", what, found.width,
                                 found.height, values, extent.width, extent.height));
  }
}

/// The first site that breaks `holds` is named in the error.
template <typename Predicate>
void require(const std::vector<float>& values, Extent extent, const char* what, const char* rule,
             Predicate holds) {
  const auto found = std::ranges::find_if_not(values, holds);
  if (found != values.end()) {
    const auto index = found - values.begin();
    throw InputError(fmt::format("{} at x = {}, y = {} is {}, it must be {}", what, index % extent.width,
                                 index / extent.width, *found, rule));
  }
}

bool is_finite(float value) {
  return std::isfinite(value);
}

} // namespace

void set_inverse_modulus(Level& level) {
  level.inverse_modulus = ScalarField(level.modulus.extent);
  std::ranges::transform(level.modulus.values, level.inverse_modulus.values.begin(),
                         [](float modulus) { return 1.0F / modulus; });
}

void validate(const VectorField& field, Extent extent, const char* what) {
  require_size(field.x.size(), field.extent, extent, what);
  require_size(field.y.size(), field.extent, extent, what);
  require(field.x, extent, what, "finite", is_finite);
  require(field.y, extent, what, "finite", is_finite);
}

void validate(const Level& level) {
  if (level.extent.width < 1 || level.extent.height < 1) {
    throw InputError(fmt::format("the image is {} x {} pixels, each must be at least 1", level.extent.width,
                                 level.extent.height));
  }
  if (!(level.penalty > 0.0F) || !std::isfinite(level.penalty)) {
    throw InputError(fmt::format("the penalty K is {}, it must be positive and finite", level.penalty));
  }
  validate(level.target, level.extent, "the target displacement");
  validate(level.confidence, level.extent, "the confidence");
  const auto in_unit_interval = [](float value) { return value >= 0.0F && value <= 1.0F; };
  require(level.confidence.x, level.extent, "the confidence in x", "within 0 ... 1", in_unit_interval);
  require(level.confidence.y, level.extent, "the confidence in y", "within 0 ... 1", in_unit_interval);
  require_size(level.modulus.values.size(), level.modulus.extent, level.extent, "the modulus");
  require(level.modulus.values, level.extent, "the modulus (MPa)", "positive and finite",
          [](float value) { return value > 0.0F && std::isfinite(value) && std::isfinite(1.0F / value); });
  require_size(level.inverse_modulus.values.size(), level.inverse_modulus.extent, level.extent,
               "the inverse modulus");
}

} // namespace hdmbench
