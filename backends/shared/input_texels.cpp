#include "backends/shared/input_texels.hpp"

namespace hdmbench {

InputTexels::InputTexels(const Level& level) : first{0} {
  append(level.inputs);
}

InputTexels::InputTexels(const Pyramid& pyramid) {
  const Level& full = *pyramid.full;
  append(full.inputs);
  for (const PyramidLevel& level : pyramid.levels) {
    const bool is_full = level.extent == full.extent;
    first.push_back(is_full ? 0 : static_cast<std::int32_t>(count()));
    if (!is_full) {
      append(sample_inputs(full, level.extent, pyramid.alignment));
    }
  }
}

void InputTexels::append(const std::vector<ScalarField>& inputs) {
  for (std::size_t number = 0; number < planes.size() && !inputs.empty(); ++number) {
    std::vector<float>& plane = planes[number];
    if (number < inputs.size()) {
      plane.insert(plane.end(), inputs[number].values.begin(), inputs[number].values.end());
    } else {
      plane.resize(planes.front().size());
    }
  }
}

} // namespace hdmbench
