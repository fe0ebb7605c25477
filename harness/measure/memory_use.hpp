#pragma once

#include <cstddef>
#include <optional>

namespace hdmbench {

/// Bytes of memory that this process occupies, without what it has freed; 0 where the operating system does
/// not tell.
[[nodiscard]] std::size_t resident_bytes();

/// The most memory that this process occupied at once while the object lives.
class PeakMemory {
public:
  /// Starts at what is occupied now.
  PeakMemory();

  /// Bytes; none where the operating system cannot forget an older peak.
  [[nodiscard]] std::optional<std::size_t> bytes() const;

private:
  bool reset_;
};

} // namespace hdmbench
