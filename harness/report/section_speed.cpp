#include "harness/report/sections.hpp"
#include "harness/report/speed_tables.hpp"
#include "harness/report/timings.hpp"
#include "reference/published.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace hdmbench::report {

namespace {

// The largest verified speed-up at a size; 0 where there is none.
double fastest(const SceneTimings& timings, const SceneTimings::Size& size) {
  double best = 0.0;
  for (const SceneTimings::Line& line : timings.lines) {
    const BenchRow* const row = SceneTimings::find(line, size);
    if (row != nullptr && row->speed_up_over_scalar) {
      best = std::max(best, *row->speed_up_over_scalar);
    }
  }
  return best;
}

std::string time_html(const BenchRow& row) {
  const auto [low, high] = std::ranges::minmax(row.seconds);
  return fmt::format("<td class=\"number\">{}<small>{}–{}</small></td>", seconds_text(*row.seconds_median),
                     seconds_text(low), seconds_text(high));
}

std::string reason_html(const BenchRow& row) {
  const bool ran = !row.seconds.empty();
  return fmt::format("<b>{}</b><small>{}</small>", ran ? "✗ not verified" : "– skipped",
                     escape(row.reason.empty() ? "no reason given" : row.reason));
}

std::string cells_html(const BenchRow* row, double best) {
  if (row == nullptr) {
    return "<td class=\"faint\" colspan=\"2\">not measured</td>";
  }
  if (!row->counts()) {
    return fmt::format("<td class=\"{}\" colspan=\"2\">{}</td>",
                       row->seconds.empty() ? "skipped" : "disagree", reason_html(*row));
  }
  if (!row->speed_up_over_scalar) {
    return time_html(*row) +
           fmt::format("<td class=\"faint\">{}</td>", row->valid ? "no scalar time" : "field not compared");
  }
  const bool is_best = *row->speed_up_over_scalar >= best;
  return time_html(*row) +
         fmt::format("<td class=\"number{}\">{}</td>", is_best ? " best" : "",
                     row->backend == "scalar" ? "1×" : speed_up_text(*row->speed_up_over_scalar));
}

// The reason that holds for every size of a line that never ran.
std::optional<std::string> skipped_everywhere(const SceneTimings::Line& line) {
  const auto skipped = [&](const BenchRow& row) {
    return !row.counts() && row.seconds.empty() && row.reason == line.rows.front().reason;
  };
  return std::ranges::all_of(line.rows, skipped) ? std::optional(reason_html(line.rows.front()))
                                                 : std::nullopt;
}

std::string line_html(const Results& results, const std::string& machine, const SceneTimings& timings,
                      const SceneTimings::Line& line) {
  std::string html =
      fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th>", escape(timings.label_of(line)),
                  device_html(results, machine, line.backend, line.device));
  if (const auto reason = skipped_everywhere(line)) {
    return html + fmt::format("<td class=\"skipped\" colspan=\"{}\">{}</td></tr>\n", 2 * timings.sizes.size(),
                              *reason);
  }
  for (const SceneTimings::Size& size : timings.sizes) {
    html += cells_html(SceneTimings::find(line, size), fastest(timings, size));
  }
  return html + "</tr>\n";
}

std::string published_seconds(double seconds) {
  return fmt::format("<td class=\"number\">{:.{}f}</td>", seconds, seconds < 10000.0 ? 2 : 1);
}

std::string thesis_html(const SceneTimings& timings) {
  std::string gpu = "<tr><th scope=\"row\">thesis, GPU<small>ATI Radeon X1300</small></th>";
  std::string cpu = "<tr><th scope=\"row\">thesis, CPU<small>Core 2 Duo, 1.86 GHz</small></th>";
  for (const SceneTimings::Size& size : timings.sizes) {
    const PublishedTiming* const row =
        size.width == size.height ? published_timing(timings.scene, static_cast<int>(size.width)) : nullptr;
    if (row == nullptr) {
      gpu += "<td colspan=\"2\"></td>";
      cpu += "<td colspan=\"2\"></td>";
      continue;
    }
    gpu +=
        published_seconds(row->gpu_seconds) + fmt::format("<td class=\"number\">{:.2f}×</td>", row->speed_up);
    cpu += published_seconds(row->cpu_seconds) + "<td class=\"number\">1×</td>";
  }
  return "<tbody class=\"thesis\">\n" + gpu + "</tr>\n" + cpu + "</tr>\n</tbody>\n";
}

