#include "harness/judge/truths.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/judge/diagnosis/measures.hpp"
#include "harness/scene/laws.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/pyramid.hpp"
#include "reference/finite_elements.hpp"
#include "reference/fixed_point.hpp"
#include "reference/large_strains.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hdmbench {

namespace {

/// Sites within 5 pixels, along straight and diagonal steps, of one that has another modulus than the next
/// one along an axis.
std::vector<std::uint8_t> near_interfaces(const Level& level) {
  constexpr float reach = 5.0F;
  const Extent extent = level.extent;
  const std::vector<float>& modulus = level.modulus.values;
  std::vector<float> changes(extent.sites());
  diagnosis::for_each_pair(extent, [&](std::size_t one, std::size_t next, std::size_t /*axis*/) {
    changes[one] = modulus[one] != modulus[next] ? 1.0F : changes[one];
  });
  std::vector<std::uint8_t> near(extent.sites());
  std::ranges::transform(diagnosis::distance_to_nearest(extent, changes, 1.414F), near.begin(),
                         [](float distance) { return static_cast<std::uint8_t>(distance <= reach); });
  return near;
}

/// Returns the fibres of the level's tissues.
ReferenceFibres fibres_of(const Level& level) {
  const std::size_t sites = level.extent.sites();
  ReferenceFibres fibres{
      .direction = {}, .modulus = std::vector<double>(sites), .tension_only = std::vector<bool>(sites)};
  std::ranges::fill(fibres.direction, std::vector<double>(sites));
  for (std::size_t site = 0; site < sites; ++site) {
    double square = 0.0;
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      square += double{level.fibre[axis][site]} * double{level.fibre[axis][site]};
    }
    for (std::size_t axis = 0; axis < level.extent.axes() && square > 0.0; ++axis) {
      fibres.direction[axis][site] = double{level.fibre[axis][site]} / std::sqrt(square);
    }
    fibres.modulus[site] = square * square * double{level.modulus.values[site]};
    fibres.tension_only[site] = level.fibre_compression.values[site] == 0.0F;
  }
  return fibres;
}

/// Throws InputError where the truths of a scene do not fit into memory, by the peaks of `tradeoff`: of
/// `square` with 300 and 600 pixels a side, of `ball` with 24 to 48 voxels by a law and 40 to 64 without, of
/// a brain of 91 x 109 x 91 with loads. They are within a fifth.
void require_memory_for_truths(const Scene& scene) {
  const Extent extent = scene.extent();
  const std::string_view who = "the truth against which all is measured: ";
  if (extent.axes() == 2) {
    require_memory(extent, 3600.0, 1.0, who);
  } else if (has_laws(scene.full)) {
    require_memory(extent, 1000.0, 4.0 / 3.0, who); // factors
  } else {
    require_memory(extent, is_of_tissue(scene) ? 4000.0 : 13000.0, 1.0, who);
  }
}

bool has_sites(const std::vector<std::uint8_t>& mask) {
  return std::ranges::find(mask, std::uint8_t{1}) != mask.end();
}

} // namespace

ReferenceField difference(const ReferenceField& a, const ReferenceField& b) {
  if (a.extent != b.extent) {
    throw InputError(fmt::format("a field of {} sites cannot be compared with one of {}", a.extent.text(),
                                 b.extent.text()));
  }
  ReferenceField result(a.extent);
  for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
    std::ranges::transform(a[axis], b[axis], result[axis].begin(), std::minus());
  }
  return result;
}

double rmsd(const ReferenceField& a, const ReferenceField& b, SiteMask counted) {
  const ReferenceField error = difference(a, b);
  double sum = 0.0;
  std::size_t sites = 0;
  for (std::size_t i = 0; i < error[0].size(); ++i) {
    if (counted.empty() || counted[i] != 0) {
      for (std::size_t axis = 0; axis < error.extent.axes(); ++axis) {
        sum += error[axis][i] * error[axis][i];
      }
      ++sites;
    }
  }
  return sites == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(sites));
}

bool is_of_tissue(const Scene& scene) {
  return has_laws(scene.full) || has_forces(scene.full) || has_springs_by_direction(scene.full);
}

