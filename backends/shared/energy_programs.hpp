#pragma once

#include "kernels/data/elastic/law.hpp"
#include "kernels/data/energy.hpp"
#include "kernels/data/level.hpp"

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace hdmbench {

namespace openmp {
struct RowPart;
}

/// What the backends run of an energy: built by energy_programs.cpp, scalar_sweep.cpp, row.cpp and the
/// shaders with the energy's text in them.
struct EnergyPrograms {
  /// The text energy.inc, for compilers at run time.
  std::string_view text;
  /// SPIR-V of kernels/shaders; empty without Vulkan.
  std::span<const std::uint32_t> vulkan_sweep;
  std::span<const std::uint32_t> vulkan_coarse_levels;
  /// Sweep `number` of the level on one thread; `from` and `to` may be the same field: then a site sees its
  /// predecessors' new values. Returns how many sites changed.
  std::int64_t (*scalar_sweep)(const Level& level, int number, const VectorField& from, VectorField& to);
  /// A row of a sweep (backends/cpu/row.hpp): baseline, AVX2, AVX-512; null where not built.
  std::array<std::int64_t (*)(const openmp::RowPart& part), 3> rows;
  std::span<const std::uint32_t> vulkan_sweep_of_volumes;
};

[[nodiscard]] const EnergyPrograms& programs_of(const Energy& energy);

/// Returns a shader of kernels/ in which the texts of the energy and of the law, if there is one, stand where
/// it includes them.
[[nodiscard]] std::string with_own_texts(std::string_view shader, const Energy& energy, const Law* law);

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
