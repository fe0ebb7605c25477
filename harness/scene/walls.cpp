#include "harness/scene/walls.hpp"

#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <span>
#include <utility>

namespace hdmbench {

namespace {

/// How far around a site its normal looks, pixels: far enough to see a slope in stairs of pixels, as normals
/// that are off hold what slides. Walls.NormalsOfPixelsAreThoseOfTheOutline measures by how much.
constexpr double reach_of_normals = 7.0;
/// Stairs of long pixels are as long, so it looks farther there, at most so many times.
constexpr double most_of_long_sides = 2.0;

using Direction = std::array<double, 3>;

/// The sites around one, by steps along each axis, each with its way in pixels.
class Surroundings {
public:
  Surroundings(const std::vector<bool>& beyond, const std::vector<bool>& shape, Extent extent,
               const std::array<double, 3>& step)
      : beyond_(beyond), shape_(shape), extent_(extent) {
    const auto sides = std::span(step).first(extent.axes());
    const double farthest = reach_of_normals * std::min(std::ranges::max(sides), most_of_long_sides);
    std::array<int, 3> reach{};
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      reach[axis] = static_cast<int>(std::max(1.0, farthest / step[axis]));
    }
    for (int k = -reach[2]; k <= reach[2]; ++k) {
      for (int j = -reach[1]; j <= reach[1]; ++j) {
        for (int i = -reach[0]; i <= reach[0]; ++i) {
          const Direction way{i * step[0], j * step[1], k * step[2]};
          const bool is_next = std::abs(i) + std::abs(j) + std::abs(k) == 1;
          if (is_next || std::hypot(way[0], way[1], way[2]) <= farthest) {
            seen_.emplace_back(std::array{i, j, k}, way);
          }
        }
      }
    }
  }

  /// Whether a place is beyond the wall; outside the image all is as at the nearest site.
  [[nodiscard]] bool is_beyond(const std::array<int, 3>& place) const { return at(beyond_, place); }
  /// Whether a site that shares a side, or else a corner of a cell, with the place is on the other side.
  [[nodiscard]] bool is_beside(const std::array<int, 3>& place, bool corners) const {
    const bool own = is_beyond(place);
    const int deep = extent_.axes() == 3 ? 1 : 0;
    for (int k = -deep; k <= deep; ++k) {
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          const std::array<int, 3> other{place[0] + i, place[1] + j, place[2] + k};
          const bool counts = corners || std::abs(i) + std::abs(j) + std::abs(k) == 1;
          if (counts && is_beyond(other) != own) {
            return true;
          }
        }
      }
    }
    return false;
  }
  /// The way to the middle of the shape around the place, of length 1; 0 where there is no such way.
  [[nodiscard]] Direction normal(const std::array<int, 3>& place) const {
    Direction sum{};
    for (const auto& [steps, way] : seen_) {
      if (at(shape_, {place[0] + steps[0], place[1] + steps[1], place[2] + steps[2]})) {
        std::ranges::transform(sum, way, sum.begin(), std::plus<>());
      }
    }
    const double length = std::hypot(sum[0], sum[1], sum[2]);
    for (double& component : sum) {
      component = length > 0.0 ? component / length : 0.0;
    }
    return sum;
  }

private:
  [[nodiscard]] bool at(const std::vector<bool>& sites, std::array<int, 3> place) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = std::clamp(place[axis], 0, extent_.sides()[axis] - 1);
    }
    return sites[extent_.index(place[0], place[1], place[2])];
  }

  const std::vector<bool>& beyond_;
  const std::vector<bool>& shape_;
  Extent extent_;
  std::vector<std::pair<std::array<int, 3>, Direction>> seen_; ///< what a normal looks at
};

/// The whole cells between sites, of which no corner is solid.
class Cells {
public:
  using Part = std::vector<std::size_t>; ///< the first corners of cells that are joined by sides

  Cells(const std::vector<bool>& solid, Extent extent) : extent_(extent), is_left_(solid.size()) {
    for_each_site({extent.width - 1, extent.height - 1, std::max(extent.depth - 1, 1)},
                  [&](int x, int y, int z) {
                    const std::size_t cell = extent.index(x, y, z);
                    is_left_[cell] = !any_corner({cell}, [&](std::size_t site) { return solid[site]; });
                  });
  }
  /// Returns a part that was not returned before; empty: there is none.
  Part next() {
    Part part;
    while (seen_ < is_left_.size() && !is_left_[seen_]) {
      ++seen_;
    }
    const auto take = [&](std::size_t cell) {
      if (is_left_[cell]) {
        is_left_[cell] = false;
        part.push_back(cell);
      }
    };
    if (seen_ < is_left_.size()) {
      take(seen_);
    }
    for (std::size_t i = 0; i < part.size(); ++i) {
      std::size_t step = 1;
      for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
        const auto side = static_cast<std::size_t>(extent_.sides()[axis]);
        const std::size_t at = part[i] / step % side;
        if (at > 0) {
          take(part[i] - step);
        }
        if (at + 1 < side) {
          take(part[i] + step);
        }
        step *= side;
      }
    }
    return part;
  }
  template <typename IsMeant>
  [[nodiscard]] bool any_corner(const Part& part, const IsMeant& is_meant) const {
    const auto row = static_cast<std::size_t>(extent_.width);
    const std::size_t slice = extent_.axes() == 3 ? row * static_cast<std::size_t>(extent_.height) : 0;
    return std::ranges::any_of(part, [&](std::size_t cell) {
      for (const std::size_t first : {cell, cell + row, cell + slice, cell + row + slice}) {
        if (is_meant(first) || is_meant(first + 1)) {
          return true;
        }
      }
      return false;
    });
  }
  void set_corners(const Part& part, std::vector<bool>& sites) const {
    (void)any_corner(part, [&](std::size_t site) {
      sites[site] = true;
      return false;
    });
  }

