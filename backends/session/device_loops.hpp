#pragma once

#include "backends/device/device.hpp"
#include "backends/shared/arithmetic.hpp"
#include "backends/shared/ceilings.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// Programs that measure and probe a device. Throws DeviceError.
class DeviceLoops {
public:
  explicit DeviceLoops(ComputeDevice& device) : device_(device), programs_(device) {}

  /// kernels/specification/probe.inc, as ArithmeticProgram::evaluate().
  [[nodiscard]] std::vector<float> evaluate(std::span<const ArithmeticCase> cases);
  /// Takes about a second. Throws TooLarge where the device's arrays are too small to measure.
  [[nodiscard]] Ceilings ceilings();

private:
  /// `kernel` on two arrays, so many times, to its end.
  void run(Kernel kernel, const Array& source, const Array& target, Extent groups, int times);

  ComputeDevice& device_;
  Programs programs_;
};

} // namespace hdmbench
