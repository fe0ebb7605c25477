#include "harness/atlas/atlas.hpp"
#include "harness/images.hpp"

#include <fmt/format.h>

namespace hdmbench::atlas {

namespace {

using nlohmann::json;

json number_or_null(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

json series_json(const SeriesResult& series) {
  json points = json::array();
  for (const Point& point : series.points) {
    points.push_back({{"knob", point.knob},
                      {"error", number_or_null(point.error)},
                      {"failed", point.failed},
                      {"warnings", point.warnings}});
  }
  const Threshold threshold = series.threshold();
  return {{"name", series.name},
          {"absence", series.absence},
          {"points", std::move(points)},
          {"last_good", number_or_null(threshold.good)},
          {"first_failed", number_or_null(threshold.failed)}};
}

} // namespace

json to_json(const EntryResult& result, const std::filesystem::path& json_folder) {
  const Entry& entry = *result.entry;
  json row{{"entry", entry.name},          {"title", entry.title},           {"mechanism", entry.mechanism},
           {"knob", entry.knob},           {"measure", entry.measure},       {"limit", entry.limit},
           {"seen_by", entry.seen_by},     {"survivor", entry.survivor},     {"warnings", entry.warnings},
           {"width", result.extent.width}, {"height", result.extent.height}, {"seconds", result.seconds},
           {"series", json::array()}};
  for (const SeriesResult& series : result.series) {
    row["series"].push_back(series_json(series));
  }
  if (result.picture && have_images()) {
    const Picture& picture = *result.picture;
    const std::string file = fmt::format("atlas-{}.png", entry.name);
    write_signed_png(json_folder / file, picture.extent, picture.values, picture.largest);
    row["picture"] = {{"file", file}, {"caption", picture.caption}, {"largest", picture.largest}};
  }
  return row;
}

} // namespace hdmbench::atlas
