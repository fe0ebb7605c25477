#include "reference/interpolation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace hdmbench {

namespace {

/// What one line, a row or a column, says about one of its sites.
struct LineValue {
  int ends = 0; ///< observed sites it lies between: 0, 1 or 2
  double value = 0.0;
  double distance = 0.0; ///< to the nearer end, pixels
};

/// Along a line of `count` sites, `stride` apart from `first`.
void interpolate_line(const std::vector<float>& target, const std::vector<float>& confidence,
                      std::size_t first, std::size_t stride, int count, std::vector<LineValue>& result) {
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
    result[site(position)] = {.ends = is_between ? 2 : 1,
                              .value = is_between && length > 0.0
                                           ? (to_after * value(before) + to_before * value(after)) / length
                                           : value(before),
                              .distance = std::min(to_before, to_after)};
  }
}

double blend(const LineValue& row, const LineValue& column) {
  if (row.ends != column.ends) {
    return row.ends > column.ends ? row.value : column.value;
  }
  const double sum = row.distance + column.distance;
  // 1 / distance, multiplied with both distances. Both are 0 at an observed site, where both have its target.
  return sum > 0.0 ? (column.distance * row.value + row.distance * column.value) / sum : row.value;
}

std::vector<double> interpolate_component(Extent extent, const std::vector<float>& target,
                                          const std::vector<float>& confidence) {
  std::vector<LineValue> rows(extent.sites());
  std::vector<LineValue> columns(extent.sites());
  for (int y = 0; y < extent.height; ++y) {
    interpolate_line(target, confidence, extent.index(0, y), 1, extent.width, rows);
  }
  for (int x = 0; x < extent.width; ++x) {
    interpolate_line(target, confidence, extent.index(x, 0), static_cast<std::size_t>(extent.width),
                     extent.height, columns);
  }
  std::vector<double> result(extent.sites());
  std::transform(rows.begin(), rows.end(), columns.begin(), result.begin(), blend);
  return result;
}

} // namespace

ReferenceField interpolate_conditions(const Level& level) {
  validate(level);
  ReferenceField field;
  field.extent = level.extent;
  field[0] = interpolate_component(level.extent, level.target[0], level.confidence[0]);
  field[1] = interpolate_component(level.extent, level.target[1], level.confidence[1]);
  return field;
}

} // namespace hdmbench
