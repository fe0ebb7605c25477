#include "reference/interpolation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace hdmbench {

namespace {

/// What one line, a row or a column, says about one of its sites.
struct LineValue {
  int ends = 0; ///< observed sites it lies between: 0, 1 or 2
  double value = 0.0;
  double distance = 0.0; ///< to the nearer end, pixels
};

struct End {
  int position = 0;
  double value = 0.0;
};

LineValue interpolate(const std::optional<End>& before, const std::optional<End>& after, int position) {
  if (!before && !after) {
    return {};
  }
  if (!before || !after) {
    const End& only = before ? *before : *after;
    return {
        .ends = 1, .value = only.value, .distance = std::abs(static_cast<double>(position - only.position))};
  }
  const double to_before = position - before->position;
  const double to_after = after->position - position;
  const double length = to_before + to_after;
  const double value =
      length > 0.0 ? (to_after * before->value + to_before * after->value) / length : before->value;
  return {.ends = 2, .value = value, .distance = std::min(to_before, to_after)};
}

/// Along a line of `count` sites, `stride` apart from `first`.
void interpolate_line(const std::vector<float>& target, const std::vector<float>& confidence,
                      std::size_t first, std::size_t stride, int count, std::vector<LineValue>& result) {
  const auto site = [&](int position) { return first + static_cast<std::size_t>(position) * stride; };
  std::vector<std::optional<End>> after(static_cast<std::size_t>(count) + 1); // from each position on
  for (int position = count - 1; position >= 0; --position) {
    const auto at = static_cast<std::size_t>(position);
    after[at] = confidence[site(position)] > 0.0F
                    ? End{.position = position, .value = static_cast<double>(target[site(position)])}
                    : after[at + 1];
  }
  std::optional<End> before;
  for (int position = 0; position < count; ++position) {
    const std::optional<End>& next = after[static_cast<std::size_t>(position)];
    before = next && next->position == position ? next : before;
    result[site(position)] = interpolate(before, next, position);
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
  field.x = interpolate_component(level.extent, level.target.x, level.confidence.x);
  field.y = interpolate_component(level.extent, level.target.y, level.confidence.y);
  return field;
}

} // namespace hdmbench
