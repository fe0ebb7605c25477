#include "harness/solve/planner/survey.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// Indices spread evenly over an axis, both ends among them.
std::vector<int> spread(int sites, int most) {
  const int count = std::min(sites, most);
  std::vector<int> indices(static_cast<std::size_t>(count), 0);
  for (int i = 0; i < count && count > 1; ++i) {
    indices[static_cast<std::size_t>(i)] =
        static_cast<int>(static_cast<long long>(i) * (sites - 1) / (count - 1));
  }
  return indices;
}

/// For each of the fine indices the fine index that stands for it on a coarse axis.
std::vector<int> representatives(const std::vector<int>& indices, int coarse, int fine, Alignment alignment) {
  std::vector<int> result;
  for (const int index : indices) {
    const double position = fine > 1 ? static_cast<double>(index) * (coarse - 1) / (fine - 1) : 0.0;
    result.push_back(sampled_index(static_cast<int>(std::lround(position)), coarse, fine, alignment));
  }
  return result;
}

double share(std::size_t part, std::size_t all) {
  return all == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(all);
}

Resolution resolution_of(const Scene& scene, Extent extent, int per_side) {
  const Level& full = scene.full;
  const Alignment alignment = scene.schedule.alignment;
  const std::vector<int> columns = spread(full.extent.width, per_side);
  const std::vector<int> rows = spread(full.extent.height, per_side);
  const std::vector<int> to_columns = representatives(columns, extent.width, full.extent.width, alignment);
  const std::vector<int> to_rows = representatives(rows, extent.height, full.extent.height, alignment);
  std::size_t same_modulus = 0;
  std::size_t observed = 0;
  std::size_t still_observed = 0;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t column = 0; column < columns.size(); ++column) {
      const std::size_t at = full.extent.index(columns[column], rows[row]);
      const std::size_t there = full.extent.index(to_columns[column], to_rows[row]);
      same_modulus += full.modulus.values[at] == full.modulus.values[there] ? 1 : 0;
      for (const auto* confidence : {&full.confidence.x, &full.confidence.y}) {
        observed += (*confidence)[at] > 0.0F ? 1 : 0;
        still_observed += (*confidence)[at] > 0.0F && (*confidence)[there] > 0.0F ? 1 : 0;
      }
    }
  }
  return {.extent = extent,
          .materials = share(same_modulus, columns.size() * rows.size()),
          .conditions = share(still_observed, observed)};
}

double share_of_uniform_sites(const Level& level) {
  const Extent extent = level.extent;
  std::size_t uniform = 0;
  const std::vector<int> columns = spread(extent.width, usual_per_side);
  const std::vector<int> rows = spread(extent.height, usual_per_side);
  for (const int y : rows) {
    for (const int x : columns) {
      const float own = level.modulus.values[extent.index(x, y)];
      bool same = true;
      for (int v = std::max(0, y - 1); v <= std::min(extent.height - 1, y + 1); ++v) {
        for (int u = std::max(0, x - 1); u <= std::min(extent.width - 1, x + 1); ++u) {
          same = same && level.modulus.values[extent.index(u, v)] == own;
        }
      }
      uniform += same ? 1 : 0;
    }
  }
  return share(uniform, columns.size() * rows.size());
}

} // namespace

std::vector<Resolution> resolutions(const Scene& scene, std::span<const Extent> extents, int per_side) {
  std::vector<Resolution> levels;
  std::ranges::transform(extents, std::back_inserter(levels),
                         [&](Extent extent) { return resolution_of(scene, extent, per_side); });
  return levels;
}

std::size_t fair_start(std::span<const Resolution> levels) {
  std::size_t fair = 0;
  while (fair + 1 < levels.size() && levels[fair + 1].is_fair()) {
    ++fair;
  }
  return fair;
}

Survey survey(const Scene& scene) {
  const Level& full = scene.full;
  Survey result;
  const auto [smallest, largest] = std::ranges::minmax(full.modulus.values);
  result.smallest_modulus = static_cast<double>(smallest);
  result.largest_modulus = static_cast<double>(largest);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::size_t observed = 0;
  std::size_t partly = 0;
  for (const auto& [target, confidence] :
       {std::pair{&full.target.x, &full.confidence.x}, std::pair{&full.target.y, &full.confidence.y}}) {
    for (std::size_t i = 0; i < target->size(); ++i) {
      if ((*confidence)[i] > 0.0F) {
        ++observed;
        partly += (*confidence)[i] < 1.0F ? 1 : 0;
        low = std::min(low, static_cast<double>((*target)[i]));
        high = std::max(high, static_cast<double>((*target)[i]));
      }
    }
  }
  const auto components = 2.0 * static_cast<double>(full.extent.sites());
  result.observed = static_cast<double>(observed) / components;
  result.partly = static_cast<double>(partly) / components;
  result.smallest_target = observed > 0 ? low : 0.0;
  result.largest_target = observed > 0 ? high : 0.0;
  result.uniform = share_of_uniform_sites(full);
  return result;
}

} // namespace hdmbench
