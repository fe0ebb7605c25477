#include "harness/scene/walls.hpp"

#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

namespace hdmbench {

namespace {

/// How far around a site its normal looks, pixels: far enough to see a slope in stairs of pixels, as normals
/// that are off hold what slides. WallNormals.OfPixelsAreThoseOfTheOutline measures by how much.
constexpr double reach_of_normals = 9.0;
/// It must not see around a small or thin body: so many times its thickness() are four fifths of the radius
/// of a ball.
constexpr double reach_of_thickness = 2.4;
/// Nearer than that stairs of pixels have no slope.
constexpr double least_reach = 4.0;
/// Stairs of long pixels are as long, so it looks farther there, at most so many times.
constexpr double most_of_long_sides = 2.0;
/// Where it looks farther than so many sites along an axis, it looks at some of them alone, about as many.
constexpr int most_sites_seen = 18;
constexpr int sites_seen = 12;

using Direction = std::array<double, 3>;

double product(const Direction& a, const Direction& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Returns the direction of a way, of length 1; 0 where there is no way.
Direction unit(Direction way) {
  const double length = std::sqrt(product(way, way));
  for (double& component : way) {
    component = length > 0.0 ? component / length : 0.0;
  }
  return way;
}

/// Returns how thick the tissue is that is not beyond a wall: its volume over the area of the wall, pixels; a
/// third of the radius of a ball, half the radius of a disc.
double thickness(const std::vector<bool>& beyond, Extent extent, const std::array<double, 3>& step) {
  std::array<std::size_t, 3> faces{}; // across each axis
  for_each_site(extent, [&](int x, int y, int z) {
    const std::array<int, 3> place{x, y, z};
    const std::size_t site = extent.index(x, y, z);
    std::size_t next = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int sites = extent.sides()[axis];
      faces[axis] += place[axis] + 1 < sites && beyond[site] != beyond[site + next] ? 1 : 0;
      next *= static_cast<std::size_t>(sites);
    }
  });
  // Stairs have the area of their outline's three projections.
  const double area = std::hypot(static_cast<double>(faces[0]) * step[1] * step[2],
                                 static_cast<double>(faces[1]) * step[2] * step[0],
                                 static_cast<double>(faces[2]) * step[0] * step[1]);
  const auto inside = static_cast<double>(std::ranges::count(beyond, false));
  return area > 0.0 ? inside * step[0] * step[1] * step[2] / area : 0.0;
}

/// Returns how far around a site its normal looks where nothing is said of that, pixels.
double usual_radius(const std::vector<bool>& beyond, Extent extent, const std::array<double, 3>& step) {
  const auto sides = std::span(step).first(extent.axes());
  const double reach =
      std::clamp(reach_of_thickness * thickness(beyond, extent, step), least_reach, reach_of_normals);
  return reach * std::min(std::ranges::max(sides), most_of_long_sides);
}

/// The sites around one.
class Surroundings {
public:
  /// Normals look `radius` pixels far.
  Surroundings(const std::vector<bool>& beyond, const std::vector<bool>& shape, Extent extent,
               const std::array<double, 3>& step, double radius)
      : beyond_(beyond), shape_(shape.begin(), shape.end()), extent_(extent), step_(step) {
    std::array<int, 3> every{1, 1, 1};
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      const int sites = static_cast<int>(std::max(1.0, radius / step[axis]));
      every[axis] = sites > most_sites_seen ? (sites + sites_seen - 1) / sites_seen : 1;
      reach_[axis] = sites / every[axis] * every[axis];
    }
    for (int k = -reach_[2]; k <= reach_[2]; k += every[2]) {
      for (int j = -reach_[1]; j <= reach_[1]; j += every[1]) {
        for (int i = -reach_[0]; i <= reach_[0]; i += every[0]) {
          const Direction way{i * step[0], j * step[1], k * step[2]};
          const double weight = 1.0 - product(way, way) / (radius * radius);
          if (weight > 0.0) {
            const auto offset =
                static_cast<std::ptrdiff_t>(extent.index(reach_[0] + i, reach_[1] + j, reach_[2] + k)) -
                static_cast<std::ptrdiff_t>(extent.index(reach_[0], reach_[1], reach_[2]));
            seen_.push_back({{i, j, k}, offset, way, {weight * way[0], weight * way[1], weight * way[2]}});
          }
        }
      }
    }
  }

