#pragma once

#include "backends/shared/interface.hpp"

#include <optional>
#include <utility>

namespace hdmbench {

/// A session or a device, which may know how long the device itself was at work.
class Timed : public Interface {
public:
  /// Returns seconds, by the device's own clock, from where it began with commands that it was handed
  /// together to where it had done them, added up over all that was computed since the last call. Transfers
  /// do not count. Waits. Absent at the first call, from which on is counted, and where the device has no
  /// such clock or was given nothing to do. Throws DeviceError.
  [[nodiscard]] virtual std::optional<double> device_seconds() { return std::nullopt; }
};

/// The sum that device_seconds() returns.
class BusySeconds {
public:
  [[nodiscard]] bool are_counted() const { return are_counted_; }
  void add(double seconds) { sum_ += seconds; }
  /// Returns what was added since the last call; absent where that is nothing.
  [[nodiscard]] std::optional<double> take() {
    are_counted_ = true;
    const double sum = std::exchange(sum_, 0.0);
    return sum > 0.0 ? std::optional(sum) : std::nullopt;
  }

private:
  bool are_counted_ = false;
  double sum_ = 0.0;
};

} // namespace hdmbench
