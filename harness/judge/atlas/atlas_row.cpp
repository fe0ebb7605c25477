#include "harness/judge/atlas/atlas_row.hpp"

#include "harness/scene/images/images.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

namespace hdmbench::atlas {

static void list_fields(Fields& fields, Point& point) {
  fields("knob", point.knob);
  fields("error", point.error);
  fields("failed", point.failed);
  fields("warnings", point.warnings);
}

static void list_fields(Fields& fields, SeriesResult& series) {
  fields("name", series.name);
  fields("absence", series.absence);
  fields("points", series.points);
  Threshold threshold = series.threshold();
  fields("last_good", threshold.good);
  fields("first_failed", threshold.failed);
}

static void list_fields(Fields& fields, AtlasRow::PictureFile& picture) {
  fields("file", picture.file);
  fields("caption", picture.caption);
  fields("largest", picture.largest);
}

void list_fields(Fields& fields, AtlasRow& row) {
  fields("entry", row.entry);
  fields("title", row.title);
  fields("energy", row.energy);
  fields("mechanism", row.mechanism);
  fields("knob", row.knob);
  fields("measure", row.measure);
  fields("limit", row.limit);
  fields("seen_by", row.seen_by);
  fields("survivor", row.survivor);
  fields("warnings", row.warnings);
  fields("width", row.width);
  fields("height", row.height);
  fields("seconds", row.seconds);
  fields("series", row.series);
  fields.if_any("picture", row.picture);
}

AtlasRow atlas_row(const EntryResult& result, const std::filesystem::path& json_folder) {
  const Entry& entry = *result.entry;
  AtlasRow row{.entry = std::string(entry.name),
               .title = std::string(entry.title),
               .energy = std::string(entry.energy),
               .mechanism = std::string(entry.mechanism),
               .knob = std::string(entry.knob),
               .measure = std::string(entry.measure),
               .limit = entry.limit,
               .seen_by = std::string(entry.seen_by),
               .survivor = std::string(entry.survivor),
               .warnings = {entry.warnings.begin(), entry.warnings.end()},
               .width = result.extent.width,
               .height = result.extent.height,
               .seconds = result.seconds,
               .series = result.series};
  if (result.picture && have_images()) {
    const Picture& picture = *result.picture;
    row.picture = {fmt::format("atlas-{}.png", entry.name), picture.caption, picture.largest};
    write_signed_png(json_folder / row.picture->file, picture.extent, picture.values, picture.largest);
  }
  return row;
}

} // namespace hdmbench::atlas
