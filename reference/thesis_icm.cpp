#include "reference/thesis_energy.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace hdmbench {

namespace {

struct Offset {
  int x;
  int y;
};

double square(double value) {
  return value * value;
}

/// A triple s - t - u of one component: displacements of s and u, and m_t / m_s, m_t / m_u.
struct Triple {
  double ds, du, k, r;

  /// (4.7) with d_t.
  [[nodiscard]] double potential(double dt) const {
    return square(r * (dt - ds) - (du - dt)) + square(k * (dt - du) - (ds - dt));
  }
};

/// One component of a level: the ways from t to u of its triples, and what is observed of it.
struct Component {
  std::array<Offset, 3> ways;
  const std::vector<float>& target;
  const std::vector<float>& confidence;
};

/// The triple of site (x, y) along `to`. A neighbour outside the image has the displacement and the modulus
/// of t.
Triple triple_at(const Level& level, const std::vector<double>& displacement, int x, int y, Offset to) {
  const Extent extent = level.extent;
  const auto neighbour = [&](int nx, int ny) {
    const bool inside = nx >= 0 && nx < extent.width && ny >= 0 && ny < extent.height;
    return inside ? extent.index(nx, ny) : extent.index(x, y);
  };
  const auto modulus = [&](std::size_t site) { return static_cast<double>(level.modulus.values[site]); };
  const std::size_t s = neighbour(x - to.x, y - to.y);
  const std::size_t u = neighbour(x + to.x, y + to.y);
  const double mt = modulus(extent.index(x, y));
  return {displacement[s], displacement[u], mt / modulus(s), mt / modulus(u)};
}

/// The first candidate of the smallest energy.
double best_candidate(const Level& level, const Component& component, const std::vector<double>& displacement,
                      int x, int y) {
  const std::size_t site = level.extent.index(x, y);
  std::array<Triple, 3> triples{};
  std::ranges::transform(component.ways, triples.begin(),
                         [&](Offset to) { return triple_at(level, displacement, x, y, to); });
  const double pull = static_cast<double>(level.penalty) * static_cast<double>(component.confidence[site]);
  const double target = static_cast<double>(component.target[site]);
  double best = displacement[site];
  double lowest = std::numeric_limits<double>::infinity();
  for (const float step : level.steps.values()) {
    const double candidate = displacement[site] + static_cast<double>(step);
    const double energy = triples[0].potential(candidate) + triples[1].potential(candidate) +
                          triples[2].potential(candidate) + pull * std::abs(target - candidate);
    best = energy < lowest ? candidate : best;
    lowest = std::min(energy, lowest);
  }
  return best;
}

void require_extent(const ReferenceField& field, Extent extent) {
  if (field.extent != extent || field[0].size() != extent.sites() || field[1].size() != extent.sites()) {
    throw InputError(fmt::format("the displacement is {} x {}, the level is {} x {}", field.extent.width,
                                 field.extent.height, extent.width, extent.height));
  }
}

/// Where site i of `fine` lies among `coarse` sites: the outermost ones are at the same place.
struct Place {
  int before, after;
  double weight; ///< of the one after
};
Place place_of(int i, int coarse, int fine) {
  const double position = fine > 1 ? static_cast<double>(i) * (coarse - 1) / (fine - 1) : 0.0;
  const int before = static_cast<int>(position);
  return {before, std::min(before + 1, coarse - 1), position - before};
}

} // namespace

ReferenceField thesis_iteration(const Level& level, const ReferenceField& displacement) {
  validate(level);
  require_extent(displacement, level.extent);
  const Component in_x{{{{1, 0}, {1, 1}, {1, -1}}}, level.target[0], level.confidence[0]};
  const Component in_y{{{{0, 1}, {1, 1}, {1, -1}}}, level.target[1], level.confidence[1]};
  ReferenceField next(level.extent);
#pragma omp parallel for schedule(static)
  for (int y = 0; y < level.extent.height; ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      const std::size_t site = level.extent.index(x, y);
      next[0][site] = best_candidate(level, in_x, displacement[0], x, y);
      next[1][site] = best_candidate(level, in_y, displacement[1], x, y);
    }
  }
  return next;
}

ReferenceField thesis_prolongation(const ReferenceField& coarse, Extent fine) {
  require_extent(coarse, coarse.extent);
  ReferenceField result(fine);
  for (int y = 0; y < fine.height; ++y) {
    const Place row = place_of(y, coarse.extent.height, fine.height);
    for (int x = 0; x < fine.width; ++x) {
      const Place column = place_of(x, coarse.extent.width, fine.width);
      const auto interpolated = [&](const std::vector<double>& from) {
        const auto along = [&](int of_row) {
          return std::lerp(from[coarse.extent.index(column.before, of_row)],
                           from[coarse.extent.index(column.after, of_row)], column.weight);
        };
        return std::lerp(along(row.before), along(row.after), row.weight);
      };
      result[0][fine.index(x, y)] = interpolated(coarse[0]);
      result[1][fine.index(x, y)] = interpolated(coarse[1]);
    }
  }
  return result;
}

} // namespace hdmbench
