#include "harness/solve/methods/stationary_weights.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace hdmbench {

namespace {

/// More steps change the cycles' contraction no further.
constexpr int steps = 4;

constexpr std::array<std::array<int, 2>, 8> compass{
    {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

/// One site's way out: to which sites and with which probability. What would leave the image stays.
struct Departure {
  std::size_t from = 0;
  std::array<std::size_t, compass.size()> to{};
  std::array<float, compass.size()> x{}; ///< probability of the x problem's walk
  std::array<float, compass.size()> y{};
};

bool is_inside(Extent extent, int x, int y) {
  return x >= 0 && y >= 0 && x < extent.width && y < extent.height;
}

/// How far from an interface a site is.
enum Nearness : std::uint8_t {
  far = 0,
  beside = 1, ///< it does not change, but gives to those that do
  near = 2    ///< within `steps` of a site whose 3 x 3 has more than one modulus
};

std::vector<Nearness> nearness_of_interfaces(const Level& level) {
  const Extent extent = level.extent;
  std::vector<Nearness> result(extent.sites(), far);
  const auto mark = [&](int x, int y, int reach, Nearness nearness) {
    for (int v = std::max(0, y - reach); v <= std::min(extent.height - 1, y + reach); ++v) {
      for (int u = std::max(0, x - reach); u <= std::min(extent.width - 1, x + reach); ++u) {
        Nearness& found = result[extent.index(u, v)];
        found = std::max(found, nearness);
      }
    }
  };
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const float own = level.modulus.values[extent.index(x, y)];
      const bool uniform = std::ranges::all_of(compass, [&](const auto& way) {
        return !is_inside(extent, x + way[0], y + way[1]) ||
               level.modulus.values[extent.index(x + way[0], y + way[1])] == own;
      });
      if (!uniform) {
        mark(x, y, steps, near);
        mark(x, y, steps + 1, beside);
      }
    }
  }
  return result;
}

/// The probabilities are the coefficients of the neighbours in the gradient of the same component, over the
/// curvature.
Departure departure(const Level& level, int x, int y) {
  Departure result{.from = level.extent.index(x, y)};
  const Stencil stencil = level.energy->host->stencil(level, x, y);
  for (std::size_t i = 0; i < compass.size(); ++i) {
    const int u = x + compass[i][0];
    const int v = y + compass[i][1];
    result.to[i] = is_inside(level.extent, u, v) ? level.extent.index(u, v) : result.from;
    result.x[i] = -stencil.neighbours[i][0][0] / stencil.own.curvature_x;
    result.y[i] = -stencil.neighbours[i][1][1] / stencil.own.curvature_y;
  }
  return result;
}

void walk(std::vector<float>& weights, const std::vector<Departure>& departures,
          const std::vector<Nearness>& nearness,
          const std::array<float, compass.size()> Departure::*probability) {
  std::vector<float> moved(weights.size(), 0.0F);
  for (int step = 0; step < steps; ++step) {
    for (const Departure& departure : departures) {
      for (std::size_t i = 0; i < compass.size(); ++i) {
        const float part = 0.5F * weights[departure.from] * (departure.*probability)[i];
        moved[departure.from] -= part;
        moved[departure.to[i]] += part;
      }
    }
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weights[i] += nearness[i] == near ? moved[i] : 0.0F;
      moved[i] = 0.0F;
    }
  }
}

} // namespace

VectorField stationary_weights(const Level& level) {
  const Extent extent = level.extent;
  const std::vector<Nearness> nearness = nearness_of_interfaces(level);
  std::vector<Departure> departures;
  for_each_site(extent, [&](int x, int y) {
    if (nearness[extent.index(x, y)] != far) {
      departures.push_back(departure(level, x, y));
    }
  });
  VectorField weights;
  weights.extent = extent;
  weights.x = level.modulus.values;
  weights.y = level.modulus.values;
  walk(weights.x, departures, nearness, &Departure::x);
  walk(weights.y, departures, nearness, &Departure::y);
  return weights;
}

} // namespace hdmbench
