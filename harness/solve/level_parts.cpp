#include "harness/solve/level_parts.hpp"

#include "backends/pieces/cut.hpp"
#include "kernels/data/elastic/conditions.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace hdmbench {

namespace {

/// What moves is no part of its own where it has more of the sites.
constexpr double most_of_sites = 0.75;

/// Whether walls stand still in void but for a layer of void beside what slides (harness/scene/walls.hpp),
/// which carries nothing and is solved for its looks.
bool has_layer_of_void(const Level& level) {
  return has_laws(level) && level.has_walls;
}

/// Whether a cell beside the site has a corner that is prescribed.
bool touches_prescribed(const Level& level, const std::array<int, 3>& at) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.first[axis] = at[axis];
    box.end[axis] = at[axis] + 1;
  }
  return box.with_rim(level.extent).has_row([&](int first, int end, int y, int z) {
    bool is_found = false;
    for (int x = first; x < end; ++x) {
      is_found = is_found || is_prescribed(level, level.extent.index(x, y, z));
    }
    return is_found;
  });
}

/// The least box of all sites that something can move; without sites where there are none.
Box moving_sites(const Level& level) {
  const Extent extent = level.extent;
  const float least_modulus = has_layer_of_void(level) ? void_modulus(level) : 0.0F;
  std::vector<std::array<int, 2>> rows(static_cast<std::size_t>(extent.rows())); // the first such and the end
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    const auto moves = [&](int x) {
      const std::size_t site = extent.index(x, row);
      return !is_prescribed(level, site) &&
             (level.modulus.values[site] >= least_modulus ||
              !touches_prescribed(level, {x, row % extent.height, row / extent.height}));
    };
    auto& [first, end] = rows[static_cast<std::size_t>(row)];
    end = extent.width;
    while (first < end && !moves(first)) {
      ++first;
    }
    while (end > first && !moves(end - 1)) {
      --end;
    }
  }
  Box box{.first = extent.sides(), .end = {}};
  for (int row = 0; row < extent.rows(); ++row) {
    const auto [first, end] = rows[static_cast<std::size_t>(row)];
    if (first < end) {
      const std::array<int, 3> low{first, row % extent.height, row / extent.height};
      const std::array<int, 3> high{end, low[1] + 1, low[2] + 1};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.first[axis] = std::min(box.first[axis], low[axis]);
        box.end[axis] = std::max(box.end[axis], high[axis]);
      }
    }
  }
  return box;
}

} // namespace

std::optional<LevelPart> moving_part(const Level& level) {
  const Box moving = moving_sites(level);
  if (moving.end[0] <= moving.first[0]) {
    return std::nullopt;
  }
  const Box sites = moving.with_rim(level.extent);
  const bool is_flat = level.extent.axes() == 3 && sites.extent().axes() == 2;
  if (is_flat || static_cast<double>(sites.extent().sites()) >
                     most_of_sites * static_cast<double>(level.extent.sites())) {
    return std::nullopt;
  }
  LevelPart part{.sites = sites, .level = part_of(level, sites)};
  keep_void(void_modulus(level), part.level);
  return part;
}

LevelPart held_part(const Level& level, const Box& sites, const VectorField& displacement) {
  LevelPart part{.sites = sites, .level = part_of(level, sites)};
  keep_void(void_modulus(level), part.level);
  const Extent extent = sites.extent();
  for_each_site(extent, [&](int x, int y, int z) {
    const std::array<int, 3> at{x, y, z};
    bool is_held = false;
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      const int in_level = sites.first[axis] + at[axis];
      is_held = is_held || (at[axis] == 0 && in_level > 0) ||
                (at[axis] + 1 == extent.sides()[axis] && in_level + 1 < level.extent.sides()[axis]);
    }
    for (std::size_t axis = 0; is_held && axis < extent.axes(); ++axis) {
      const std::size_t site = extent.index(x, y, z);
      part.level.confidence[axis][site] = 1.0F;
      part.level.target[axis][site] =
          displacement[axis][level.extent.index(sites.first[0] + x, sites.first[1] + y, sites.first[2] + z)];
    }
  });
  return part;
}

VectorField with_prescribed(const Level& level, const Box& part, const VectorField& of_part) {
  VectorField displacement = has_layer_of_void(level) ? extended_conditions(level) : level.target;
  copy(part, of_part, part, displacement, all_of(level.extent));
  return displacement;
}

} // namespace hdmbench
