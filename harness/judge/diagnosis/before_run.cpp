#include "harness/judge/diagnosis/measures.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/elastic/wall_hold.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

namespace hdmbench {

using namespace diagnosis;
using namespace fmt::literals;

namespace {

/// Who forgets what moves the tissue would get a field of zeros that nothing speaks against.
void check_what_moves(const Scene& scene, Warnings& warnings) {
  const Level& full = scene.full;
  const bool is_observed = has_springs_by_direction(full); // whatever confidences say
  const auto is_set = [](const std::vector<float>& values) {
    return std::ranges::any_of(values, [](float value) { return value != 0.0F; });
  };
  bool is_moved = std::ranges::any_of(full.force.planes, is_set); // loads may weigh nothing
  for (std::size_t axis = 0; axis < full.extent.axes() && !is_moved; ++axis) {
    for (std::size_t site = 0; site < full.extent.sites() && !is_moved; ++site) {
      is_moved = full.target[axis][site] != 0.0F && (is_observed || full.confidence[axis][site] > 0.0F);
    }
    is_moved = is_moved || (scene.start && is_set((*scene.start)[axis]));
  }
  if (!is_moved) {
    warn(warnings, "nothing-moves", std::nullopt);
  }
}

void check_undetermined(const Scene& scene, const Component& component, Warnings& warnings) {
  const Undetermined found = find_undetermined(component.thickness, component.confidence);
  if (found.sites > 0) {
    warn(warnings, "undetermined", found.sites, "component"_a = component.name,
         "place"_a = scene.extent().place(found.first));
  }
}

/// Neighbours of a site on one side of it, and so the lines that a component has through it: 3, in a
/// volume 9.
double neighbours_aside(const Scene& scene) {
  return scene.extent().axes() == 2 ? 3.0 : 9.0;
}

/// A condition holds while K c / 2 >= |g|, half the derivative of the prior by its component. In one
/// material every neighbour pulls with the weight (1 + r) r + (1 + k) = 4; a site on the edge of a uniform
/// slope of G px per site has neighbours on one side only and so |g| = 3 * 4 * G = 12 G, in a volume 36 G. G
/// is at least the range of the targets over the width of the image.
void check_weak_penalty(const Scene& scene, const Component& component, Warnings& warnings) {
  const double slope = component.known.width() / std::max(1, component.thickness - 1);
  const double needed = 2.0 * 4.0 * neighbours_aside(scene) * slope;
  const auto certain = static_cast<std::size_t>(std::ranges::count(component.confidence, 1.0F));
  if (component.thickness > 1 && certain > 0 && static_cast<double>(scene.full.penalty) < needed) {
    warn(warnings, "weak-penalty", certain, "penalty"_a = scene.full.penalty,
         "apart"_a = component.known.width(), "component"_a = component.name, "slope"_a = slope,
         "needed"_a = needed, "enough"_a = std::ceil(10.0 * needed));
  }
}

/// Along a component's own direction the site at t + 1 lands behind the one at t where the target falls by a
/// pixel or more, and a hole wider than a pixel opens where it rises by more than one; across it, a step of
/// more than a pixel shears neighbours apart. Springs of an elastic body give way between each other.
void check_conflicts(const Scene& scene, Warnings& warnings) {
  const Extent extent = scene.extent();
  const auto is_given = [of_cells = scene.energy->is_of_cells()](float confidence) {
    return of_cells ? confidence >= 1.0F : confidence > 0.0F;
  };
  std::size_t folds = 0;
  Seen steps;
  for (const Component& component : components(scene)) {
    if (component.known.width() < 1.0) {
      continue; // no two targets are that far apart
    }
    for_each_pair(extent, [&](std::size_t site, std::size_t next, std::size_t axis) {
      const double rise = double{component.target[next]} - double{component.target[site]};
      const bool fold = axis == component.axis && rise <= -1.0;
      if (is_given(component.confidence[site]) && is_given(component.confidence[next]) &&
          (fold || std::abs(rise) > 1.0)) {
        folds += fold ? 1 : 0;
        steps.add(std::abs(rise), site);
      }
    });
  }
  if (steps.count > 0) {
    warn(warnings, "conflict", steps.count, "folds"_a = folds, "tears"_a = steps.count - folds,
         "most"_a = steps.most, "place"_a = extent.place(steps.worst));
  }
}

/// Full resolution sites per site of a level, along the axis where they are most.
double spacing_of(Extent full, Extent level) {
  double most = 0.0;
  for (std::size_t axis = 0; axis < full.axes(); ++axis) {
    most = std::max(most, static_cast<double>(full.sides()[axis]) / level.sides()[axis]);
  }
  return most;
}

/// 1 where a component is observed, else 0.
VectorField observed(const VectorField& confidence) {
  VectorField mask(confidence.extent);
  for (std::size_t axis = 0; axis < confidence.extent.axes(); ++axis) {
    std::ranges::transform(confidence[axis], mask[axis].begin(),
                           [](float value) { return value > 0.0F ? 1.0F : 0.0F; });
  }
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
    const auto way = static_cast<float>(levels.iterations(index) * sweeps_per_iteration(level));
    informed = VectorField(level.extent);
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      std::ranges::transform(distance_to_nearest(level.extent, known[axis]),
                             distance_to_nearest(level.extent, before[axis]), informed[axis].begin(),
                             [&](float to_known, float to_present) {
                               return to_known + 1.0F <= way || to_present <= way ? 1.0F : 0.0F;
                             });
    }
  }
  for (const Component& component : components(scene)) {
    const auto missed = static_cast<std::size_t>(std::ranges::count(informed[component.axis], 0.0F));
    if (component.known.any && missed > 0) { // else undetermined
      warn(warnings, "out-of-reach", missed, "all"_a = scene.extent().sites(), "component"_a = component.name,
           "farthest"_a = std::ranges::max(distance_to_nearest(scene.extent(), component.confidence)),
           "iterations"_a = schedule.iterations, "levels"_a = levels.order().size(),
           "start_level"_a = schedule.start_level ? "a larger --start-level or none, " : "");
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

/// A coarse level has an observed component where one of its sites around it is observed, and
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
  for (const Component& component : components(scene)) {
    std::vector<float>& there = present[component.axis];
    std::ranges::transform(there, known[component.axis], there.begin(), std::multiplies());
    const std::vector<float> to_present = distance_to_nearest(scene.extent(), there);
    std::size_t lost = 0;
    for (std::size_t i = 0; i < to_present.size(); ++i) {
      lost += component.confidence[i] > 0.0F && static_cast<double>(to_present[i]) > near ? 1 : 0;
    }
    if (lost > 0) {
      const bool centred = scene.schedule.alignment == Alignment::center;
      warn(warnings, centred ? "lost-condition/centred" : "lost-condition", lost,
           "component"_a = component.name, "level"_a = extent.text());
    }
  }
}

/// A value of size D is stored to ulp(D) / 2. A site's own minimum is a mean of its neighbours (the weights
/// (1 + r) r + (1 + k) sum to A, so the contrast r drops out): it and the site are each off by ulp(D) / 2,
/// together ulp(D). From half the smallest candidate on that decides where a site rests, and the field is no
/// longer the same wherever it is shifted to.
void check_offset(const Scene& scene, Warnings& warnings) {
  constexpr double usual_resolution = 0.01; // pixels, where the rule has no candidates of its own
  const double resolution = quantum(scene) > 0.0 ? quantum(scene) : usual_resolution;
  Range range;
  for (const Component& component : components(scene)) {
    for (std::size_t i = 0; i < component.target.size(); ++i) {
      range.include(component.start_of(i));
    }
    if (component.known.any) {
      range.include(component.known.least);
      range.include(component.known.most);
    }
  }
  const auto largest = static_cast<float>(std::max(std::abs(range.least), std::abs(range.most)));
  const float spacing = std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest;
  if (static_cast<double>(spacing) >= 0.5 * resolution) {
    warn(warnings, "offset", std::nullopt, "largest"_a = largest, "spacing"_a = spacing,
         "wanted"_a = resolution, "mean"_a = 0.5 * (range.least + range.most));
  }
}

/// On a straight boundary each triple of a stiff site has a softer neighbour u on one side, r = m_t / m_u,
/// and its own material on the other: u pulls with the weight w = (1 + r) + 2 out of A = (1 + r)^2 + 4. The
/// site moves by e only where its minimum is more than e / 2 away, so where the soft side is e A / 2w ahead;
/// no two sites can be farther apart than the targets. Below w / A = 2^-24 float32 does not feel the softer
/// side at all; where 6 (1 + r)^2 e^2 (in a volume 27) leaves its range every energy is infinite.
void check_contrast(const Scene& scene, Warnings& warnings) {
  const NeighbourContrast contrast = largest_neighbour_contrast(scene.full.modulus);
  const double r = contrast.ratio;
  const double lag = ((1.0 + r) * (1.0 + r) + 4.0) / (3.0 + r);
  const std::string where = scene.extent().place(contrast.site);
  const StepSizes steps = step_sizes(scene.full.steps);
  const double largest_energy = static_cast<double>(scene.extent().axes()) * neighbours_aside(scene) *
                                std::pow((1.0 + r) * std::max(1.0, steps.largest), 2.0);
  const bool overflows = largest_energy > double{std::numeric_limits<float>::max()};
  if (overflows || lag > 0x1p24) {
    warn(warnings, overflows ? "contrast/energy" : "contrast/pull", std::nullopt, "ratio"_a = r,
         "place"_a = where);
    return;
  }
  double range = 0.0;
  for (const Component& component : components(scene)) {
    range = std::max(range, component.known.width());
  }
  const double ahead = 0.5 * steps.smallest * lag;
  if (scene.schedule.rule == Rule::steps && range > 0.0 && ahead > range) {
    warn(warnings, "stiff-boundary", std::nullopt, "ratio"_a = r, "place"_a = where, "ahead"_a = ahead,
         "apart"_a = range);
  }
}

void check_rest_candidate(const Scene& scene, Warnings& warnings) {
  if (scene.schedule.rule == Rule::steps && std::ranges::count(scene.full.steps.values(), 0.0F) == 0) {
    warn(warnings, "never-rests", std::nullopt, "candidates"_a = scene.full.steps.text());
  }
}

void check_elastic_cycles(const Scene& scene, Warnings& warnings) {
  const double most = find_method(scene.schedule.method, scene.energy).most_contrast;
  if (has_laws(scene.full) || !(contrast_of(scene.full.modulus) > most)) {
    return; // no two neighbours differ more
  }
  if (const NeighbourContrast found = largest_neighbour_contrast(scene.full.modulus); found.ratio > most) {
    warn(warnings, "stalling-cycles", std::nullopt, "ratio"_a = found.ratio,
         "place"_a = scene.extent().place(found.site), "most"_a = most);
  }
}

/// How far the default effort is from finite elements, and these from finer ones, ratio by ratio: `hdmbench
/// atlas volume-elastic-poisson volume-elastic-locking`. A sheet becomes thinner instead.
void check_poisson_ratio(const Scene& scene, Warnings& warnings) {
  constexpr double most = 0.45;
  const double ratio = scene.extent().axes() == 3 ? scene.elastic.poisson : 0.0;
  if (ratio > most) {
    warn(warnings, "nearly-incompressible", std::nullopt, "ratio"_a = ratio, "most"_a = most);
  }
  if (ratio >= most && scene.elastic.integration == Integration::full) {
    warn(warnings, "locking", std::nullopt, "ratio"_a = ratio);
  }
}

void check_walls(const Scene& scene, Warnings& warnings) {
  if (const double angle = least_angle_to_walls(scene.full);
      angle < least_firm_angle && !scene.has_own_normals) {
    warn(warnings, "walls-hold-little", std::nullopt, "angle"_a = angle, "error"_a = error_of_normals,
         "percent"_a = 100.0 * largest_share_of_normals(angle));
  }
  constexpr double most = 6.0; // degrees: WallNormals.OfRoughOutlinesAreWarnedOf prints some
  if (const auto& turn = scene.turn_of_normals; turn && turn->degrees > most) {
    warn(warnings, "rough-walls", std::nullopt, "radius"_a = turn->radius * scene.spacing,
         "farther"_a = turn->farther * scene.spacing, "angle"_a = turn->degrees);
  }
}

void check_resampling(const Scene& scene, Warnings& warnings) {
  if (scene.oblong) {
    const auto [least, most] =
        std::ranges::minmax(std::span(scene.oblong->sides).first(scene.extent().axes()));
    warn(warnings, has_equal_sides(*scene.oblong) ? "nearly-square" : "resampled", std::nullopt,
         "sides"_a = sides_text(*scene.oblong), "extent"_a = scene.extent().text(), "side"_a = scene.spacing,
         "percent"_a = 100.0 * (most / least - 1.0),
         "shape"_a = scene.extent().axes() == 3 ? "cubes" : "squares");
  }
}

} // namespace

Warnings diagnose(const Scene& scene) {
  Warnings warnings;
  check_resampling(scene, warnings);
  check_what_moves(scene, warnings);
  for (const std::string& what : scene.idle) {
    warn(warnings, "idle", std::nullopt, "what"_a = what);
  }
  if (scene.energy->is_of_cells()) { // the rest is about sweeps and levels of energies of sites
    check_conflicts(scene, warnings);
    check_elastic_cycles(scene, warnings);
    check_poisson_ratio(scene, warnings);
    check_walls(scene, warnings);
    return warnings;
  }
  for (const Component& component : components(scene)) {
    check_undetermined(scene, component, warnings);
    check_weak_penalty(scene, component, warnings);
  }
  for (const auto check : {check_conflicts, check_reach, check_lost_conditions, check_offset, check_contrast,
                           check_rest_candidate}) {
    check(scene, warnings);
  }
  return warnings;
}

} // namespace hdmbench
