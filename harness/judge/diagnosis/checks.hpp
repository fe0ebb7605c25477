#pragma once

#include "harness/judge/diagnosis/warning.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/solve.hpp"

#include <array>
#include <span>
#include <string>

/// The parts of diagnose(): each adds the kinds of diagnosis.hpp that it names.
namespace hdmbench::diagnosis {

/// One component of a scene at full resolution.
struct Component {
  char name;     ///< 'x' or 'y'
  int thickness; ///< sites across the image in its direction
  std::span<const float> target;
  std::span<const float> confidence;
  std::span<const float> start; ///< empty: 0 everywhere

  [[nodiscard]] double start_of(std::size_t site) const {
    return start.empty() ? 0.0 : static_cast<double>(start[site]);
  }
};
[[nodiscard]] std::array<Component, 2> components(const Scene& scene);

/// Smallest and largest value; `any` false where there was none.
struct Range {
  double least = 0.0;
  double most = 0.0;
  bool any = false;

  void include(double value);
  [[nodiscard]] double width() const { return most - least; }
};
/// The targets that are known, pixels.
[[nodiscard]] Range target_range(const Component& component);

/// The smallest candidate that moves and the largest, pixels, without sign; 0 where 0 is the only one.
struct StepSizes {
  double smallest = 0.0;
  double largest = 0.0;
};
[[nodiscard]] StepSizes step_sizes(const StepSet& steps);

/// Half of it is how far a component may stay from its own minimum: the smallest candidate where the rule
/// has candidates, else 0.
[[nodiscard]] double quantum(const Scene& scene);

/// "x = 3, y = 4".
[[nodiscard]] std::string place(Extent extent, std::size_t site);

// Before the run.
void check_conditions(const Scene& scene, Warnings& warnings);     ///< undetermined, conflict, weak-penalty
void check_conflicts(const Scene& scene, Warnings& warnings);      ///< conflict, part of check_conditions
void check_pyramid(const Scene& scene, Warnings& warnings);        ///< out-of-reach, too-few-steps, lost-...
void check_numbers(const Scene& scene, Warnings& warnings);        ///< the rest
void check_elastic_cycles(const Scene& scene, Warnings& warnings); ///< stalling-cycles

// After the run; the field is finite.
void check_folding(const VectorField& displacement, Warnings& warnings); ///< fold-over, near-fold
/// gives-way, not-met, oscillation, still-moving, stalled
void check_rest(const Scene& scene, const Solution& solution, Warnings& warnings);
void check_elastic_rest(const Scene& scene, const Solution& solution,
                        Warnings& warnings); ///< not-converged, no-estimate

} // namespace hdmbench::diagnosis
