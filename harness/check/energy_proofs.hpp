#pragma once

#include "harness/check/certificate.hpp"
#include "kernels/data/level.hpp"

#include <optional>

namespace hdmbench {

/// What is known of an energy's arithmetic beyond its bits: energy_proofs.cpp compiles the energy with other
/// scalars. Each is described where the function of the same name is declared.
struct EnergyProofs {
  SiteAnswer (*specified_answer)(const Level& level, const VectorField& before, int number, int x, int y);
  /// As specified_answer, of a device that fuses every product into the sum that follows.
  SiteAnswer (*fused_answer)(const Level& level, const VectorField& before, int number, int x, int y);
  Certificate (*certify)(const Level& level, const VectorField& before, int number, int x, int y,
                         SiteAnswer found);
  EnergyBound (*energy_change_bound)(const Level& level, const VectorField& displacement, int x, int y,
                                     float step_x, float step_y);
  std::optional<InexactOperation> (*first_inexact)(const Level& level, const VectorField& before, int number);
};

[[nodiscard]] const EnergyProofs& proofs_of(const Energy& energy);

} // namespace hdmbench
