#include "harness/judge/diagnosis/checks.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

Warnings diagnose(const Scene& scene) {
  Warnings warnings;
  if (scene.energy == EnergyModel::elastic) { // the rest is about sweeps and levels of the thesis's energy
    diagnosis::check_conflicts(scene, warnings);
    diagnosis::check_elastic_cycles(scene, warnings);
    return warnings;
  }
  diagnosis::check_conditions(scene, warnings);
  diagnosis::check_pyramid(scene, warnings);
  diagnosis::check_numbers(scene, warnings);
  return warnings;
}

namespace diagnosis {

std::array<Component, 2> components(const Scene& scene) {
  const Level& full = scene.full;
  const auto start = [&](std::vector<float> VectorField::*part) {
    return scene.start ? std::span<const float>((*scene.start).*part) : std::span<const float>();
  };
  return {Component{'x', full.extent.width, full.target.x, full.confidence.x, start(&VectorField::x)},
          Component{'y', full.extent.height, full.target.y, full.confidence.y, start(&VectorField::y)}};
}

void Range::include(double value) {
  least = any ? std::min(least, value) : value;
  most = any ? std::max(most, value) : value;
  any = true;
}

Range target_range(const Component& component) {
  Range range;
  for (std::size_t i = 0; i < component.target.size(); ++i) {
    if (component.confidence[i] > 0.0F) {
      range.include(static_cast<double>(component.target[i]));
    }
  }
  return range;
}

StepSizes step_sizes(const StepSet& steps) {
  StepSizes sizes;
  for (const float value : steps.values()) {
    const double size = std::abs(static_cast<double>(value));
    if (size > 0.0) {
      sizes.smallest = sizes.smallest > 0.0 ? std::min(sizes.smallest, size) : size;
      sizes.largest = std::max(sizes.largest, size);
    }
  }
  return sizes;
}

double quantum(const Scene& scene) {
  const bool has_candidates = scene.schedule.rule == Rule::steps || scene.schedule.rule == Rule::annealing;
  return has_candidates ? step_sizes(scene.full.steps).smallest : 0.0;
}

std::string place(Extent extent, std::size_t site) {
  const auto width = static_cast<std::size_t>(extent.width);
  return fmt::format("x = {}, y = {}", site % width, site / width);
}

namespace {

void check_undetermined(const Scene& scene, const Component& component, Warnings& warnings) {
  const Undetermined found = find_undetermined(component.thickness, component.confidence);
  if (found.sites > 0) {
    warnings.push_back(
        {"undetermined",
         fmt::format(
             "no condition fixes the {} displacement of {} connected site{} (from {} on): it stays near "
             "what it starts with, and other starts give other results",
             component.name, found.sites, found.sites == 1 ? "" : "s", place(scene.extent(), found.first)),
         fmt::format("give a [[condition]] with d{}, or accept the start as the answer", component.name),
         found.sites});
  }
}

/// A condition holds while K c / 2 >= |g|, half the derivative of the prior by its component. In one
/// material every neighbour pulls with the weight (1 + r) r + (1 + k) = 4; a site on the edge of a uniform
/// slope of G px per site has three neighbours on one side only and so |g| = 3 * 4 * G = 12 G. G is at least
/// the range of the targets over the width of the image.
void check_weak_penalty(const Scene& scene, const Component& component, Warnings& warnings) {
  const Range range = target_range(component);
  if (component.thickness < 2 || range.width() <= 0.0) {
    return;
  }
  const double slope = range.width() / (component.thickness - 1);
  const double needed = 2.0 * 12.0 * slope;
  const auto certain = static_cast<std::size_t>(std::ranges::count(component.confidence, 1.0F));
  if (certain > 0 && static_cast<double>(scene.full.penalty) < needed) {
    warnings.push_back(
        {"weak-penalty",
         fmt::format("K = {:.4g} cannot hold conditions {:.4g} px apart in {}: a mean slope of {:.3g} px per "
                     "pixel pulls with {:.3g} where K offers {:.3g}, so certain conditions give way",
                     static_cast<double>(scene.full.penalty), range.width(), component.name, slope, needed,
                     static_cast<double>(scene.full.penalty)),
         fmt::format("--penalty {:.0f} or more, if these conditions are to be met", std::ceil(10.0 * needed)),
         certain});
  }
}

} // namespace

/// Along a component's own direction the site at t + 1 lands behind the one at t where the target falls by a
/// pixel or more, and a hole wider than a pixel opens where it rises by more than one; across it, a step of
/// more than a pixel shears neighbours apart.
void check_conflicts(const Scene& scene, Warnings& warnings) {
  const Extent extent = scene.extent();
  std::size_t folds = 0;
  std::size_t tears = 0;
  double steepest = 0.0;
  std::size_t worst = 0;
  for (const Component& component : components(scene)) {
    const auto compare = [&](std::size_t a, std::size_t b, bool along) {
      if (!(component.confidence[a] > 0.0F && component.confidence[b] > 0.0F)) {
        return;
      }
      const double rise = static_cast<double>(component.target[b]) - static_cast<double>(component.target[a]);
      const bool fold = along && rise <= -1.0;
      folds += fold ? 1 : 0;
      tears += !fold && std::abs(rise) > 1.0 ? 1 : 0;
      if ((fold || std::abs(rise) > 1.0) && std::abs(rise) > steepest) {
        steepest = std::abs(rise);
        worst = a;
      }
    };
    for_each_site(extent, [&](int x, int y) {
      const std::size_t at = extent.index(x, y);
      if (x + 1 < extent.width) {
        compare(at, extent.index(x + 1, y), component.name == 'x');
      }
      if (y + 1 < extent.height) {
        compare(at, extent.index(x, y + 1), component.name == 'y');
      }
    });
  }
  if (folds + tears > 0) {
    warnings.push_back(
        {"conflict",
         fmt::format("{} pairs of neighbouring conditions differ by more than the pixel between "
                     "them: the image folds between {} and tears between {}; the largest "
                     "difference is {:.3g} px, at {}",
                     folds + tears, folds, tears, steepest, place(extent, worst)),
         "smooth the targets or lower their confidence; no field can follow them", folds + tears});
  }
}

void check_conditions(const Scene& scene, Warnings& warnings) {
  for (const Component& component : components(scene)) {
    check_undetermined(scene, component, warnings);
  }
  check_conflicts(scene, warnings);
  for (const Component& component : components(scene)) {
    check_weak_penalty(scene, component, warnings);
  }
}

} // namespace diagnosis

} // namespace hdmbench
