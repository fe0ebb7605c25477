#include "harness/judge/diagnosis/checks.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"

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

} // namespace diagnosis

} // namespace hdmbench
