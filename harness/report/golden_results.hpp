#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

/// What `hdmbench golden` wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

/// One case on one backend.
struct GoldenRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string method;
  std::string backend;
  std::string device;
  std::string inputs_reason; ///< why what the host computes for all backends is not golden; empty: it is
  std::string hash;          ///< of the finest level; empty: there is none
  std::string verdict;       ///< "agree", "disagree", "mistrusted" (nothing to compare with) or "skipped"
  std::string reason;        ///< where it is not "agree"
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself: a row that agrees without levels, with a level that differs, or on other inputs.
[[nodiscard]] GoldenRow read_golden(const JsonReader& json);

} // namespace hdmbench::report