Truths find_truths(const Scene& scene, Progress& progress) {
  require_memory_for_truths(scene);
  Truths truths;
  const bool is_common = !is_of_tissue(scene);
  progress.describe(fmt::format("{}: finite elements{}", scene.name,
                                has_laws(scene.full) ? " by laws of large strains"
                                : is_common          ? " and the exact fixed point"
                                                     : ""));
  const auto solve = [](SolvedTruth& truth, const auto& solver) {
    truth.displacement = timed(truth.seconds, solver);
  };
  if (has_laws(scene.full)) {
    truths.elastic = find_large_strains(scene);
  } else {
    solve(truths.elastic, [&] { return find_finite_elements(scene.full, scene.elastic); });
  }
  if (is_common) {
    solve(truths.elastic_no_poisson.emplace(), [&] { return find_finite_elements(scene.full, 0.0); });
    solve(truths.fixed_point.emplace(), [&] { return solve_fixed_point(scene.full).displacement; });
  }
  const ScalarField tissue = tissue_of(scene);
  truths.tissue.assign(tissue.values.begin(), tissue.values.end());
  truths.interface = near_interfaces(scene.full);
  truths.elsewhere.resize(truths.interface.size());
  const VectorField& confidence = scene.full.confidence;
  for (std::size_t i = 0; i < truths.interface.size(); ++i) {
    bool free = false;
    for (std::size_t axis = 0; axis < scene.extent().axes(); ++axis) {
      free = free || !(confidence[axis][i] > 0.0F);
    }
    free = free && (truths.tissue.empty() || truths.tissue[i] != 0);
    truths.elsewhere[i] = free && truths.interface[i] == 0 ? 1 : 0;
    truths.interface[i] = free ? truths.interface[i] : 0;
  }
  return truths;
}

bool takes_direct_factors(Extent extent) {
  constexpr std::size_t most_voxels = 40'000;
  return extent.axes() == 2 || extent.sites() <= most_voxels;
}

ReferenceField find_finite_elements(const Level& level, const ElasticModel& model) {
  constexpr double tolerance = 1e-10; // 1e-9 voxels from a direct factorisation
  const ElasticProblem problem = elastic_problem(level);
  const ElementRule rule = ElementRule::of(level.extent, model);
  return takes_direct_factors(level.extent)
             ? solve_finite_elements(problem, rule)
             : solve_finite_elements_iteratively(problem, rule, tolerance).displacement;
}

SolvedTruth find_large_strains(const Scene& scene) {
  const Level& full = scene.full;
  if (&law_of(full) != &laws::neo_hookean::law) {
    throw InputError(fmt::format("there is no reference solution by the law \"{}\"", law_name(full)));
  }
  const ReferenceFibres fibres = has_fibres(full) ? fibres_of(full) : ReferenceFibres{};
  const std::vector<double> stiffening(full.law_parameter.values.begin(), full.law_parameter.values.end());
  for (int parts = 1;; parts *= 8) { // of the load
    try {
      SolvedTruth truth;
      truth.displacement = timed(truth.seconds, [&] {
        return solve_large_strains(elastic_problem(full), stiffening, scene.elastic.poisson, parts,
                                   has_fibres(full) ? &fibres : nullptr);
      });
      return truth;
    } catch (const InputError&) {
      if (parts == 8) {
        throw;
      }
    }
  }
}

ReferenceField coarse_finite_elements(const Scene& scene, int elements, const ElasticModel& model) {
  // Elements are squares or cubes: as many along each other side as its length has.
  const Extent full = scene.extent();
  const int longest = std::ranges::max(full.sides());
  const auto nodes = [&](int sites) {
    const double share = static_cast<double>(sites - 1) / std::max(1, longest - 1);
    return std::min(sites, 1 + std::max(1, static_cast<int>(std::lround(elements * share))));
  };
  const Extent mesh{nodes(full.width), nodes(full.height), nodes(full.depth)};
  const Level coarse = sample_level(scene.full, mesh, Alignment::corner);
  return thesis_prolongation(find_finite_elements(coarse, model), full);
}

Deviations measure(const ReferenceField& field, const Truths& truths) {
  const ReferenceField& fem = truths.elastic.displacement;
  Deviations result{.to_fem = rmsd(field, fem, truths.tissue)};
  if (truths.elastic_no_poisson) {
    result.to_fem_no_poisson = rmsd(field, truths.elastic_no_poisson->displacement, truths.tissue);
  }
  if (truths.fixed_point) {
    result.to_fixed_point = rmsd(field, truths.fixed_point->displacement, truths.tissue);
  }
  if (has_sites(truths.interface) && has_sites(truths.elsewhere)) {
    result.interface_to_fem = rmsd(field, fem, truths.interface);
    result.elsewhere_to_fem = rmsd(field, fem, truths.elsewhere);
  }
  return result;
}

} // namespace hdmbench
