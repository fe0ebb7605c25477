#include "backends/session/device_loops.hpp"

#include "backends/shared/ceiling_shaders.hpp"

#include <algorithm>
#include <bit>

namespace hdmbench {

namespace {

constexpr int lanes = 64; ///< of a group, in all texts

constexpr std::size_t texels_of_item = 8; ///< of kernels/shaders/ceilings.cl, whose arrays are planes

Extent groups_for(std::size_t texels, const DeviceLimits& limits) {
  const std::size_t groups = texels / lanes / (limits.has_planes ? texels_of_item : 1);
  const std::size_t across = std::min<std::size_t>(groups, 1024);
  return {static_cast<int>(across), static_cast<int>(groups / across)};
}

std::vector<float> texels_of(ComputeDevice& device, const Array& array, std::size_t texels) {
  std::vector<float> values(4 * texels);
  device.read(array, 0, std::as_writable_bytes(std::span(values)));
  return values;
}

} // namespace

void DeviceLoops::run(Kernel kernel, const Array& source, const Array& target, Extent groups, int times) {
  Dispatch dispatch{.program = &programs_({.kernel = kernel, .constants = {{"LANES", lanes}}}),
                    .groups = groups};
  dispatch.arrays[binding::source] = &source;
  dispatch.arrays[binding::target] = &target;
  device_.run(Commands(static_cast<std::size_t>(times), dispatch));
  device_.finish();
}

std::vector<float> DeviceLoops::evaluate(std::span<const ArithmeticCase> cases) {
  const auto source = device_.allocate(2 * cases.size(), Kind::fours);
  const auto target = device_.allocate(cases.size(), Kind::fours);
  device_.write(*source, 0, std::as_bytes(cases));
  run(Kernel::probe, *source, *target, {static_cast<int>(cases.size()) / lanes, 1}, 1);
  const std::vector<float> texels = texels_of(device_, *target, cases.size());
  std::vector<float> results;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    results.push_back(texels[4 * i]);
  }
  return results;
}

Ceilings DeviceLoops::ceilings() {
  const DeviceLimits& limits = device_.limits();
  const std::size_t texels =
      std::min(bytes_to_copy() / ceiling_shaders::texel_bytes,
               std::bit_floor(std::min(limits.elements, limits.array_bytes / ceiling_shaders::texel_bytes)));
  if (texels < ceiling_shaders::texels) {
    throw TooLarge("an array of this device ends before 4 MiB");
  }
  const std::vector<float> given = ceiling_shaders::source(texels);
  const auto source = upload(device_, Kind::fours, given);
  const auto target = device_.allocate(texels, Kind::fours);
  Ceilings ceilings;
  ceilings.copy_bytes_per_second = sample_rates(2.0 * static_cast<double>(target->bytes()), [&](int times) {
    run(Kernel::copy, *source, *target, groups_for(texels, limits), times);
  });
  ceiling_shaders::require_copied(given, texels_of(device_, *target, texels));
  ceilings.operations_per_second = sample_rates(ceiling_shaders::operations(), [&](int times) {
    run(Kernel::multiply_add, *source, *target, groups_for(ceiling_shaders::texels, limits), times);
  });
  ceiling_shaders::require_computed(given, texels_of(device_, *target, ceiling_shaders::texels));
  return ceilings;
}

} // namespace hdmbench
