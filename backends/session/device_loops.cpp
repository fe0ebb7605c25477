#include "backends/session/device_loops.hpp"

#include "kernels/shaders/level_passes.h"

#include <algorithm>
#include <bit>

namespace hdmbench {

namespace {

constexpr std::size_t texel_bytes = 4 * sizeof(float);

// Of the loop of multiply-adds in every language.
constexpr int chains = 12; // per texel
constexpr int rounds = 8 * 64 + 1;
constexpr std::size_t multiplied_texels = std::size_t{1} << 18;

/// Texels of a value that differs from its neighbours', twice, and the factor -1 and the term 3 of the
/// multiply-adds, which no compiler can know.
std::vector<float> measured_texels(std::size_t count) {
  std::vector<float> values;
  values.reserve(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = static_cast<float>(i % 1000);
    values.insert(values.end(), {value, value, -1.0F, 3.0F});
  }
  return values;
}

bool are_computed(std::span<const float> given, std::span<const float> found) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Chains begin with value + component, + 4 and + 8 of it; after an odd number of rounds each is 3 - that.
    const float begin = given[i / 4 * 4] + static_cast<float>(i % 4);
    if (found[i] != (3.0F - begin) + (3.0F - begin - 4.0F) + (3.0F - begin - 8.0F)) {
      return false;
    }
  }
  return true;
}

constexpr int lanes = 64;                 ///< of a group, in all texts
constexpr std::size_t texels_of_item = 8; ///< of the loops that measure where arrays are planes (loops.cl)

} // namespace

std::vector<float> Loops::evaluate(std::span<const ArithmeticCase> cases) {
  const std::span<const float> numbers(cases.front().data(), cases.size() * cases.front().size());
  load(numbers, cases.size());
  run(LOOP_PROBE, cases.size(), 1);
  const std::vector<float> texels = result(cases.size());
  std::vector<float> results;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    results.push_back(texels[4 * i]);
  }
  return results;
}

Ceilings Loops::ceilings() {
  const std::size_t texels = std::min(bytes_to_copy() / texel_bytes, std::bit_floor(most_texels()));
  if (texels < multiplied_texels) {
    throw TooLarge("an array of this device ends before 4 MiB");
  }
  const std::vector<float> given = measured_texels(texels);
  load(given, texels);
  Ceilings ceilings;
  ceilings.copy_bytes_per_second = sample_rates(2.0 * static_cast<double>(texels * texel_bytes),
                                                [&](int times) { run(LOOP_COPY, texels, times); });
  if (result(texels) != given) {
    throw_wrong_result("copy by shader");
  }
  ceilings.operations_per_second =
      sample_rates(2.0 * chains * rounds * static_cast<double>(multiplied_texels),
                   [&](int times) { run(LOOP_MULTIPLY_ADD, multiplied_texels, times); });
  if (!are_computed(given, result(multiplied_texels))) {
    throw_wrong_result("multiply-add shader");
  }
  return ceilings;
}

std::size_t DeviceLoops::most_texels() const {
  return std::min(device_.limits().elements, device_.limits().array_bytes / texel_bytes);
}

void DeviceLoops::load(std::span<const float> source, std::size_t texels) {
  source_ = device_.allocate(source.size() / 4, Kind::fours);
  device_.write(*source_, 0, std::as_bytes(source));
  target_ = device_.allocate(texels, Kind::fours);
}

void DeviceLoops::run(int loop, std::size_t texels, int times) {
  const bool has_items = device_.limits().has_planes && loop != LOOP_PROBE;
  const std::size_t groups = texels / lanes / (has_items ? texels_of_item : 1);
  const std::size_t across = loop == LOOP_PROBE ? groups : std::min<std::size_t>(groups, 1024);
  Dispatch dispatch{
      .program = &programs_({.kernel = Kernel::loops, .constants = {{"LOOP", loop}, {"LANES", lanes}}}),
      .groups = {static_cast<int>(across), static_cast<int>(groups / across)}};
  dispatch.arrays[binding::source] = source_.get();
  dispatch.arrays[binding::target] = target_.get();
  device_.run(Commands(static_cast<std::size_t>(times), dispatch));
  device_.finish();
}

std::vector<float> DeviceLoops::result(std::size_t texels) {
  std::vector<float> values(4 * texels);
  device_.read(*target_, 0, std::as_writable_bytes(std::span(values)));
  return values;
}

} // namespace hdmbench