std::string table_html(const Results& results, const std::string& machine, const SceneTimings& timings) {
  std::string html =
      "<div class=\"scroll\"><table class=\"speed\">\n<thead><tr><th rowspan=\"2\">Backend</th>";
  for (const SceneTimings::Size& size : timings.sizes) {
    html += fmt::format("<th scope=\"colgroup\" colspan=\"2\" class=\"group\">{}</th>",
                        size_text(size.width, size.height));
  }
  html += "</tr>\n<tr>";
  for (std::size_t i = 0; i < timings.sizes.size(); ++i) {
    html += "<th class=\"number\">seconds</th><th class=\"number\">speed-up</th>";
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const SceneTimings::Line& line : timings.lines) {
    html += line_html(results, machine, timings, line);
  }
  html += "</tbody>\n";
  if (!thesis_table(timings.scene).empty()) {
    html += thesis_html(timings);
  }
  return html + "</table></div>\n";
}

constexpr std::array<const char*, 4> phases{"projection", "upload", "compute", "readback"};

std::array<double, 4> phase_seconds(const BenchRow& row) {
  return {row.projection_seconds.value_or(0.0), row.upload_seconds.value_or(0.0),
          row.compute_seconds.value_or(0.0), row.readback_seconds.value_or(0.0)};
}

std::string bar_html(const BenchRow& row) {
  const std::array<double, 4> seconds = phase_seconds(row);
  double total = 0.0;
  std::ranges::for_each(seconds, [&](double part) { total += std::max(part, 0.0); });
  std::string html = "<td><span class=\"bar\" aria-hidden=\"true\">";
  for (std::size_t i = 0; i < phases.size() && total > 0.0; ++i) {
    html += fmt::format("<i class=\"{}\" style=\"width:{:.2f}%\"></i>", phases.at(i),
                        100.0 * std::max(seconds.at(i), 0.0) / total);
  }
  return html + "</span></td>";
}

std::string phase_html(const std::optional<double>& seconds) {
  if (!seconds) {
    return "<td class=\"faint number\">–</td>";
  }
  // Below a microsecond the clock is all there is to see.
  return fmt::format("<td class=\"number\">{}</td>", *seconds < 1e-6 ? "0" : seconds_text(*seconds));
}

std::string breakdown_html(const SceneTimings& timings) {
  std::string rows;
  for (const SceneTimings::Size& size : timings.sizes) {
    for (const SceneTimings::Line& line : timings.lines) {
      const BenchRow* const row = SceneTimings::find(line, size);
      if (row == nullptr || !row->counts()) {
        continue;
      }
      rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"number\">{}</td>",
                          escape(timings.name_of(line)), size_text(size.width, size.height),
                          count_text(row->iterations));
      rows += row->msites_per_second
                  ? fmt::format("<td class=\"number\">{:.1f}</td>", *row->msites_per_second)
                  : "<td class=\"faint number\">–</td>";
      rows += phase_html(row->setup_seconds) + phase_html(row->projection_seconds) +
              phase_html(row->upload_seconds) + phase_html(row->compute_seconds) +
              phase_html(row->readback_seconds) + bar_html(*row) + "</tr>\n";
    }
  }
  if (rows.empty()) {
    return {};
  }
  std::string legend;
  for (const char* const phase : phases) {
    legend += fmt::format("<span class=\"key\"><i class=\"{0}\"></i>{0}</span>", phase);
  }
  return folded("Time by phase",
                table_start("breakdown", {"Backend", "Size", ">Iterations", ">Msites/s", ">Set-up, once [s]",
                                          ">Projection [s]", ">Upload [s]", ">Compute [s]", ">Readback [s]",
                                          "Share without set-up " + legend}) +
                    rows + std::string(table_end));
}

