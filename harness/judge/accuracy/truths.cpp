#include "harness/judge/accuracy/truths.hpp"

#include "harness/scene/sites.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/pyramid.hpp"
#include "reference/finite_elements.hpp"
#include "reference/thesis_icm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

FiniteElements solve_elastic(const Level& level, double poisson) {
  FiniteElements result{.poisson = poisson};
  result.displacement = timed(result.seconds, [&] {
    return solve_finite_elements(elastic_problem(level), ElementRule::plane_stress(poisson));
  });
  return result;
}

constexpr int interface_reach = 5; // pixels

/// Marks the sites within reach of `centre`.
void mark_disc(std::vector<std::uint8_t>& marked, Extent extent, int centre_x, int centre_y) {
  for (int dy = -interface_reach; dy <= interface_reach; ++dy) {
    for (int dx = -interface_reach; dx <= interface_reach; ++dx) {
      const int x = centre_x + dx;
      const int y = centre_y + dy;
      if (dx * dx + dy * dy <= interface_reach * interface_reach && x >= 0 && y >= 0 && x < extent.width &&
          y < extent.height) {
        marked[extent.index(x, y)] = 1;
      }
    }
  }
}

/// Sites within reach of a pixel that has another modulus to its right or below it.
std::vector<std::uint8_t> near_interfaces(const Level& level) {
  const Extent extent = level.extent;
  const std::vector<float>& modulus = level.modulus.values;
  std::vector<std::uint8_t> near(extent.sites(), 0);
  for_each_site(extent, [&](int x, int y) {
    const float own = modulus[extent.index(x, y)];
    if ((x + 1 < extent.width && modulus[extent.index(x + 1, y)] != own) ||
        (y + 1 < extent.height && modulus[extent.index(x, y + 1)] != own)) {
      mark_disc(near, extent, x, y);
    }
  });
  return near;
}

void find_regions(const Level& level, Truths& truths) {
  const std::vector<std::uint8_t> near = near_interfaces(level);
  truths.interface.resize(near.size());
  truths.elsewhere.resize(near.size());
  for (std::size_t i = 0; i < near.size(); ++i) {
    const bool free = !(level.confidence.x[i] > 0.0F && level.confidence.y[i] > 0.0F);
    truths.free_sites += free ? 1 : 0;
    truths.interface[i] = free && near[i] != 0 ? 1 : 0;
    truths.elsewhere[i] = free && near[i] == 0 ? 1 : 0;
  }
  truths.interface_sites = static_cast<std::size_t>(std::ranges::count(truths.interface, std::uint8_t{1}));
}

} // namespace

Truths find_truths(const Scene& scene, Progress& progress) {
  Truths truths;
  if (scene.robust) {
    throw InputError(fmt::format("{} forgives observations (robust); the truths here do not", scene.name));
  }
  progress.describe(fmt::format("{}: finite elements, Poisson ratio {}", scene.name, scene.poisson));
  truths.elastic = find_finite_elements(scene, scene.poisson);
  progress.describe(fmt::format("{}: finite elements, Poisson ratio 0", scene.name));
  truths.elastic_no_poisson = find_finite_elements(scene, 0.0);
  progress.describe(fmt::format("{}: the exact fixed point", scene.name));
  truths.fixed_point = timed(truths.fixed_point_seconds, [&] { return solve_fixed_point(scene.full); });
  find_regions(scene.full, truths);
  return truths;
}

FiniteElements find_finite_elements(const Scene& scene, double poisson) {
  return solve_elastic(scene.full, poisson);
}

FiniteElements coarse_finite_elements(const Scene& scene, int elements, double poisson) {
  // Elements are squares: as many along the other side as its length has.
  const Extent full = scene.extent();
  const int longer = std::max(full.width, full.height);
  const auto nodes = [&](int sites) {
    const double share = static_cast<double>(sites - 1) / std::max(1, longer - 1);
    return std::min(sites, 1 + std::max(1, static_cast<int>(std::lround(elements * share))));
  };
  const Extent mesh{nodes(full.width), nodes(full.height)};
  FiniteElements result = solve_elastic(sample_level(scene.full, mesh, Alignment::corner), poisson);
  result.displacement = thesis_prolongation(result.displacement, scene.extent(), Alignment::corner);
  return result;
}

Deviations measure(const ReferenceField& field, const Truths& truths) {
  const ReferenceField& fem = truths.elastic.displacement;
  const ReferenceField& no_poisson = truths.elastic_no_poisson.displacement;
  const ReferenceField& fixed_point = truths.fixed_point.displacement;
  Deviations result{.to_fem = rmsd(field, fem),
                    .to_fem_no_poisson = rmsd(field, no_poisson),
                    .to_fixed_point = rmsd(field, fixed_point)};
  if (truths.interface_sites > 0 && truths.interface_sites < truths.free_sites) {
    result.interface_to_fem = rmsd(field, fem, truths.interface);
    result.elsewhere_to_fem = rmsd(field, fem, truths.elsewhere);
  }
  return result;
}

} // namespace hdmbench
