#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace hdmbench {

/// What every cell has in common.
struct CellConstants {
  float mu = 0.0F; ///< Lame's constants for a modulus of 1, in the unit of sessions (force_unit)
  float lame = 0.0F;
  float half_modulus = 0.0F; ///< a half of a modulus of 1, in that unit
  std::array<float, 3> one_over_sides{};
  float least_modulus = 0.0F; ///< of a corner; below it all of the cell is void
};

/// The four rows of sites that a row of cells lies between: y in the lowest bit, then z, which an image has
/// not.
struct CellRows {
  std::array<std::array<const float*, 4>, 3> displacement{};
  std::array<const float*, 4> modulus{};
  std::array<const float*, 4> parameter{};
  std::array<std::array<const float*, 4>, 3> fibre{}; ///< not read where there are none
  std::array<const float*, 4> compression{};
};

/// What cells do, one array after the other, each as long as a row of them: 24 forces, the volume.
struct MadeCells {
  float* forces = nullptr;
  float* volumes = nullptr;
  std::size_t cells = 0;
};

/// A law of large strains, its text (specification/laws) as law_cells.cpp compiles it. Scenes name laws by
/// harness/scene/laws.hpp.
struct Law {
  /// What cells begin ... end - 1 of a row do; in the second their tissues have fibres.
  void (*make_cells)(const CellConstants&, const CellRows&, const MadeCells&, std::size_t begin,
                     std::size_t end);
  void (*make_cells_with_fibres)(const CellConstants&, const CellRows&, const MadeCells&, std::size_t begin,
                                 std::size_t end);
  /// Sets how many times as stiff cells begin ... end - 1 of a row are under the strain in their middle as
  /// without, 0.1 ... 10, and void 0; z is 1 of a volume, 0 of an image.
  void (*set_ratios)(const CellConstants&, const CellRows&, float z, std::size_t begin, std::size_t end,
                     float* to);
  /// Its file, for compilers at run time (kernels/shaders/laws.h).
  std::string_view text;
  /// SPIR-V of laws.comp with it; empty without Vulkan.
  std::span<const std::uint32_t> vulkan_of_images;
  std::span<const std::uint32_t> vulkan_of_volumes;
};

/// The shipped text: neo-Hookean, and stiffening by its parameter.
namespace laws::neo_hookean {
extern const Law law;
}

} // namespace hdmbench