std::string plot_html(const std::string& machine, const SceneTimings& timings, Anchors& anchors) {
  const std::vector<SizeSeries> series = size_series(timings, Quantity::seconds);
  if (series.empty()) {
    return "<p class=\"empty\">No plot: there is no verified timing.</p>\n";
  }
  const std::string id = anchors.unique("plot " + timings.scene);
  const std::string label =
      fmt::format("Seconds over pixels, both logarithmic, for the scene {} on {}; the figures stand in "
                  "the table beside it",
                  timings.scene, machine);
  return fmt::format("<figure class=\"plot\" id=\"{}\">{}</figure>\n", id,
                     size_plot(series, "seconds", id + '_', label));
}

// Empty where no line has two sizes.
std::string quantity_html(const std::string& machine, const SceneTimings& timings, Quantity quantity,
                          const std::string& title, Anchors& anchors) {
  const std::vector<SizeSeries> series = size_series(timings, quantity);
  if (std::ranges::none_of(series, [](const SizeSeries& line) { return line.sizes.size() > 1; })) {
    return {};
  }
  const std::string id = anchors.unique(title + ' ' + timings.scene);
  const std::string label =
      fmt::format("{} over pixels, both logarithmic, for the scene {} on {}", title, timings.scene, machine);
  const bool counts_all =
      quantity == Quantity::msites_per_second && std::ranges::any_of(series, &SizeSeries::active);
  return fmt::format(
      "<figure class=\"plot\" id=\"{}\">{}{}</figure>\n", id, size_plot(series, title, id + '_', label),
      counts_all ? "<figcaption>Active: updates that were left out count as done.</figcaption>" : "");
}

// Figures that not every result has the numbers for, folded away.
std::string more_figures_html(const Results& results, const std::string& machine, const SceneTimings& timings,
                              Anchors& anchors) {
  const std::string figures =
      quantity_html(machine, timings, Quantity::msites_per_second, "million site updates a second", anchors) +
      quantity_html(machine, timings, Quantity::bytes_per_site, "bytes of memory a site", anchors) +
      scaling_figure(results, machine, timings.scene, anchors);
  return figures.empty()
             ? ""
             : folded("Throughput, memory and threads", "<div class=\"figures\">\n" + figures + "</div>\n");
}

std::string scene_html(const Results& results, const std::string& machine, const SceneTimings& timings,
                       Anchors& anchors, bool open) {
  const std::string table = thesis_table(timings.scene);
  const std::string title =
      table.empty() ? timings.scene : fmt::format("{}, thesis {}", timings.scene, table);
  return folded(escape(title),
                "<div class=\"pair\">\n" + table_html(results, machine, timings) +
                    plot_html(machine, timings, anchors) + "</div>\n" + breakdown_html(timings) +
                    more_figures_html(results, machine, timings, anchors),
                open);
}

} // namespace

std::string speed_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "speed", "Speed", no_data("timings", "bench"),
      R"(<p>Median seconds for the whole pyramid, smallest and largest sample beneath, and the speed-up over scalar on
the same machine. In the plots each sample is a faint point, the median a line; dashed is the thesis, dotted is with tiles at rest left out.</p>
)"};
  return section(results, results.bench, anchors, text, [&](const std::string& machine, const auto&) {
    const std::vector<SceneTimings> scenes = scene_timings(results, machine);
    std::string html = legacy_sentence(scenes);
    for (const SceneTimings& timings : scenes) {
      html += scene_html(results, machine, timings, anchors, &timings == &scenes.front());
    }
    const int level = results.machines.size() > 1 ? 4 : 3;
    html += active_table(scenes, level, anchors);
    return html + ceilings_table(scenes, level, anchors);
  });
}

} // namespace hdmbench::report
