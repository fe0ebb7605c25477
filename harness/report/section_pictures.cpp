#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace hdmbench::report {

namespace {

constexpr std::array<std::pair<std::string RunRow::Pictures::*, const char*>, 4> picture_kinds{{
    {&RunRow::Pictures::before, "before"},
    {&RunRow::Pictures::after, "after"},
    {&RunRow::Pictures::grid, "grid, deformed"},
    {&RunRow::Pictures::magnitude, "magnitude of the displacement, black is 0"},
}};

std::string picture_html(const Results& results, const RunRow& row, const std::string& file,
                         const char* caption) {
  if (file.empty()) {
    return {};
  }
  const EmbeddedPng png = embed_png(results.path_of(row, file));
  // Enlarged to twice its pixels at most.
  return fmt::format("<figure><img src=\"{}\" width=\"{}\" height=\"{}\" style=\"max-width:min(100%,{}px)\" "
                     "alt=\"{}: {}\"><figcaption>{}</figcaption></figure>\n",
                     png.uri, png.width, png.height, 2 * png.width, escape(row.scene), caption, caption);
}

std::string caption_html(const Results& results, const RunRow& row) {
  std::string text = fmt::format("{} at {:.4g} mm a pixel", size_text(row.width, row.height), row.spacing);
  if (row.largest_displacement) {
    text += fmt::format("; largest displacement {:.4g} px = {:.4g} mm", *row.largest_displacement,
                        *row.largest_displacement * row.spacing);
  }
  text += fmt::format("; {}, {}, {} s", plural(row.levels, "level"), plural(row.iterations, "iteration"),
                      seconds_text(row.seconds));
  if (row.mean_energy) {
    text += fmt::format("; mean energy {:.4g}", *row.mean_energy);
  }
  const std::string device = device_html(results, results.machine_of(row), row.backend, row.device);
  return fmt::format("<p>{} by {} on {}{}.{}</p>\n", escape(row.method), escape(row.backend), device,
                     results.machines.size() > 1 ? ", " + escape(results.machine_of(row)) : "",
                     " " + text +
                         (row.field.empty() ? "." : ". Field: <code>" + escape(row.field) + "</code>"));
}

} // namespace

std::string pictures_section(const Results& results, Anchors& anchors) {
  std::string html = "<section>\n" + heading(2, anchors.unique("pictures"), "Displacement fields");
  if (results.run.empty()) {
    html += no_data("pictures", "run SCENE");
  }
  html += quick_note(results, results.run);
  for (const RunRow& row : results.run) {
    html += heading(3, anchors.unique("run " + row.scene), row.title.empty() ? row.scene : row.title);
    html += caption_html(results, row);
    std::string pictures;
    for (const auto& [kind, caption] : picture_kinds) {
      pictures += row.pictures ? picture_html(results, row, (*row.pictures).*kind, caption) : "";
    }
    html += pictures.empty() ? "<p class=\"empty\">This run wrote no pictures.</p>\n"
                             : "<div class=\"pictures\">\n" + pictures + "</div>\n";
  }
  return html + "</section>\n";
}

} // namespace hdmbench::report
