#include "backends/shared/sweep_shapes.hpp"

#include "backends/shared/fastest_way.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace hdmbench {

namespace {

/// The first that the device takes: SwiftShader's buffers end at 65536 sites.
constexpr Extent measured_extent{512, 512};
constexpr Extent smaller_extent{256, 256};

/// Of a sample: long against a clock and against waking a device up, short where a device is slow.
constexpr double wanted_seconds = 0.01;
constexpr double most_sweeps = 64;

} // namespace

Variants sweep_variants(std::span<const SweepShape> shapes) {
  Variants result{.what = std::string(sweep_shapes_what), .measure = measure_shapes};
  for (const SweepShape& shape : shapes) {
    result.names.push_back(fmt::format("{} x {} sites by {}", shape.tile.width, shape.tile.height,
                                       shape.simd_width > 1
                                           ? fmt::format("SIMD of {}", shape.simd_width)
                                           : fmt::format("{} invocations", shape.invocations())));
  }
  result.worth_trying = result.names.size();
  return result;
}

Choice measure_shapes(const Variants& variants, Session& session,
                      const std::function<void(std::size_t)>& take) {
  constexpr float modulus_of_square = 10.0F;
  Level level = measured_level(measured_extent, modulus_of_square);
  try {
    session.load(level);
  } catch (const TooLarge&) {
    level = measured_level(smaller_extent, modulus_of_square);
  }
  const VectorField start(level.extent);
  int sweeps = 0; // of a sample, the same for all
  return fastest_way(variants, take, [&] {
    session.load(level);
    session.write(start);
    session.step(1); // a first time for what drivers put off
    if (sweeps == 0) {
      const double seconds = seconds_of([&] { session.step(1); });
      sweeps = static_cast<int>(std::clamp(wanted_seconds / seconds, 1.0, most_sweeps));
    }
    return seconds_of([&] { session.step(sweeps); }) / sweeps;
  });
}

} // namespace hdmbench