private:
  Extent extent_;
  std::vector<bool> is_left_;
  std::size_t seen_ = 0; ///< all before it are not left
};

/// Parts of fewer cells, three along each axis, are specks: a side of the tissue around does not hold them,
/// and a hinge of an edge or a corner would let them turn.
std::size_t least_cells(std::size_t axes) {
  return axes == 3 ? 27 : 9;
}

} // namespace

std::vector<bool> with_bumps(const std::vector<bool>& solid, const Level& level) {
  const Extent extent = level.extent;
  const auto is_known = [&](std::size_t site) {
    return std::ranges::any_of(std::span(level.confidence.planes).first(extent.axes()),
                               [&](const std::vector<float>& component) { return component[site] > 0.0F; });
  };
  std::vector<bool> stays(solid.size());
  std::vector<Cells::Part> specks;
  std::size_t largest = 0;
  Cells cells(solid, extent);
  for (Cells::Part part = cells.next(); !part.empty(); part = cells.next()) {
    largest = std::max(largest, part.size());
    if (part.size() >= least_cells(extent.axes())) {
      cells.set_corners(part, stays);
    } else {
      specks.push_back(std::move(part));
    }
  }
  for (const Cells::Part& part : specks) {
    if (part.size() == largest || cells.any_corner(part, is_known)) {
      cells.set_corners(part, stays);
    }
  }
  for (std::size_t site = 0; site < solid.size(); ++site) {
    stays[site] = stays[site] || (!solid[site] && is_known(site));
  }
  stays.flip();
  return stays;
}

void set_wall(const std::vector<bool>& solid, const std::vector<bool>& shape,
              const std::array<double, 3>& step, Level& level) {
  const Extent extent = level.extent;
  const std::size_t axes = extent.axes();
  const std::vector<bool> beyond = with_bumps(solid, level);
  level.springs.resize(axes * (axes + 1) / 2, std::vector<float>(extent.sites()));
  level.has_walls = true;
  const Surroundings around(beyond, shape, extent, step);
  const auto set_site = [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    if (beyond[site]) {
      const bool stays = !around.is_beside({x, y, z}, true);
      level.modulus.values[site] = 0.0F;
      for (std::size_t axis = 0; axis < axes; ++axis) {
        level.target[axis][site] = 0.0F;
        level.confidence[axis][site] = stays ? 1.0F : 0.0F;
      }
    } else if (level.modulus.values[site] > 0.0F && !is_prescribed(level, site) &&
               around.is_beside({x, y, z}, false)) {
      const Direction normal = around.normal({x, y, z});
      const bool is_between = normal == Direction{}; // of two walls: then it is held
      for (std::size_t a = 0; a < axes; ++a) {
        for (std::size_t b = a; b < axes; ++b) {
          const double entry = is_between ? (a == b ? 1.0 : 0.0) : normal[a] * normal[b];
          level.springs[symmetric_entry(axes, a, b)][site] += stiffness_of_walls * static_cast<float>(entry);
        }
      }
    }
  };
#pragma omp parallel for schedule(dynamic, 8) if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      set_site(x, row % extent.height, row / extent.height);
    }
  }
}

void set_rest_on_walls(Level& level) {
  const std::size_t axes = level.extent.axes();
#pragma omp parallel for if (level.extent.sites() > sites_worth_threads)
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    bool is_held = false;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      is_held = is_held || level.springs[symmetric_entry(axes, axis, axis)][site] > 0.0F;
    }
    if (is_held) {
      set_rest_on_wall(level, site);
    }
  }
}

WallReport walls_under(const Level& level, const VectorField& displacement) {
  WallReport report;
  const std::size_t axes = level.extent.axes();
  // What a condition prescribes is not the wall's.
  const auto by_wall = [&](std::size_t axis, std::size_t site) {
    return level.confidence[axis][site] < 1.0F ? double{displacement[axis][site]} : 0.0;
  };
  for (std::size_t site = 0; level.has_walls && site < level.extent.sites(); ++site) {
    double stiffness = 0.0;
    double square = 0.0;
    for (std::size_t a = 0; a < axes; ++a) {
      stiffness += double{level.springs[symmetric_entry(axes, a, a)][site]};
      for (std::size_t b = 0; b < axes; ++b) {
        square +=
            by_wall(a, site) * by_wall(b, site) * double{level.springs[symmetric_entry(axes, a, b)][site]};
      }
    }
    report.sites += stiffness > 0.0 ? 1 : 0;
    report.gave_way =
        std::max(report.gave_way, std::sqrt(std::max(0.0, square) / double{stiffness_of_walls}));
  }
  return report;
}

} // namespace hdmbench
