#include "harness/tools/energy_plane.hpp"

#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

double site_energy(const ThesisEnergy& energy, SiteIndex site) {
  const ThesisEnergy::Value value = energy.at(site.x, site.y);
  return value.x + value.y;
}

void require_range(const EnergyPlaneOptions& options) {
  const bool finite =
      std::isfinite(static_cast<float>(options.low)) && std::isfinite(static_cast<float>(options.high));
  if (!(options.low < options.high) || !finite) {
    throw InputError(
        fmt::format("the range {} ... {} pixels is empty or not finite", options.low, options.high));
  }
  if (options.points < 2) {
    throw InputError(fmt::format("{} points are too few, at least 2 are needed", options.points));
  }
}

} // namespace

void require_sites(const std::array<SiteIndex, 2>& sites, Extent extent) {
  for (const SiteIndex site : sites) {
    if (site.x < 0 || site.x >= extent.width || site.y < 0 || site.y >= extent.height) {
      throw InputError(fmt::format("there is no site {},{} in an image of {} x {} pixels", site.x, site.y,
                                   extent.width, extent.height));
    }
  }
  if (sites[0] == sites[1]) {
    throw InputError(
        fmt::format("the site {},{} is given twice, two different ones are needed", sites[0].x, sites[0].y));
  }
}

double total_energy(const Level& level, const VectorField& displacement) {
  const ThesisEnergy energy(level, displacement);
  double sum = 0.0;
  for_each_site(level.extent, [&](int x, int y) { sum += site_energy(energy, {x, y}); });
  return sum;
}

EnergyPlane energy_plane(const Level& level, VectorField displacement, const EnergyPlaneOptions& options) {
  require_sites(options.sites, level.extent);
  require_range(options);
  const ThesisEnergy energy(level, displacement);
  const auto sees = [&](SiteIndex site) {
    return std::ranges::any_of(options.sites, [&](SiteIndex moved) {
      return std::abs(moved.x - site.x) <= 1 && std::abs(moved.y - site.y) <= 1;
    });
  };
  std::vector<SiteIndex> affected;
  double constant = 0.0;
  for_each_site(level.extent, [&](int x, int y) {
    if (sees({x, y})) {
      affected.push_back({x, y});
    } else {
      constant += site_energy(energy, {x, y});
    }
  });

  EnergyPlane plane;
  for (int i = 0; i < options.points; ++i) {
    plane.values.push_back(
        static_cast<float>(std::lerp(options.low, options.high, double(i) / (options.points - 1))));
  }
  auto& component = options.component == Component::x ? displacement.x : displacement.y;
  float& first = component[level.extent.index(options.sites[0].x, options.sites[0].y)];
  float& second = component[level.extent.index(options.sites[1].x, options.sites[1].y)];
  plane.energy.reserve(plane.values.size() * plane.values.size());
  for (const float value_of_second : plane.values) {
    for (const float value_of_first : plane.values) {
      first = value_of_first;
      second = value_of_second;
      double sum = constant;
      for (const SiteIndex site : affected) {
        sum += site_energy(energy, site);
      }
      plane.energy.push_back(sum);
    }
  }
  plane.lowest = static_cast<std::size_t>(std::ranges::min_element(plane.energy) - plane.energy.begin());
  return plane;
}

} // namespace hdmbench
