#pragma once

#include "harness/judge/atlas/atlas.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {
class Fields;
}

namespace hdmbench::atlas {

/// One row of `atlas`'s results: one way to fail. See Entry.
struct AtlasRow {
  struct PictureFile {
    std::string file; ///< relative to the result file
    std::string caption;
    double largest = 0.0; ///< value of full red, minus that of full blue
  };
  std::string entry;
  std::string title;
  std::string energy = std::string(energy_names[0]); ///< of energy_names
  std::string mechanism;
  std::string knob;
  std::string measure;
  double limit = 0.0;
  std::string seen_by;
  std::string survivor;
  std::vector<std::string> warnings;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double seconds = 0.0;
  std::vector<SeriesResult> series;
  std::optional<PictureFile> picture{};
};

void list_fields(Fields& fields, AtlasRow& row);

/// Writes the picture into `json_folder` where images are built, as "atlas-NAME.png". Throws InputError.
[[nodiscard]] AtlasRow atlas_row(const EntryResult& result, const std::filesystem::path& json_folder);

} // namespace hdmbench::atlas
