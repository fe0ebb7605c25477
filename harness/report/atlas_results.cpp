#include "harness/report/atlas_results.hpp"

#include "harness/report/json_reader.hpp"

#include <fmt/format.h>

namespace hdmbench::report {

namespace {

AtlasSeries read_series(const JsonReader& json, double limit) {
  AtlasSeries series;
  series.name = json.text("name");
  series.absence = json.text("absence");
  series.last_good = json.number_or_null("last_good");
  series.first_failed = json.number_or_null("first_failed");
  for (const JsonReader& point : json.objects("points")) {
    AtlasPoint& read = series.points.emplace_back();
    read.knob = point.number("knob");
    read.error = point.number_or_null("error");
    read.failed = point.flag("failed");
    read.warnings = point.texts("warnings");
    if (read.failed == (read.error && *read.error <= limit)) {
      point.fail("failed", fmt::format("is {} although the limit is {}", read.failed, limit));
    }
  }
  if (series.absence.empty() && series.points.empty()) {
    json.fail("absence", "must say why where there are no points");
  }
  return series;
}

} // namespace

AtlasRow read_atlas(const JsonReader& json) {
  AtlasRow row;
  row.entry = json.text("entry");
  row.title = json.text("title");
  row.mechanism = json.text("mechanism");
  row.knob = json.text("knob");
  row.measure = json.text("measure");
  row.limit = json.number("limit");
  row.seen_by = json.text("seen_by");
  row.survivor = json.text("survivor");
  row.warnings = json.texts("warnings");
  row.width = json.count("width");
  row.height = json.count("height");
  std::size_t points = 0;
  for (const JsonReader& one : json.objects("series")) {
    const AtlasSeries series = read_series(one, row.limit);
    if (series.absence.empty()) {
      if (points > 0 && series.points.size() != points) {
        one.fail("points",
                 fmt::format("are {}, those of the series before {}", series.points.size(), points));
      }
      points = series.points.size();
    }
    row.series.push_back(series);
  }
  if (const auto picture = json.has("picture") ? json.object_or_null("picture") : std::nullopt) {
    row.picture = json.file().parent_path() / picture->text("file");
    row.picture_caption = picture->text("caption");
    row.picture_largest = picture->number("largest");
  }
  return row;
}

} // namespace hdmbench::report
