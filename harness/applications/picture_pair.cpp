#include "harness/applications/conventional_registration.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

namespace hdmbench {

namespace {

constexpr int smallest_side = 16; // pixels

InputError unusable(std::string_view why) {
  return InputError(fmt::format("registration: {}", why));
}

void require_picture(const ScalarField& picture, std::string_view which) {
  const Extent extent = picture.extent;
  if (extent.width < smallest_side || extent.height < smallest_side) {
    throw unusable(fmt::format("the pictures are {} x {}, at least {} x {} pixels are needed", extent.width,
                               extent.height, smallest_side, smallest_side));
  }
  const auto bad = std::ranges::find_if_not(picture.values, [](float gray) { return std::isfinite(gray); });
  if (bad != picture.values.end()) {
    const auto site = static_cast<int>(bad - picture.values.begin());
    throw unusable(
        fmt::format("the {} at x = {}, y = {} is {}", which, site % extent.width, site / extent.width, *bad));
  }
  const auto [low, high] = std::ranges::minmax(picture.values);
  if (low == high || !std::isfinite(high - low)) {
    throw unusable(fmt::format("the gray values of the {} are {} ... {}, there is no contrast to register by",
                               which, low, high));
  }
}

} // namespace

void require_pair(const ScalarField& source, const ScalarField& target) {
  if (source.extent != target.extent) {
    throw unusable(
        fmt::format("the source is {} x {} pixels, the target {} x {}; crop or resample one of them",
                    source.extent.width, source.extent.height, target.extent.width, target.extent.height));
  }
  require_picture(source, "source");
  require_picture(target, "target");
}

} // namespace hdmbench
