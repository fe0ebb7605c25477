#include "harness/report/speed_tables.hpp"

#include "harness/measure/median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace hdmbench::report {

namespace {

using Line = SceneTimings::Line;
using Size = SceneTimings::Size;

const BenchRow* valid_row(const Line& line, const Size& size) {
  const BenchRow* const row = SceneTimings::find(line, size);
  return row != nullptr && row->counts() ? row : nullptr;
}

// The same backend and device, all sites visited.
const Line* dense_of(const SceneTimings& timings, const Line& active) {
  const auto found = std::ranges::find_if(timings.lines, [&](const Line& line) {
    return !line.active && line.backend == active.backend && line.device == active.device &&
           dense_method(active.method, true) == line.method;
  });
  return found == timings.lines.end() ? nullptr : &*found;
}

// Active over dense, where both were timed.
struct Gain {
  double speed_up = 0.0;
  double active_seconds = 0.0;
  std::optional<double> dense_seconds;
};

std::optional<Gain> gain_of(const SceneTimings& timings, const Line& active, const Size& size) {
  const BenchRow* const row = valid_row(active, size);
  if (row == nullptr) {
    return std::nullopt;
  }
  const Line* const dense = dense_of(timings, active);
  const BenchRow* const all = dense == nullptr ? nullptr : valid_row(*dense, size);
  if (all != nullptr) {
    return Gain{*all->seconds_median / *row->seconds_median, *row->seconds_median, all->seconds_median};
  }
  if (row->speed_up_over_dense) {
    return Gain{*row->speed_up_over_dense, *row->seconds_median, std::nullopt};
  }
  return std::nullopt;
}

std::vector<std::string> active_backends(const std::vector<SceneTimings>& scenes) {
  std::vector<std::string> backends;
  for (const SceneTimings& timings : scenes) {
    for (const Line& line : timings.lines) {
      const bool timed = std::ranges::any_of(
          timings.sizes, [&](const Size& size) { return gain_of(timings, line, size).has_value(); });
      if (line.active && timed && std::ranges::find(backends, line.backend) == backends.end()) {
        backends.push_back(line.backend);
      }
    }
  }
  return backends;
}

std::optional<Gain> gain_of(const SceneTimings& timings, const std::string& backend, const Size& size) {
  for (const Line& line : timings.lines) {
    if (line.active && line.backend == backend) {
      if (const auto gain = gain_of(timings, line, size)) {
        return gain;
      }
    }
  }
  return std::nullopt;
}

std::string gain_html(const std::optional<Gain>& gain) {
  if (!gain) {
    return "<td class=\"faint number\">–</td>";
  }
  const std::string seconds = gain->dense_seconds
                                  ? fmt::format("{} s for {} s", seconds_text(gain->active_seconds),
                                                seconds_text(*gain->dense_seconds))
                                  : seconds_text(gain->active_seconds) + " s";
  return fmt::format("<td class=\"number\">{}<small>{}</small></td>", speed_up_text(gain->speed_up), seconds);
}

std::string rate_html(const std::optional<double>& value, int decimals) {
  return value ? fmt::format("<td class=\"number\">{:.{}f}</td>", *value, decimals)
               : std::string("<td class=\"faint number\">–</td>");
}

std::string binding_text(const BenchRow& row) {
  const bool memory = row.binding == Binding::memory;
  const BenchRow::Ceiling ceiling = row.ceiling.value_or(BenchRow::Ceiling{});
  const auto& most = memory ? ceiling.copy_gigabytes_per_second : ceiling.gigaoperations_per_second;
  return (memory ? "memory" : "arithmetic") +
         (most ? fmt::format(", {:.4g} {}/s", *most, memory ? "GB" : "Gop") : "");
}

std::string share_html(const BenchRow& row) {
  if (!row.percent_of_ceiling || !row.binding) {
    return "<td class=\"faint\" colspan=\"2\">no ceiling measured</td>";
  }
  return fmt::format(
      "<td class=\"number\">{:.0f} %</td><td><span class=\"bar share\" aria-hidden=\"true\"><i "
      "class=\"compute\" style=\"width:{:.1f}%\"></i></span><small>of {}</small></td>",
      *row.percent_of_ceiling, std::clamp(*row.percent_of_ceiling, 0.0, 100.0), binding_text(row));
}

bool has_rates(const BenchRow* row) {
  return row != nullptr && (row->gigabytes_per_second || row->percent_of_ceiling);
}

// Where most lines have numbers; of such sizes the largest.
std::optional<Size> size_of_most(const SceneTimings& timings) {
  std::optional<Size> best;
  std::ptrdiff_t most = 1;
  for (const Size& size : timings.sizes) {
    const auto count = std::ranges::count_if(
        timings.lines, [&](const Line& line) { return has_rates(valid_row(line, size)); });
    if (count >= most) {
      most = count;
      best = size;
    }
  }
  return best;
}

std::string ceiling_rows(const SceneTimings& timings) {
  const std::optional<Size> size = size_of_most(timings);
  std::string rows;
  for (const Line& line : timings.lines) {
    const BenchRow* const row = size ? valid_row(line, *size) : nullptr;
    if (!has_rates(row)) {
      continue;
    }
    // So small an image that it is lost in what the program holds anyway.
    const auto memory = row->bytes_per_site.value_or(0.0) > 0.0 ? row->bytes_per_site : std::nullopt;
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td class=\"name\">{}<small>{}</small></td>",
                        escape(timings.name_of(line)), escape(timings.scene),
                        size_text(size->width, size->height)) +
            rate_html(row->msites_per_second, 1) + rate_html(row->bytes_per_site_update, 1) +
            rate_html(row->operations_per_site_update, 0) + rate_html(row->gigabytes_per_second, 2) +
            rate_html(row->gigaoperations_per_second, 2) + share_html(*row) + rate_html(memory, 1) +
            "</tr>\n";
  }
  return rows;
}

