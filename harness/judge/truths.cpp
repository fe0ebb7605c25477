#include "harness/judge/truths.hpp"

#include "harness/judge/diagnosis/measures.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/pyramid.hpp"
#include "reference/finite_elements.hpp"
#include "reference/fixed_point.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// Sites within 5 pixels, along straight and diagonal steps, of one that has another modulus to its right or
/// below it.
std::vector<std::uint8_t> near_interfaces(const Level& level) {
  constexpr float reach = 5.0F;
  const Extent extent = level.extent;
  const std::vector<float>& modulus = level.modulus.values;
  std::vector<float> changes(extent.sites());
  for_each_site(extent, [&](int x, int y) {
    const std::size_t at = extent.index(x, y);
    const bool to_right = x + 1 < extent.width && modulus[extent.index(x + 1, y)] != modulus[at];
    const bool below = y + 1 < extent.height && modulus[extent.index(x, y + 1)] != modulus[at];
    changes[at] = to_right || below ? 1.0F : 0.0F;
  });
  std::vector<std::uint8_t> near(extent.sites());
  std::ranges::transform(diagnosis::distance_to_nearest(extent, changes, 1.414F), near.begin(),
                         [](float distance) { return static_cast<std::uint8_t>(distance <= reach); });
  return near;
}

bool has_sites(const std::vector<std::uint8_t>& mask) {
  return std::ranges::find(mask, std::uint8_t{1}) != mask.end();
}

} // namespace

ReferenceField difference(const ReferenceField& a, const ReferenceField& b) {
  if (a.extent != b.extent) {
    throw InputError(fmt::format("a field of {} x {} pixels cannot be compared with one of {} x {}",
                                 a.extent.width, a.extent.height, b.extent.width, b.extent.height));
  }
  ReferenceField result = a;
  for (std::size_t i = 0; i < a[0].size(); ++i) {
    result[0][i] -= b[0][i];
    result[1][i] -= b[1][i];
  }
  return result;
}

double rmsd(const ReferenceField& a, const ReferenceField& b, SiteMask counted) {
  const ReferenceField error = difference(a, b);
  double sum = 0.0;
  std::size_t sites = 0;
  for (std::size_t i = 0; i < error[0].size(); ++i) {
    if (counted.empty() || counted[i] != 0) {
      sum += error[0][i] * error[0][i] + error[1][i] * error[1][i];
      ++sites;
    }
  }
  return sites == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(sites));
}

Truths find_truths(const Scene& scene, Progress& progress) {
  Truths truths;
  progress.describe(fmt::format("{}: finite elements and the exact fixed point", scene.name));
  const auto solve = [](SolvedTruth& truth, const auto& solver) {
    truth.displacement = timed(truth.seconds, solver);
  };
  solve(truths.elastic, [&] { return find_finite_elements(scene.full, scene.poisson); });
  solve(truths.elastic_no_poisson, [&] { return find_finite_elements(scene.full, 0.0); });
  solve(truths.fixed_point, [&] { return solve_fixed_point(scene.full).displacement; });
  truths.interface = near_interfaces(scene.full);
  truths.elsewhere.resize(truths.interface.size());
  const VectorField& confidence = scene.full.confidence;
  for (std::size_t i = 0; i < truths.interface.size(); ++i) {
    const bool free = !(confidence[0][i] > 0.0F && confidence[1][i] > 0.0F);
    truths.elsewhere[i] = free && truths.interface[i] == 0 ? 1 : 0;
    truths.interface[i] = free ? truths.interface[i] : 0;
  }
  return truths;
}

ReferenceField find_finite_elements(const Level& level, double poisson) {
  return solve_finite_elements(elastic_problem(level), ElementRule::of(level.extent, poisson));
}

ReferenceField coarse_finite_elements(const Scene& scene, int elements, double poisson) {
  // Elements are squares: as many along the other side as its length has.
  const Extent full = scene.extent();
  const int longer = std::max(full.width, full.height);
  const auto nodes = [&](int sites) {
    const double share = static_cast<double>(sites - 1) / std::max(1, longer - 1);
    return std::min(sites, 1 + std::max(1, static_cast<int>(std::lround(elements * share))));
  };
  const Extent mesh{nodes(full.width), nodes(full.height)};
  const Level coarse = sample_level(scene.full, mesh, Alignment::corner);
  return thesis_prolongation(find_finite_elements(coarse, poisson), full);
}

Deviations measure(const ReferenceField& field, const Truths& truths) {
  const ReferenceField& fem = truths.elastic.displacement;
  Deviations result{.to_fem = rmsd(field, fem),
                    .to_fem_no_poisson = rmsd(field, truths.elastic_no_poisson.displacement),
                    .to_fixed_point = rmsd(field, truths.fixed_point.displacement)};
  if (has_sites(truths.interface) && has_sites(truths.elsewhere)) {
    result.interface_to_fem = rmsd(field, fem, truths.interface);
    result.elsewhere_to_fem = rmsd(field, fem, truths.elsewhere);
  }
  return result;
}

} // namespace hdmbench
