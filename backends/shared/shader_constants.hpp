#pragma once

#include "kernels/data/level.hpp"

#include <compare>

namespace hdmbench {

/// What a sweep's shader is compiled for: constants there, so that the driver drops all other branches.
struct ShaderConstants {
  int rule = 0;
  int colours = 1;
  int step_count = 1; ///< 1 where the rule has no candidates
  const Energy* energy = &thesis_energy;

  auto operator<=>(const ShaderConstants&) const = default;
};

[[nodiscard]] inline ShaderConstants shader_constants(const Level& level) {
  const bool has_candidates = level.rule == Rule::steps || level.rule == Rule::annealing;
  return {.rule = static_cast<int>(level.rule),
          .colours = sweeps_per_iteration(level),
          .step_count = has_candidates ? level.steps.count() : 1,
          .energy = level.energy};
}

} // namespace hdmbench
