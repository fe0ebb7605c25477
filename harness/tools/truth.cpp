#include "harness/tools/truth.hpp"

#include "harness/judge/accuracy/deviation.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

namespace hdmbench {

double rmsd(const VectorField& displacement, const Truth& truth) {
  const auto require_extent = [&](Extent found, const char* what) {
    if (found != displacement.extent) {
      throw InputError(fmt::format("{} is {} x {} pixels, the solution is {} x {}", what, found.width,
                                   found.height, displacement.extent.width, displacement.extent.height));
    }
  };
  require_extent(truth.displacement.extent, "the truth");
  const bool everywhere = truth.defined.values.empty();
  if (!everywhere) {
    require_extent(truth.defined.extent, "the mask of the truth");
  }
  std::vector<std::uint8_t> counted;
  std::ranges::transform(truth.defined.values, std::back_inserter(counted),
                         [](float defined) { return static_cast<std::uint8_t>(defined != 0.0F); });
  if (!everywhere && std::ranges::count(counted, 1) == 0) {
    throw InputError("the truth is defined at no pixel: its mask is 0 everywhere");
  }
  return rmsd(ReferenceField(displacement), ReferenceField(truth.displacement), counted);
}

} // namespace hdmbench
