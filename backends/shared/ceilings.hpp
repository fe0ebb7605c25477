#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace hdmbench {

/// What a device reaches at most: loops that do nothing but move memory, or nothing but arithmetic, through
/// the same compiler and driver as the sweep. Samples in the order taken. What the loops computed was
/// checked.
struct Ceilings {
  /// Bytes read plus bytes written by a copy of an array that no cache holds (as STREAM counts).
  std::vector<double> copy_bytes_per_second;
  /// Float multiplications and additions per second, in turn, kept apart as the specification wants them,
  /// in enough independent chains.
  std::vector<double> operations_per_second;
};

/// Bytes of the array to copy, a power of two: several times the last-level cache of this machine.
[[nodiscard]] std::size_t bytes_to_copy();
/// Bytes of the last-level cache of this machine's processor, 0 where it does not tell.
[[nodiscard]] std::size_t last_level_cache_bytes();

inline constexpr int ceiling_samples = 5;

/// run(n) does `work` (bytes or operations) n times and waits for it. Returns work per second of
/// ceiling_samples calls with an n that makes a call long enough for the clock.
[[nodiscard]] std::vector<double> sample_rates(double work, const std::function<void(int)>& run);

/// Throws DeviceError: the loop that measures computed something else than it should.
[[noreturn]] void throw_wrong_result(const char* loop);

} // namespace hdmbench