std::string ceilings_html(const std::string& rows) {
  return table_start("ceilings",
                     {"Backend", "Scene", ">Msites/s", ">Bytes<br>an update", ">Operations<br>an update",
                      ">GB/s", ">Gop/s", ">Of the<br>ceiling", "", ">Memory,<br>bytes a site"}) +
         rows + std::string(table_end);
}

} // namespace

std::string legacy_sentence(const std::vector<SceneTimings>& scenes) {
  std::vector<double> ratios;
  std::string device;
  for (const SceneTimings& timings : scenes) {
    for (const Line& fragment : timings.lines) {
      for (const Line& compute : timings.lines) {
        if (fragment.backend != "gl-fragment" || compute.backend != "gl-compute" || fragment.active ||
            compute.active || fragment.device != compute.device || fragment.method != compute.method) {
          continue;
        }
        for (const Size& size : timings.sizes) {
          const BenchRow* const slow = valid_row(fragment, size);
          const BenchRow* const fast = valid_row(compute, size);
          if (slow != nullptr && fast != nullptr) {
            ratios.push_back(*slow->seconds_median / *fast->seconds_median);
            device = fragment.device;
          }
        }
      }
    }
  }
  if (ratios.empty()) {
    return {};
  }
  const auto [least, most] = std::ranges::minmax(ratios);
  const std::string range = ratios.size() == 1 ? fmt::format("{:.2f} times", least)
                                               : fmt::format("{:.2f} to {:.2f} times", least, most);
  const std::string middle =
      ratios.size() == 1
          ? ""
          : fmt::format(", in the middle {:.2f}, over {} scenes and sizes", median(ratios), ratios.size());
  return fmt::format(
      "<p>The thesis's way, a fragment shader of GLSL 1.20, takes {} as long as a compute shader for "
      "the same sweeps on the same OpenGL ({}){}.</p>\n",
      range, escape(device), middle);
}

std::string active_table(const std::vector<SceneTimings>& scenes, int level, Anchors& anchors) {
  const std::vector<std::string> backends = active_backends(scenes);
  if (backends.empty()) {
    return {};
  }
  std::vector<std::string> escaped{"Scene", "Size"};
  std::ranges::transform(backends, std::back_inserter(escaped),
                         [](const std::string& backend) { return fmt::format(">{}", escape(backend)); });
  std::string html =
      heading(level, anchors.unique("active"), "Active tiles against all sites") +
      "<p>A site can change only where its neighbourhood changed in the iteration before. Tiles at rest are "
      "left out; the field and the counts of changes stay the same to the bit. The table gives the speed-up "
      "over visiting all sites, and beneath it the seconds of a whole solution, active for dense.</p>\n" +
      table_start("active", {escaped.begin(), escaped.end()});
  for (const SceneTimings& timings : scenes) {
    for (const Size& size : timings.sizes) {
      std::string cells;
      bool any = false;
      for (const std::string& backend : backends) {
        const auto gain = gain_of(timings, backend, size);
        any = any || gain.has_value();
        cells += gain_html(gain);
      }
      if (any) {
        html += fmt::format("<tr><th scope=\"row\">{}</th><td class=\"number\">{}</td>{}</tr>\n",
                            escape(timings.scene), size_text(size.width, size.height), cells);
      }
    }
  }
  return html + std::string(table_end);
}

std::string ceilings_table(const std::vector<SceneTimings>& scenes, int level, Anchors& anchors) {
  std::vector<std::string> rows;
  for (const SceneTimings& timings : scenes) {
    if (std::string found = ceiling_rows(timings); !found.empty()) {
      rows.push_back(std::move(found));
    }
  }
  if (rows.empty()) {
    return {};
  }
  std::string html = heading(level, anchors.unique("ceilings"), "Share of the measured ceilings") +
                     "<p>Bytes and operations of a site update are those that the kernel declares; "
                     "multiplied by the updates per second they are rates. The ceilings (copying memory, "
                     "arithmetic) were measured in the same run. The ceiling that would take longer binds. "
                     "On a CPU, a level that fits into a cache moves no memory.</p>\n" +
                     ceilings_html(rows.front());
  std::string others;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    others += rows[i];
  }
  return html + (others.empty() ? "" : folded("The other scenes", ceilings_html(others)));
}

} // namespace hdmbench::report
