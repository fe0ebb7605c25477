#pragma once

#include "backends/backend.hpp"
#include "harness/solve.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// One backend's time for a whole solution.
struct BenchResult {
  std::string backend;
  Device device;
  std::int64_t iterations = 0;    ///< that a solution took, over all levels
  double site_updates = 0.0;      ///< iterations times sites, over all levels
  double setup_seconds = 0.0;     ///< opening, compiling, and a first pass of one iteration per level
  std::vector<Timings> samples;   ///< raw, in the order measured
  std::optional<double> speed_up; ///< over the reference's median; only if valid
  bool valid = false;             ///< the field is the reference's, to the bit
  std::string reason;             ///< why not valid
};

/// median() of the totals, or of one part, over the samples.
[[nodiscard]] double median_seconds(std::span<const Timings> samples, double (*part)(const Timings&));

struct BenchOptions {
  SessionOptions session;
  int repeats = 3; ///< samples per backend, >= 1
};

/// Times the scene's schedule on every backend; the first one is the reference for speed and bits. A backend
/// that is not there is returned without samples and with the reason.
[[nodiscard]] std::vector<BenchResult> bench(const Scene& scene, std::span<const Backend* const> backends,
                                             const BenchOptions& options, Progress& progress);

} // namespace hdmbench
