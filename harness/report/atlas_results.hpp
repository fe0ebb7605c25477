#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// What `hdmbench atlas` wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

struct AtlasPoint {
  double knob = 0.0;
  std::optional<double> error; ///< none: not finite
  bool failed = false;
  std::vector<std::string> warnings; ///< kinds
};

struct AtlasSeries {
  std::string name;
  std::string absence; ///< why there are no points; empty: they are there
  std::vector<AtlasPoint> points;
  std::optional<double> last_good;    ///< knob before the first failure
  std::optional<double> first_failed; ///< none: no failure
};

/// One way to fail.
struct AtlasRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string entry;
  std::string title;
  std::string mechanism;
  std::string knob;
  std::string measure;
  double limit = 0.0; ///< an error above it is a failure
  std::string seen_by;
  std::string survivor;
  std::vector<std::string> warnings; ///< kinds that tell of this failure
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<AtlasSeries> series;
  std::filesystem::path picture; ///< empty: none
  std::string picture_caption;
  double picture_largest = 0.0; ///< value of full red, minus that of full blue
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself: a point that failed below the limit or passed above it, series of different lengths.
[[nodiscard]] AtlasRow read_atlas(const JsonReader& json);

} // namespace hdmbench::report
