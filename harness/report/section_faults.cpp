#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>

namespace hdmbench::report {

namespace {

using faults::Expected;
using faults::Layer;
using Rows = std::vector<FaultRow>;

Rows rows_where(const Rows& rows, const std::function<bool(const FaultRow&)>& belongs) {
  Rows some;
  std::ranges::copy_if(rows, std::back_inserter(some), belongs);
  return some;
}

/// Of all rows, in the order in which they come up first.
std::vector<FaultOnScene> scenes_of(const Rows& rows) {
  std::vector<FaultOnScene> scenes;
  for (const FaultRow& row : rows) {
    for (const FaultOnScene& scene : row.scenes) {
      if (std::ranges::find(scenes, scene.scene, &FaultOnScene::scene) == scenes.end()) {
        scenes.push_back(scene);
      }
    }
  }
  return scenes;
}

/// The colour of good is for a mistake that is seen, and for what is no mistake and let through.
std::string css_class(const FaultRow& row, const std::string& verdict) {
  const bool is_mistake = row.expected != Expected::let_through;
  return is_mistake && verdict == "disagree" ? "agree" : is_mistake && verdict == "agree" ? "faint" : verdict;
}

std::string cell_html(const FaultRow& row, const std::string& scene) {
  const auto found = std::ranges::find(row.scenes, scene, &FaultOnScene::scene);
  if (found == row.scenes.end()) {
    return "<td></td>";
  }
  const std::string detail =
      found->sites_differing > 0
          ? fmt::format("{} differing, {} uncertified", found->sites_differing, found->uncertified)
          : found->reason;
  return fmt::format("<td class=\"{}\" title=\"{}\">{}</td>", escape(css_class(row, found->verdict)),
                     escape(detail), escape(found->verdict));
}

std::string outcome_html(const FaultRow& row) {
  if (!row.not_planted.empty()) {
    return fmt::format("<td class=\"disagree\">not planted<small class=\"reason\">{}</small></td>",
                       escape(row.not_planted));
  }
  if (!row.as_expected) {
    return fmt::format("<td class=\"disagree\">✗ {}</td>",
                       row.expected == Expected::let_through ? "not let through" : "not caught");
  }
  if (!row.ran()) {
    return "<td class=\"skipped\">not run</td>";
  }
  if (row.expected == Expected::let_through) {
    return "<td class=\"agree\">✓ let through</td>";
  }
  return row.caught ? "<td class=\"agree\">✓ caught</td>" : "<td class=\"faint\">not shown here</td>";
}

std::string table_html(const Rows& rows) {
  const std::vector<FaultOnScene> scenes = scenes_of(rows);
  std::vector<std::string> titles;
  for (const FaultOnScene& scene : scenes) {
    titles.push_back(fmt::format("{}<small>{}{}</small>", escape(scene.scene),
                                 size_text(scene.width, scene.height), scene.exact ? ", exact" : ""));
  }
  std::vector<std::string_view> headings{"Fault", "Planted on"};
  headings.insert(headings.end(), titles.begin(), titles.end());
  headings.emplace_back("");
  std::string html = table_start("faults", headings);
  for (const FaultRow& row : rows) {
    html += fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th><td>{}</td>", escape(row.fault),
                        escape(row.what), escape(row.backend));
    for (const FaultOnScene& scene : scenes) {
      html += cell_html(row, scene.scene);
    }
    html += outcome_html(row) + "</tr>\n";
  }
  return html + std::string(table_end);
}

std::string details_html(std::string_view title, const Rows& rows) {
  return rows.empty() ? "" : folded(fmt::format("{} ({})", title, rows.size()), table_html(rows));
}

/// No scene that rounds would have caught it.
bool only_where_exact(const FaultRow& row) {
  return row.caught && std::ranges::none_of(row.scenes, [](const FaultOnScene& scene) {
           return scene.verdict == "disagree" && !scene.exact;
         });
}

/// "12 of 12 planted faults caught", and the controls.
std::string summary_html(const Rows& mistakes, const Rows& controls) {
  const auto run = [](const FaultRow& row) { return row.ran() || !row.as_expected; };
  const Rows planted = rows_where(
      mistakes, [&](const FaultRow& row) { return row.expected == Expected::disagree && run(row); });
  const Rows judged = rows_where(controls, run);
  const auto good = [](const Rows& rows) { return std::ranges::count(rows, true, &FaultRow::as_expected); };
  const bool all = good(planted) == std::ssize(planted) && good(judged) == std::ssize(judged);
  std::string html =
      fmt::format("<p class=\"{}\"><b>{} of {} planted faults caught, {} of {} controls let "
                  "through.</b></p>\n",
                  all ? "agree" : "disagree", good(planted), planted.size(), good(judged), judged.size());
  const auto exact = std::ranges::count_if(planted, only_where_exact);
  if (exact > 0) {
    html +=
        fmt::format("<p>{} of the faults only where every number is exact: elsewhere a near-tie would excuse "
                    "them.</p>\n",
                    exact);
  }
  const auto not_run = std::ranges::count_if(mistakes, [&](const FaultRow& row) { return !run(row); });
  if (not_run > 0) {
    html += fmt::format("<p class=\"note\">{} not run: there is no device for them.</p>\n",
                        plural(not_run, "mistake"));
  }
  return html;
}

std::string machine_html(const Rows& rows) {
  const Rows controls =
      rows_where(rows, [](const FaultRow& row) { return row.expected == Expected::let_through; });
  const Rows mistakes =
      rows_where(rows, [](const FaultRow& row) { return row.expected != Expected::let_through; });
  const auto in_layer = [&](Layer layer) {
    return rows_where(mistakes, [&](const FaultRow& row) { return row.layer == layer; });
  };
  const Rows trouble = rows_where(rows, [](const FaultRow& row) { return !row.as_expected; });
  return summary_html(mistakes, controls) + (trouble.empty() ? "" : table_html(trouble)) +
         details_html("Controls without a fault", controls) +
         details_html("Faults in a session", in_layer(Layer::session)) +
         details_html("Faults in the shaders", in_layer(Layer::shader)) +
         details_html("Faults in the calls to the driver", in_layer(Layer::driver));
}

} // namespace

std::string faults_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "faults", "Planted faults", no_data("planted faults", "faults"),
      "<p>Faults are planted one at a time: between the cross-check and a backend, in the text of the "
      "shaders, and in the calls to the driver. For each of them the cross-check has to disagree on at "
      "least one scene. Controls, such as rounding and -0, have to pass. A near-tie is certified only "
      "where numbers round; on an exact scene none is.</p>\n"};
  return section(results, results.faults, anchors, text,
                 [](const std::string&, const Rows& rows) { return machine_html(rows); });
}

} // namespace hdmbench::report