  /// Whether a place is beyond the wall; outside the image all is as at the nearest site.
  [[nodiscard]] bool is_beyond(std::array<int, 3> place) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = std::clamp(place[axis], 0, extent_.sides()[axis] - 1);
    }
    return beyond_[extent_.index(place[0], place[1], place[2])];
  }
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
  /// Returns the way to the middle of the shape around the place, of length 1; 0 where there is no such way.
  /// What is nearer counts more: then a pixel more or less at the rim of what is seen turns it little.
  /// Outside the image all is as where one gets to from there along the wall.
  [[nodiscard]] Direction normal(const std::array<int, 3>& place) const {
    Direction found = way_to_neighbours(place);
    const bool is_inside = sees_no_border(place);
    const std::size_t site = extent_.index(place[0], place[1], place[2]);
    double change = 1.0;
    for (int times = 0; times < 20 && change > 1e-6; ++times) { // where all is inside, once
      const Direction before = std::exchange(found, {});
      for (const Seen& seen : seen_) {
        std::size_t there =
            is_inside ? site + static_cast<std::size_t>(seen.offset) : index_of(place, seen.steps);
        there = there != outside ? there : along_wall(place, seen.way, before);
        const double share = shape_[there]; // 0 or 1; to ask which would stop the processor at every rim
        for (std::size_t axis = 0; axis < 3; ++axis) {
          found[axis] += share * seen.weighted[axis];
        }
      }
      found = unit(found);
      change = is_inside ? 0.0 : 1.0 - product(before, found);
    }
    return found;
  }

