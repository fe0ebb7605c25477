#include "harness/report/sections.hpp"
#include "harness/report/tradeoff_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench::report {

namespace {

/// What one machine measured on one scene at one size.
struct TradeoffScene {
  std::string name; ///< for people: "square, 300 x 300, nu = 0.3"
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double poisson = 0.0;
  std::vector<TradeoffRow> rows{};
};

std::vector<TradeoffScene> scenes_of(const std::vector<TradeoffRow>& rows) {
  std::vector<TradeoffScene> scenes;
  for (const TradeoffRow& row : rows) {
    const auto known = std::ranges::find_if(scenes, [&](const TradeoffScene& scene) {
      return scene.scene == row.scene && scene.width == row.width && scene.height == row.height &&
             scene.poisson == row.poisson;
    });
    TradeoffScene& scene =
        known != scenes.end()
            ? *known
            : scenes.emplace_back(TradeoffScene{fmt::format("{}, {}, ν\u00A0=\u00A0{:.2g}", row.scene,
                                                            size_text(row.width, row.height), row.poisson),
                                                row.scene, row.width, row.height, row.poisson});
    scene.rows.push_back(row);
  }
  return scenes;
}

/// One setting, whatever the scene; a rival's Poisson ratio counts as none or the scene's.
bool same_setting(const TradeoffRow& a, const TradeoffRow& b) {
  const auto has_none = [](const TradeoffRow& row) { return row.poisson_used == 0.0; };
  return a.method == b.method && a.effort == b.effort && a.backend == b.backend && has_none(a) == has_none(b);
}

/// Adds a scene to the sum of a setting: seconds and sweeps add up, of the errors the worst counts, and a
/// scene without a result is one here too.
void add_scene(TradeoffRow& sum, const TradeoffRow& row) {
  const auto add = [](std::optional<double>& total, const std::optional<double>& more) {
    total = total && more ? std::optional(*total + *more) : std::nullopt;
  };
  const auto worst = [](std::optional<double>& largest, const std::optional<double>& other) {
    largest = largest && other ? std::optional(std::max(*largest, *other)) : std::nullopt;
  };
  if (sum.status == PointStatus::ok && row.status != PointStatus::ok) {
    sum.status = row.status;
    sum.reason = fmt::format("{}: {}", row.scene, row.reason);
  }
  add(sum.seconds_median, row.seconds_median);
  add(sum.fine_sweep_equivalents, row.fine_sweep_equivalents);
  worst(sum.to_fem_nu0, row.to_fem_nu0);
  worst(sum.to_fem, row.to_fem);
  worst(sum.to_fixed_point, row.to_fixed_point);
}

/// The settings over all scenes.
std::vector<TradeoffRow> over_all(const std::vector<TradeoffScene>& scenes) {
  std::vector<TradeoffRow> sums;
  for (const TradeoffRow& first : scenes.front().rows) {
    TradeoffRow sum = first;
    sum.command.clear();
    for (auto scene = std::next(scenes.begin()); scene != scenes.end(); ++scene) {
      const auto found =
          std::ranges::find_if(scene->rows, [&](const TradeoffRow& row) { return same_setting(row, first); });
      if (found == scene->rows.end()) {
        sum.status = PointStatus::skipped;
        sum.reason = fmt::format("not measured on {}", scene->name);
      } else {
        add_scene(sum, *found);
      }
    }
    sums.push_back(std::move(sum));
  }
  return sums;
}

std::string switches(Anchors& anchors) {
  std::string html = "<form class=\"switches\" hidden>";
  const auto add = [&](const char* title, const char* axis, auto names, const char* before) {
    const std::string name = anchors.unique(fmt::format("tradeoff {}", axis));
    html += fmt::format("<fieldset><legend>{}</legend>", title);
    for (std::size_t i = 0; i < names.size(); ++i) {
      html += fmt::format(
          "<label><input type=\"radio\" name=\"{}\" data-axis=\"{}\" value=\"{}\"{}> {}{}</label>", name,
          axis, i, i == 0 ? " checked" : "", before, names[i]);
    }
    html += "</fieldset>";
  };
  add("Across", "across", cost_names, "");
  add("Up: RMSD to", "up", error_names, "");
  return html + "</form>\n";
}

/// In the order in which they come up first.
std::vector<std::string> distinct(const std::vector<TradeoffRow>& rows,
                                  std::string hdmbench::TradeoffRow::*member) {
  std::vector<std::string> values;
  for (const TradeoffRow& row : rows) {
    if (std::ranges::find(values, row.*member) == values.end()) {
      values.push_back(row.*member);
    }
  }
  return values;
}

std::string legend(const std::vector<std::string>& methods, const std::vector<std::string>& backends) {
  std::string html = "<p class=\"legend chooser\">Methods ";
  for (const std::string& method : methods) {
    html += fmt::format("<button type=\"button\" data-kind=\"method\" value=\"{0}\" aria-pressed=\"false\" "
                        "disabled><i style=\"background:#{1}\"></i>{0}</button>",
                        escape(method), tradeoff_colour(method));
  }
  html += "</p>\n<p class=\"legend chooser\">Backends ";
  for (const std::string& backend : backends) {
    html += fmt::format(
        "<button type=\"button\" data-kind=\"backend\" value=\"{}\" aria-pressed=\"false\" disabled>"
        "<svg viewBox=\"-6 -6 12 12\" aria-hidden=\"true\"><path d=\"{}\"/></svg>{}</button>",
        escape(backend), backend_shape(backend, backends),
        backend.empty() ? "rivals, on the CPU" : escape(backend));
  }
  return html + "</p>\n";
}

std::string figure(const std::vector<TradeoffRow>& rows, const std::vector<std::string>& backends,
                   const std::string& title, const std::string& caption) {
  return fmt::format("<figure><h4>{}</h4><div class=\"plot\">{}</div><p class=\"picked-text\" "
                     "aria-live=\"polite\"></p><figcaption>{}</figcaption></figure>\n",
                     escape(title), tradeoff_chart(rows, backends, title), caption);
}

std::string number_cell(const std::optional<double>& value) {
  return fmt::format("<td class=\"number\">{}</td>", value ? fmt::format("{:.4g}", *value) : "");
}

std::string points_table(const TradeoffScene& scene) {
  std::string html =
      table_start("accuracy", {"Method", "Effort", "Backend", ">Seconds", ">Samples", ">Fine sweeps",
                               ">FEM, ν = 0", ">FEM, ν of the scene", ">Fixed point", "Command"});
  for (const TradeoffRow& row : scene.rows) {
    const std::string status = row.status == PointStatus::ok
                                   ? ""
                                   : fmt::format("<small class=\"{}\"><b>{}</b>: {}</small>",
                                                 row.status == PointStatus::skipped ? "skipped" : "disagree",
                                                 name_of(row.status), escape(row.reason));
    html += fmt::format("<tr><th scope=\"row\">{}{}</th><td>{}</td><td>{}</td>", escape(tradeoff_name(row)),
                        status, escape(row.effort), escape(row.backend));
    html += fmt::format("<td class=\"number\">{}</td><td class=\"number\">{}</td>",
                        row.seconds_median ? seconds_text(*row.seconds_median) : "", row.seconds.size());
    html += number_cell(row.fine_sweep_equivalents) + number_cell(row.to_fem_nu0) + number_cell(row.to_fem) +
            number_cell(row.to_fixed_point);
    html += fmt::format("<td><code>{}</code></td></tr>\n", escape(row.command));
  }
  return folded(fmt::format("All {} of {}", plural(std::ssize(scene.rows), "point"), escape(scene.name)),
                html + std::string(table_end));
}

std::string ratio_cell(const std::optional<EqualAccuracyRow::Rival>& rival) {
  if (!rival) {
    return "<td class=\"number faint\">not measured, or nowhere that near</td>";
  }
  return fmt::format("<td class=\"number\"><b>{}</b><small>{:.3g} to {:.3g}; {}, {} s</small></td>",
                     speed_up_text(rival->ratio), rival->ratio_low, rival->ratio_high, escape(rival->effort),
                     seconds_text(rival->seconds_median));
}

std::string equal_accuracy_table(const std::vector<EqualAccuracyRow>& rows) {
  if (rows.empty()) {
    return {};
  }
  std::string html = table_start("accuracy", {"At equal accuracy", "Our fastest", ">Seconds",
                                              ">Faster than direct FEM", ">Faster than FEM by CG",
                                              ">Faster than FEM by multigrid", ">Faster than coarse FEM"});
  for (const EqualAccuracyRow& row : rows) {
    html += fmt::format("<tr><th scope=\"row\">{}<small>{}, at most {:.3g} px to FEM, ν = 0</small></th>",
                        escape(row.scene), size_text(row.width, row.height), row.target);
    if (!row.ours) {
      html += fmt::format(
          "<td colspan=\"6\" class=\"faint\">{}</td></tr>\n",
          row.nearest ? fmt::format("No method is that near; the nearest is {:.3g} px away.", *row.nearest)
                      : "No method has a result.");
      continue;
    }
    html += fmt::format("<td>{}<small>{}, {}</small></td><td class=\"number\">{}</td>",
                        escape(row.ours->method), escape(row.ours->effort), escape(row.ours->backend),
                        seconds_text(row.ours->seconds_median)) +
            ratio_cell(row.direct) + ratio_cell(row.iterative) + ratio_cell(row.multigrid) +
            ratio_cell(row.coarse) + "</tr>\n";
  }
  return html + std::string(table_end) +
         "<p class=\"empty\">Below 1 the rival is faster. Beneath a ratio: the least and the most that the "
         "samples "
         "allow.</p>\n";
}

/// What a request is for, as of TradeoffPoint.
std::optional<double> reached(const TradeoffRow& row) {
  return !row.poisson_used ? row.to_fixed_point : *row.poisson_used == 0.0 ? row.to_fem_nu0 : row.to_fem;
}

/// A column per scene and energy, a row per accuracy asked for.
std::string requests_table(const std::vector<TradeoffScene>& scenes) {
  std::vector<std::string> head{">Asked, px"};
  std::map<double, std::map<std::string, const TradeoffRow*>, std::greater<>> asked;
  std::vector<std::string> columns;
  for (const TradeoffScene& scene : scenes) {
    for (const TradeoffRow& row : scene.rows) {
      if (row.asked && row.poisson_used != 0.0) { // with the scene's ratio, as people have it
        std::string column = row.poisson_used
                                 ? fmt::format("{}, elastic, ν = {:.2g}", scene.name, *row.poisson_used)
                                 : scene.name;
        asked[*row.asked][column] = &row;
        if (columns.empty() || columns.back() != column) {
          head.push_back(fmt::format(">{}", escape(column)));
          columns.push_back(std::move(column));
        }
      }
    }
  }
  if (asked.empty()) {
    return {};
  }
  std::string html = table_start("accuracy", {head.begin(), head.end()});
  for (const auto& [pixels, rows] : asked) {
    html += fmt::format("<tr><th scope=\"row\" class=\"number\">{:.3g}</th>", pixels);
    for (const std::string& column : columns) {
      const auto found = rows.find(column);
      if (found == rows.end() || !reached(*found->second)) {
        html += "<td class=\"number faint\">no result</td>";
        continue;
      }
      const TradeoffRow& row = *found->second;
      html += fmt::format(
          "<td class=\"number\"><b{}>{:.2g}</b><small>estimated {:.2g}; {:.3g} sweeps, {} s</small></td>",
          row.status == PointStatus::ok ? "" : " class=\"disagree\"", *reached(row),
          row.estimated.value_or(0.0), row.fine_sweep_equivalents.value_or(0.0),
          row.seconds_median ? seconds_text(*row.seconds_median) : "");
    }
    html += "</tr>\n";
  }
  return html + std::string(table_end) +
         "<p class=\"empty\">No more than the scene needs: <code>run --accuracy</code> chooses levels and "
         "cycles by the "
         "accuracy asked for. RMSD to the fixed point, or of the elastic energy to finite elements, in "
         "pixels, as it is and "
         "as the run itself estimates it.</p>\n";
}

std::string machine_html(const Results& results, const std::string& machine,
                         const std::vector<TradeoffRow>& rows, Anchors& anchors) {
  const std::vector<TradeoffScene> scenes = scenes_of(rows);
  const std::vector<std::string> backends = distinct(rows, &hdmbench::TradeoffRow::backend);
  std::string html = "<div class=\"tradeoff\">\n" + switches(anchors) +
                     legend(distinct(rows, &hdmbench::TradeoffRow::method), backends) +
                     "<div class=\"charts\">\n";
  // Other sizes are measured with few methods, and their seconds would drown all others.
  std::vector<TradeoffScene> alike;
  std::ranges::copy_if(scenes, std::back_inserter(alike), [&](const TradeoffScene& scene) {
    return scene.rows.front().width == scenes.front().rows.front().width &&
           scene.rows.front().height == scenes.front().rows.front().height;
  });
  if (alike.size() > 1) {
    html += figure(over_all(alike), backends,
                   fmt::format("All scenes of {}", size_text(alike.front().rows.front().width,
                                                             alike.front().rows.front().height)),
                   "Seconds added up over the scenes, the worst RMSD of them.");
  }
  for (const TradeoffScene& scene : scenes) {
    html += figure(scene.rows, backends, scene.name, "");
  }
  html += "</div>\n</div>\n";
  html += equal_accuracy_table(results.of(results.equal_accuracy, machine)) + requests_table(scenes);
  for (const TradeoffScene& scene : scenes) {
    html += points_table(scene);
  }
  return html;
}

} // namespace

std::string tradeoff_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "tradeoff", "Speed and accuracy", no_data("points of speed and accuracy", "tradeoff"),
      R"(<p>Every method at several efforts: the seconds of a whole solution and how far it then is from the truth. Lower
left is better. The staircase is the Pareto front: nothing measured is both faster and nearer. A curve joins the
efforts of one method on one backend. A cross is a result that is not scalar's to the bit, or none at all: it
failed, diverged, or its backend is not there.</p>
)"};
  return section(results, results.tradeoff, anchors, text, [&](const std::string& machine, const auto& rows) {
    return machine_html(results, machine, rows, anchors);
  });
}

} // namespace hdmbench::report
