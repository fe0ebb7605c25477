#include "harness/judge/diagnosis/checks.hpp"
#include "harness/judge/diagnosis/regions.hpp"
#include "harness/scene/level_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hdmbench::diagnosis {

namespace {

/// Full resolution sites per site of a level, along the axis where they are most.
double spacing_of(Extent full, Extent level) {
  return std::max(static_cast<double>(full.width) / level.width,
                  static_cast<double>(full.height) / level.height);
}

/// 1 where a component is observed, else 0.
VectorField observed(const VectorField& confidence) {
  VectorField mask(confidence.extent);
  const auto is_known = [](float value) { return value > 0.0F ? 1.0F : 0.0F; };
  std::ranges::transform(confidence.x, mask.x.begin(), is_known);
  std::ranges::transform(confidence.y, mask.y.begin(), is_known);
  return mask;
}

/// What conditions can have reached: the first sweep gives an observed component its target, each further one
/// carries it to the next site, and interpolation to the finer sites around. Whatever is left out has its
/// start value to the last bit.
void check_reach(const Scene& scene, Warnings& warnings) {
  const Schedule& schedule = scene.schedule;
  if (scene.full.update == Update::sequential) {
    return; // in place a value crosses the image in one sweep
  }
  LevelSequence levels(scene);
  VectorField informed; // > 0 where something has arrived
  for (const int index : levels.order()) {
    const Level& level = levels.sample(index);
    const VectorField known = observed(level.confidence);
    const VectorField before = index == levels.order().front()
                                   ? VectorField(level.extent)
                                   : prolongate(informed, level.extent, schedule.alignment);
    const int way = levels.iterations(index) * sweeps_per_iteration(level);
    informed = VectorField(level.extent);
    const auto spread = [&](const std::vector<float>& from, const std::vector<float>& present,
                            std::vector<float>& to) {
      const std::vector<int> to_known = distance_to_nearest(level.extent, from);
      const std::vector<int> to_present = distance_to_nearest(level.extent, present);
      std::ranges::transform(to_known, to_present, to.begin(),
                             [&](int a, int b) { return a + 1 <= way || b <= way ? 1.0F : 0.0F; });
    };
    spread(known.x, before.x, informed.x);
    spread(known.y, before.y, informed.y);
  }
  for (const Component& component : components(scene)) {
    if (!target_range(component).any) {
      continue; // undetermined
    }
    const auto& arrived = component.name == 'x' ? informed.x : informed.y;
    const auto missed = static_cast<std::size_t>(std::ranges::count(arrived, 0.0F));
    if (missed > 0) {
      const int farthest = std::ranges::max(distance_to_nearest(scene.extent(), component.confidence));
      warnings.push_back(
          {"out-of-reach",
           fmt::format("no condition can reach {} of {} sites in {}: the farthest is {} px from one, a sweep "
                       "carries a value one site on, and the schedule has {} iterations on {} level{}; these "
                       "sites keep their start",
                       missed, arrived.size(), component.name, farthest, schedule.iterations,
                       levels.order().size(), levels.order().size() == 1 ? "" : "s"),
           schedule.start_level ? "a larger --start-level or none, more --iterations, or --energy elastic"
                                : "more --iterations, or --energy elastic",
           missed});
    }
  }
}

/// A sweep moves a component by the largest candidate at most, and interpolation invents no displacement.
void check_steps(const Scene& scene, Warnings& warnings) {
  if (scene.schedule.rule != Rule::steps) {
    return;
  }
  const LevelSequence levels(scene);
  double iterations = 0.0;
  for (const int index : levels.order()) {
    iterations += levels.iterations(index);
  }
  const double largest = step_sizes(scene.full.steps).largest;
  const double way = iterations * largest;
  for (const Component& component : components(scene)) {
    std::size_t beyond = 0;
    double farthest = 0.0;
    for (std::size_t i = 0; i < component.target.size(); ++i) {
      const double gap = std::abs(static_cast<double>(component.target[i]) - component.start_of(i));
      if (component.confidence[i] > 0.0F && gap > way) {
        ++beyond;
        farthest = std::max(farthest, gap);
      }
    }
    if (beyond > 0) {
      warnings.push_back(
          {"too-few-steps",
           fmt::format("{} conditions in {} lie up to {:.4g} px from the start, but {:.0f} iterations of at "
                       "most {:.3g} px move a site by {:.4g} px",
                       beyond, component.name, farthest, iterations, largest, way),
           "more --iterations, larger candidates (--steps 0,-10,10,-1,1,-0.1,0.1), or --method cascade, "
           "whose "
           "sites move any distance at once",
           beyond});
    }
  }
}

/// The finest computed level whose sites are at least two pixels apart, -1: none. What it lacks exists on the
/// full resolution only, or on a level that is hardly coarser.
int finest_coarse_level(const LevelSequence& levels, Extent full) {
  int finest = -1;
  for (const int index : levels.order()) {
    finest = spacing_of(full, levels.extent(index)) >= 2.0 ? index : finest;
  }
  return finest;
}

/// A coarse level has an observed component where one of the four of its sites around it is observed, and
/// stands for it where that is so within two of its sites.
void check_lost_conditions(const Scene& scene, Warnings& warnings) {
  LevelSequence levels(scene);
  const int coarse = finest_coarse_level(levels, scene.extent());
  if (coarse < 0) {
    return;
  }
  const Extent extent = levels.extent(coarse);
  const double near = 2.0 * spacing_of(scene.extent(), extent);
  const VectorField known = observed(scene.full.confidence);
  VectorField present =
      prolongate(observed(levels.sample(coarse).confidence), scene.extent(), scene.schedule.alignment);
  std::ranges::transform(present.x, known.x, present.x.begin(), std::multiplies());
  std::ranges::transform(present.y, known.y, present.y.begin(), std::multiplies());
  for (const Component& component : components(scene)) {
    const std::vector<int> to_present =
        distance_to_nearest(scene.extent(), component.name == 'x' ? present.x : present.y);
    std::size_t lost = 0;
    std::size_t all = 0;
    for (std::size_t i = 0; i < to_present.size(); ++i) {
      const bool is_known = component.confidence[i] > 0.0F;
      all += is_known ? 1 : 0;
      lost += is_known && to_present[i] > near ? 1 : 0;
    }
    if (lost > 0) {
      warnings.push_back(
          {"lost-condition",
           fmt::format(
               "{} of {} conditions in {} are neither there nor near by on the {} x {} level: they reach "
               "the field only through the finest levels, one site a sweep",
               lost, all, component.name, extent.width, extent.height),
           scene.schedule.alignment == Alignment::center
               ? "--alignment corner keeps conditions on the image border; --energy elastic corrects what "
                 "coarse levels miss"
               : "give landmarks an area of a few pixels, or --energy elastic, whose cycles correct what "
                 "coarse "
                 "levels miss",
           lost});
    }
  }
}

/// A region at least two sites of a level long shapes the field that the level computes; nearest neighbour
/// sampling may still step over it where it is thin.
void check_lost_tissue(const Scene& scene, Warnings& warnings) {
  LevelSequence levels(scene);
  if (scene.schedule.mean_modulus || finest_coarse_level(levels, scene.extent()) < 0) {
    return;
  }
  const Regions regions = find_regions(scene.full.modulus);
  std::vector<bool> lost(regions.all.size(), false);
  Extent finest;
  for (const int index : levels.order()) {
    const Extent extent = levels.extent(index);
    const double spacing = spacing_of(scene.extent(), extent);
    if (spacing < 2.0) {
      continue;
    }
    std::vector<bool> sampled(regions.all.size(), false);
    for (int y = 0; y < extent.height; ++y) {
      const int fine_y = sampled_index(y, extent.height, scene.extent().height, scene.schedule.alignment);
      for (int x = 0; x < extent.width; ++x) {
        const int fine_x = sampled_index(x, extent.width, scene.extent().width, scene.schedule.alignment);
        sampled[static_cast<std::size_t>(regions.of_site[scene.extent().index(fine_x, fine_y)])] = true;
      }
    }
    for (std::size_t i = 0; i < lost.size(); ++i) {
      if (!sampled[i] && regions.all[i].longest_side() >= 2.0 * spacing) {
        lost[i] = true;
        finest = extent;
      }
    }
  }
  std::size_t sites = 0;
  int longest = 0;
  for (std::size_t i = 0; i < lost.size(); ++i) {
    if (lost[i]) {
      sites += regions.all[i].sites;
      longest = std::max(longest, regions.all[i].longest_side());
    }
  }
  if (sites > 0) {
    warnings.push_back(
        {"lost-tissue",
         fmt::format(
             "{} of {} regions of one modulus (up to {} px long, {} sites) are stepped over by a level "
             "whose sites they are at least two of long; the finest such level is {} x {}",
             std::ranges::count(lost, true), regions.all.size(), longest, sites, finest.width, finest.height),
         "--method cascade: its coarse levels take the mean of the moduli they stand for", sites});
  }
}

} // namespace

void check_pyramid(const Scene& scene, Warnings& warnings) {
  check_reach(scene, warnings);
  check_steps(scene, warnings);
  check_lost_conditions(scene, warnings);
  check_lost_tissue(scene, warnings);
}

} // namespace hdmbench::diagnosis