private:
  struct Seen {
    std::array<int, 3> steps; ///< along each axis
    std::ptrdiff_t offset;    ///< in the order of sites
    Direction way;            ///< pixels
    Direction weighted;       ///< the less the farther
  };
  static constexpr std::size_t outside = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t index_of(const std::array<int, 3>& place, const std::array<int, 3>& steps) const {
    const std::array<int, 3> there{place[0] + steps[0], place[1] + steps[1], place[2] + steps[2]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (there[axis] < 0 || there[axis] >= extent_.sides()[axis]) {
        return outside;
      }
    }
    return extent_.index(there[0], there[1], there[2]);
  }
  [[nodiscard]] bool sees_no_border(const std::array<int, 3>& place) const {
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      if (place[axis] < reach_[axis] || place[axis] + reach_[axis] >= extent_.sides()[axis]) {
        return false;
      }
    }
    return true;
  }
  /// Returns the site of the image to which a place outside comes along a wall with that normal.
  [[nodiscard]] std::size_t along_wall(const std::array<int, 3>& place, Direction way,
                                       const Direction& normal) const {
    const auto last = [&](std::size_t axis) { return extent_.sides()[axis] - 1; };
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      const double first_way = -place[axis] * step_[axis];
      const double last_way = (last(axis) - place[axis]) * step_[axis];
      const double missing = std::clamp(way[axis], first_way, last_way) - way[axis];
      const double slope = std::max(0.1, 1.0 - normal[axis] * normal[axis]);
      for (std::size_t other = 0; other < 3; ++other) {
        const double along = (other == axis ? 1.0 : 0.0) - normal[axis] * normal[other];
        way[other] += missing / slope * along;
      }
    }
    std::array<int, 3> there{};
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      there[axis] =
          std::clamp(place[axis] + static_cast<int>(std::lround(way[axis] / step_[axis])), 0, last(axis));
    }
    return extent_.index(there[0], there[1], there[2]);
  }
  /// Returns the direction of the neighbours that are in the shape.
  [[nodiscard]] Direction way_to_neighbours(const std::array<int, 3>& place) const {
    Direction sum{};
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      for (const int step : {-1, 1}) {
        std::array<int, 3> steps{};
        steps[axis] = step;
        const std::size_t there = index_of(place, steps);
        sum[axis] += there != outside && shape_[there] ? step * step_[axis] : 0.0;
      }
    }
    return unit(sum);
  }

  const std::vector<bool>& beyond_;
  std::vector<std::uint8_t> shape_; ///< bytes: a normal asks for thousands of them
  Extent extent_;
  std::array<double, 3> step_;
  std::array<int, 3> reach_{};
  std::vector<Seen> seen_; ///< what a normal looks at
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
    // A side of the tissue around does not hold fewer cells, and a hinge would let them turn.
    if (part.size() >= static_cast<std::size_t>(fewest_sites_of_part(extent.axes()))) {
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

std::array<double, 2> limits_of_normal_radius(const std::vector<bool>& solid, Extent extent,
                                              const std::array<double, 3>& step) {
  return {least_reach, std::max(least_reach, reach_of_thickness * thickness(solid, extent, step))};
}

void set_wall(const std::vector<bool>& solid, const std::vector<bool>& shape,
              const std::array<double, 3>& step, Level& level, const VectorField& normals,
              std::optional<double> radius) {
  const Extent extent = level.extent;
  const std::size_t axes = extent.axes();
  const std::vector<bool> beyond = with_bumps(solid, level);
  level.walls.resize(axes * (axes + 1) / 2, std::vector<float>(extent.sites()));
  level.has_walls = true;
  const Surroundings around(beyond, shape, extent, step,
                            radius ? *radius : usual_radius(beyond, extent, step));
  const auto known = [&](std::size_t site) {
    Direction normal{};
    for (std::size_t axis = 0; axis < axes && !normals[0].empty(); ++axis) {
      normal[axis] = double{normals[axis][site]};
    }
    return unit(normal);
  };
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
      Direction normal = known(site);
      normal = normal == Direction{} ? around.normal({x, y, z}) : normal;
      const bool is_between = normal == Direction{}; // of two walls: then it is held
      for (std::size_t a = 0; a < axes; ++a) {
        for (std::size_t b = a; b < axes; ++b) {
          const double entry = is_between ? (a == b ? 1.0 : 0.0) : normal[a] * normal[b];
          level.walls[symmetric_entry(axes, a, b)][site] += stiffness_of_walls * static_cast<float>(entry);
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

TurnOfNormals turn_of_normals(const std::vector<bool>& solid, const std::vector<bool>& shape,
                              const std::array<double, 3>& step, const Level& level) {
  constexpr std::size_t most_sites = 4000;
  const Extent extent = level.extent;
  std::vector<std::array<int, 3>> on_walls;
  for_each_site(extent, [&](int x, int y, int z) {
    if (is_on_wall(level, extent.index(x, y, z))) {
      on_walls.push_back({x, y, z});
    }
  });
  const std::size_t every = on_walls.size() / most_sites + 1;
  const std::size_t count = (on_walls.size() + every - 1) / every;
  const double radius = usual_radius(solid, extent, step);
  const double thick = thickness(solid, extent, step);
  const double farther =
      std::clamp(std::max(2.0 * radius, thick), radius, std::max(radius, reach_of_thickness * thick));
  const Surroundings around(solid, shape, extent, step, farther);
  std::vector<double> squares(count); // of the sine of each one's turn
  on_all_threads(count, true, [&](std::size_t number) {
    const std::array<int, 3>& place = on_walls[number * every];
    const std::size_t site = extent.index(place[0], place[1], place[2]);
    const Direction normal = around.normal(place);
    double along = 0.0;
    double trace = 0.0;
    for (std::size_t a = 0; a < extent.axes(); ++a) {
      for (std::size_t b = 0; b < extent.axes(); ++b) {
        const double entry =
            double{level.walls[symmetric_entry(extent.axes(), std::min(a, b), std::max(a, b))][site]};
        along += normal[a] * normal[b] * entry;
        trace += a == b ? entry : 0.0;
      }
    }
    squares[number] = std::clamp(1.0 - along / trace, 0.0, 1.0);
  });
  const double mean =
      count > 0 ? std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(count) : 0.0;
  return {
      .radius = radius, .farther = farther, .degrees = 180.0 / std::numbers::pi * std::asin(std::sqrt(mean))};
}

void set_rest_on_walls(Level& level) {
#pragma omp parallel for if (level.extent.sites() > sites_worth_threads)
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    if (is_on_wall(level, site)) {
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
      stiffness += double{level.walls[symmetric_entry(axes, a, a)][site]};
      for (std::size_t b = 0; b < axes; ++b) {
        square +=
            by_wall(a, site) * by_wall(b, site) * double{level.walls[symmetric_entry(axes, a, b)][site]};
      }
    }
    report.sites += stiffness > 0.0 ? 1 : 0;
    report.gave_way =
        std::max(report.gave_way, std::sqrt(std::max(0.0, square) / double{stiffness_of_walls}));
  }
  return report;
}

} // namespace hdmbench
