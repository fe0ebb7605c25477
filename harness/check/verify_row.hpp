#pragma once

#include "harness/check/verify_windows.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// One row of `verify`'s results: what was compared, on what.
struct VerifyRow : Comparison {
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string method{};                    ///< method_name(); empty in files of before
  std::vector<WindowedLevel> coverage{};   ///< of Mode::windows: what was looked at
  std::vector<WindowedPyramid> pyramids{}; ///< of Mode::windows
  std::optional<std::int64_t> ranks{};     ///< that computed it together; none: one process
};

void list_fields(Fields& fields, VerifyRow& row);
void require_consistent(const VerifyRow& row);

[[nodiscard]] VerifyRow verify_row(const Scene& scene, const Comparison& comparison);
/// Where nothing is left of the scene but its name, extent and method_name().
[[nodiscard]] VerifyRow verify_row(const std::string& scene, Extent extent, const std::string& method,
                                   const WindowedComparison& comparison);

} // namespace hdmbench
