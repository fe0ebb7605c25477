#pragma once

#include "harness/check/verify.hpp"

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
  std::string method{};                ///< method_name(); empty in files of before
  std::optional<std::int64_t> ranks{}; ///< that computed it together; none: one process
  std::string reference{};             ///< what it was compared with; empty: scalar
  std::string repeat{};                ///< the command line that repeats the comparison
};

void list_fields(Fields& fields, VerifyRow& row);
void require_consistent(const VerifyRow& row);

[[nodiscard]] VerifyRow verify_row(const Scene& scene, const Comparison& comparison);

} // namespace hdmbench
