#include "harness/report/figure_atlas.hpp"
#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::report {

namespace {

std::string threshold_html(const atlas::SeriesResult& series) {
  if (!series.absence.empty()) {
    return fmt::format("<span class=\"empty\">{}: {}</span>", series.points.empty() ? "not there" : "refuses",
                       escape(series.absence));
  }
  const atlas::Threshold threshold = series.threshold();
  if (!threshold.failed) {
    return "no failure";
  }
  return threshold.good ? fmt::format("✗ at {:.6g}, ✓ at {:.6g}", *threshold.failed, *threshold.good)
                        : fmt::format("✗ from {:.6g} on", *threshold.failed);
}

std::string error_html(const atlas::Point& point) {
  return fmt::format("{}{}", point.failed ? "✗ " : "",
                     point.error ? fmt::format("{:.3g}", *point.error) : "not finite");
}

/// The entry's kinds that the point brought.
std::string told(const AtlasRow& row, const atlas::Point& point) {
  std::string text;
  for (const std::string& kind : row.warnings) {
    if (std::ranges::find(point.warnings, kind) != point.warnings.end()) {
      text += (text.empty() ? "" : ", ") + kind;
    }
  }
  return text;
}

std::string points_table(const AtlasRow& row) {
  const std::string knob = fmt::format(">{}", escape(row.knob));
  const std::string measure = fmt::format(">{}", escape(row.measure));
  std::string html = table_start("atlas", {"method", knob, measure, "warned of"});
  for (const atlas::SeriesResult& series : row.series) {
    for (const atlas::Point& point : series.points) {
      html += fmt::format("<tr><th scope=\"row\">{}</th><td class=\"number\">{:.6g}</td><td "
                          "class=\"number\">{}</td><td>{}</td></tr>\n",
                          escape(series.name), point.knob, error_html(point), escape(told(row, point)));
    }
  }
  return html + std::string(table_end);
}

std::string thresholds_table(const AtlasRow& row) {
  const std::string title = fmt::format("fails where {} is", escape(row.knob));
  std::string html = table_start("atlas", {"method", title});
  for (const atlas::SeriesResult& series : row.series) {
    html += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape(series.name),
                        threshold_html(series));
  }
  return html + std::string(table_end);
}

std::string picture_html(const Results& results, const AtlasRow& row) {
  if (!row.picture) {
    return {};
  }
  const EmbeddedPng png = embed_png(results.path_of(row, row.picture->file));
  return fmt::format("<figure><img src=\"{}\" width=\"{}\" height=\"{}\" style=\"width:min(100%,{}px);"
                     "height:auto;image-rendering:pixelated\" alt=\"{}\"><figcaption>{} (full colours: "
                     "±{:.3g})</figcaption></figure>\n",
                     png.uri, png.width, png.height, 2 * png.width, escape(row.picture->caption),
                     escape(row.picture->caption), row.picture->largest);
}

std::string sentence(std::string_view label, const std::string& text) {
  return text.empty() ? "" : fmt::format("<p><b>{}</b> {}</p>\n", label, escape(text));
}

std::string entry_html(const Results& results, const AtlasRow& row, Anchors& anchors) {
  const std::string id = anchors.unique("atlas " + row.entry);
  std::string html = sentence("Energy.", row.energy) + sentence("Why.", row.mechanism);
  const std::string plot = atlas_figure(row, id + '_');
  html += "<div class=\"pair\">\n";
  if (!plot.empty()) {
    html += fmt::format(
        "<figure><div class=\"plot\">{}</div><figcaption>{} at the left end; dashed: {:.6g}, above which it "
        "counts as failed.</figcaption></figure>\n",
        plot, size_text(row.width, row.height), row.limit);
  }
  html += thresholds_table(row) + picture_html(results, row) + "</div>\n";
  html += sentence("How it shows.", row.seen_by);
  html += sentence("What survives.", row.survivor);
  return html + folded("All values and warnings", points_table(row));
}

} // namespace

std::string atlas_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "failures", "Where the methods fail", no_data("failures", "atlas"),
      "<p>Each family of scenes varies one parameter from harmless to harmful. The warnings are those "
      "that <code>run</code> prints for the same scene and field.</p>\n"};
  return section(results, results.atlas, anchors, text,
                 [&](const std::string&, const std::vector<AtlasRow>& rows) {
                   std::string html;
                   for (const AtlasRow& row : rows) {
                     html += folded(escape(row.title), entry_html(results, row, anchors));
                   }
                   return html;
                 });
}

} // namespace hdmbench::report
