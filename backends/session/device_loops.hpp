#pragma once

#include "backends/device/device.hpp"
#include "backends/shared/arithmetic.hpp"
#include "backends/shared/ceilings.hpp"
#include "backends/shared/interface.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// Loops that probe and measure a device (kernels/shaders/loops.comp and its twins). All throw DeviceError.
class Loops : public Interface {
public:
  /// kernels/specification/probe.inc, as ArithmeticProgram::evaluate().
  [[nodiscard]] std::vector<float> evaluate(std::span<const ArithmeticCase> cases);
  /// Takes about a second. Throws TooLarge where the device's arrays are too small to measure.
  [[nodiscard]] Ceilings ceilings();

private:
  /// Texels of four floats that an array can have.
  [[nodiscard]] virtual std::size_t most_texels() const = 0;
  /// Makes the texels that are read, and room for so many that are computed.
  virtual void load(std::span<const float> source, std::size_t texels) = 0;
  /// `loop` of kernels/shaders/level_passes.h for the first texels, so many times, to its end.
  virtual void run(int loop, std::size_t texels, int times) = 0;
  /// The first texels that were computed.
  [[nodiscard]] virtual std::vector<float> result(std::size_t texels) = 0;
};

/// On a device with kernels.
class DeviceLoops final : public Loops {
public:
  explicit DeviceLoops(ComputeDevice& device) : device_(device), programs_(device) {}

private:
  [[nodiscard]] std::size_t most_texels() const override;
  void load(std::span<const float> source, std::size_t texels) override;
  void run(int loop, std::size_t texels, int times) override;
  [[nodiscard]] std::vector<float> result(std::size_t texels) override;

  ComputeDevice& device_;
  Programs programs_;
  std::unique_ptr<Array> source_;
  std::unique_ptr<Array> target_;
};

} // namespace hdmbench
