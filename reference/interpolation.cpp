#include "reference/interpolation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace hdmbench {

namespace {

/// What the line along an axis says about one of its sites.
struct LineValue {
  int ends = 0; ///< observed sites it lies between: 0, 1 or 2
  double value = 0.0;
  double distance = 0.0; ///< to the nearer end, pixels
};

using Lines = std::array<LineValue, 3>; ///< through a site, by their axis

/// Along the line of `count` sites, `stride` apart from `first`.
void interpolate_line(const std::vector<float>& target, const std::vector<float>& confidence,
                      std::size_t first, std::size_t stride, int count, std::size_t axis,
                      std::vector<Lines>& result) {
  const auto site = [&](int position) { return first + static_cast<std::size_t>(position) * stride; };
  const auto value = [&](int position) { return static_cast<double>(target[site(position)]); };
  std::vector<int> observed;
  for (int position = 0; position < count; ++position) {
    if (confidence[site(position)] > 0.0F) {
      observed.push_back(position);
    }
  }
  for (int position = 0; position < count && !observed.empty(); ++position) {
    const auto next = std::ranges::lower_bound(observed, position);
    const int after = next == observed.end() ? observed.back() : *next;
    const int before = after <= position || next == observed.begin() ? after : *std::prev(next);
    const double to_before = std::abs(position - before);
    const double to_after = std::abs(after - position);
    const double length = to_before + to_after;
    const bool is_between = before <= position && position <= after;
    result[site(position)][axis] = {
        .ends = is_between ? 2 : 1,
        .value = is_between && length > 0.0 ? (to_after * value(before) + to_before * value(after)) / length
                                            : value(before),
        .distance = std::min(to_before, to_after)};
  }
}

/// What the lines through a site say together: those that end at an observed site on both sides, or those
/// that do on one.
double blend(const Lines& lines) {
  const int most = std::ranges::max(lines, {}, &LineValue::ends).ends;
  double sum = 0.0;
  double weights = 0.0;
  for (const LineValue& line : lines) {
    if (line.ends == most) {
      if (line.distance == 0.0) { // observed, or no line knows anything
        return line.value;
      }
      sum += line.value / line.distance;
      weights += 1.0 / line.distance;
    }
  }
  return sum / weights;
}

} // namespace

ReferenceField interpolate_conditions(const Level& level) {
  validate(level);
  const Extent extent = level.extent;
  const std::array<std::size_t, 3> strides{1, extent.index(0, 1), extent.index(0, 0, 1)};
  ReferenceField field(extent);
  for (std::size_t component = 0; component < extent.axes(); ++component) {
    std::vector<Lines> lines(extent.sites());
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        const auto count = static_cast<std::size_t>(extent.sides()[axis]);
        if (site / strides[axis] % count == 0) { // where a line begins
          interpolate_line(level.target[component], level.confidence[component], site, strides[axis],
                           extent.sides()[axis], axis, lines);
        }
      }
    }
    std::ranges::transform(lines, field[component].begin(), blend);
  }
  return field;
}

} // namespace hdmbench
