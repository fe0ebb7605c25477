#include "harness/report/accuracy_figures.hpp"
#include "harness/report/accuracy_tables.hpp"
#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::report {

namespace {

std::string details(bool open, const std::string& summary, const std::string& text,
                    const std::string& content) {
  if (content.empty()) {
    return {};
  }
  return fmt::format("<details{}><summary>{}</summary>\n{}{}</details>\n", open ? " open" : "", summary,
                     text.empty() ? "" : "<p>" + text + "</p>\n", content);
}

/// Beside which of our distances from FEM, Poisson ratio of the scene, the thesis's own lies. Empty where it
/// has none, or none of ours is near.
std::string what_the_thesis_is_near(const AccuracyScene& scene) {
  constexpr double near = 0.1; // a tenth of the thesis's figure
  std::string sentences;
  for (const PublishedAccuracy& published : published_accuracy(scene)) {
    for (const char* const method : {"sequential", "icm", "interpolation"}) {
      const AccuracyRow* const row = scene.find(method);
      if (!published.rmsd || row == nullptr || !row->to_fem.all ||
          !(std::abs(*row->to_fem.all - *published.rmsd) <= near * *published.rmsd)) {
        continue;
      }
      const bool interpolation = row->method == "interpolation";
      sentences += fmt::format(
          " The thesis's {:.2f} px ({}) is about {}, {:.2f} px from FEM with {}{}.", *published.rmsd,
          published.method, interpolation ? "where interpolation ends that knows no material" : "ours",
          *row->to_fem.all, poisson_text(scene.poisson),
          interpolation ? ": a field at that distance need not know of the soft tissue" : "");
      break;
    }
  }
  return sentences;
}

std::string scene_html(const Results& results, const AccuracyScene& scene, Anchors& anchors) {
  const std::string title =
      scene.title.empty() ? scene.scene : fmt::format("{}: {}", scene.scene, scene.title);
  std::string html = heading(
      results.machines.size() > 1 ? 4 : 3, anchors.unique(fmt::format("accuracy {}", scene.scene)),
      fmt::format("{}, {}, {}", title, size_text(scene.width, scene.height), poisson_text(scene.poisson)));
  html += "<div class=\"pair\">\n" + methods_table(scene) + tradeoff_figure(scene, anchors) + "</div>\n";
  html += details(
      true, "Where the error comes from",
      "total² = model² + optimisation² + 2 covariance. Model: what the energy itself misses, its fixed point "
      "against FEM; iterations do not change it. Optimisation: what ICM leaves to the fixed point. A "
      "negative covariance (hatched) means that the two errors partly cancel.",
      decomposition_table(scene));
  html += details(true, "Profiles against FEM", "", profile_figure(scene, anchors));
  html += details(false, "Differences to FEM as pictures", "", difference_figure(scene));
  html += details(false, "How many iterations it takes", "", convergence_figure(scene, anchors));
  html += details(false, "Through the levels", "", level_figure(scene, anchors));
  html += details(false, "Deformed grids", "", grid_figure(scene));
  html += details(false, "Why ours differs from the thesis",
                  "Each variant changes one thing against the run above it." + what_the_thesis_is_near(scene),
                  variants_table(scene));
  html += details(
      false, "At the interfaces of the materials",
      fmt::format(
          "RMSD to FEM with {} over the free sites; a ratio above 1 says that the error gathers where "
          "the material changes (thesis 5.11).{}",
          poisson_text(scene.poisson),
          scene.find("b-spline") == nullptr ? ""
                                            : " B-spline registration is shown the deformed picture itself, "
                                              "all others only the conditions; "
                                              "where the picture has no edges it has nothing to go by."),
      interfaces_table(scene));
  const bool beyond_bound = std::ranges::any_of(scene.rows, [](const AccuracyRow* row) {
    return row->arithmetic && row->arithmetic->beyond_bound > 0;
  });
  html += details(
      beyond_bound, "What float32 costs",
      "Iterations are repeated in double from the same field. A step that comes out otherwise must be a "
      "near-tie: its gap in energy within the rounding error bound derived for that site.",
      arithmetic_table(scene));
  return html;
}

} // namespace

std::string accuracy_section(const Results& results, Anchors& anchors) {
  std::string html = "<section>\n" + heading(2, anchors.unique("accuracy"), "How accurate are they?");
  if (results.accuracy.empty()) {
    return html + no_data("fields to judge", "accuracy") + "</section>\n";
  }
  html +=
      R"(<p>RMSD is over all sites, in pixels of the full image, as in the thesis; over the sites that no condition
prescribes beneath. The truth is plane-stress FEM with its nodes at the sites, with Poisson ratio ν = 0, since the
energy does not couple x and y, and with the ratio of the scene; the thesis does not print its own.</p>
)";
  html += quick_note(results, results.accuracy);
  for (const std::string& machine : results.machines) {
    const std::vector<AccuracyScene> scenes = accuracy_scenes(results, machine);
    if (scenes.empty()) {
      continue;
    }
    html += machine_heading(results, machine, anchors);
    html += overview_table(scenes) +
            "<p class=\"empty\">Against FEM with ν = 0; with the ratio of the scene beneath.</p>\n";
    for (const AccuracyScene& scene : scenes) {
      html += scene_html(results, scene, anchors);
    }
  }
  return html + "</section>\n";
}

} // namespace hdmbench::report
