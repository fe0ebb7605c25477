#pragma once

#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// The numbers of a site that are an energy's own (Level::inputs) as devices have them: four planes, those
/// that the energy does not have 0, of the full level and then of all levels that sample it. Empty where the
/// energy has none.
struct InputTexels {
  InputTexels() = default;
  explicit InputTexels(const Level& level);
  explicit InputTexels(const Pyramid& pyramid);

  [[nodiscard]] std::size_t count() const { return planes.front().size(); }

  std::array<std::vector<float>, 4> planes;
  std::vector<std::int32_t> first; ///< per level of the pyramid, where its texels begin

private:
  void append(const std::vector<ScalarField>& inputs);
};

} // namespace hdmbench
