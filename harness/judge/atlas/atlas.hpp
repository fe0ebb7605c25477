#pragma once

#include "backends/backend.hpp"
#include "harness/judge/atlas/entry.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench::atlas {

/// One method at one value of the knob.
struct Point {
  double knob = 0.0;
  std::optional<double> error{};       ///< in Entry::measure; none: not finite, or there is no field
  bool failed = false;                 ///< error above Entry::limit, or not finite
  std::vector<std::string> warnings{}; ///< kinds, before and after the run, each once
};

/// Where a method begins to fail on the way from the healthy to the harmful end.
struct Threshold {
  std::optional<double> good; ///< last value of the knob before the first failure; none: the first one fails
  std::optional<double> failed; ///< first value that fails; none: none does
};

struct SeriesResult {
  std::string name;
  std::string absence; ///< why there are no points, or none from some knob on; empty: all are there
  std::vector<Point> points;

  [[nodiscard]] Threshold threshold() const;
};

/// One value per site for a picture, signed.
struct Picture {
  Extent extent;
  std::vector<float> values;
  double largest = 0.0; ///< of the colour scale, > 0
  std::string caption;
};

struct EntryResult {
  const Entry* entry = nullptr;
  Extent extent; ///< of the scene at the first value of the knob
  std::vector<SeriesResult> series;
  std::optional<Picture> picture;
  double seconds = 0.0;
};

/// Runs one entry on one backend. A method that cannot run (a backend or a build without it) is a series with
/// an `absence`. Throws what the truths throw, DeviceError.
[[nodiscard]] EntryResult run_entry(const Entry& entry, const Backend& backend, bool quick,
                                    Progress& progress);

/// One row of `atlas`'s results. Writes the picture into `json_folder` where images are built, as
/// "atlas-NAME.png". Throws InputError.
[[nodiscard]] nlohmann::json atlas_row(const EntryResult& result, const std::filesystem::path& json_folder);

} // namespace hdmbench::atlas
