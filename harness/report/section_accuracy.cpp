#include "harness/report/accuracy_figures.hpp"
#include "harness/report/accuracy_tables.hpp"
#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::report {

namespace {

/// A sentence above, where there is content.
std::string folded_with(std::string_view summary, std::string_view text, const std::string& content,
                        bool open = false) {
  return folded(summary, content.empty() ? "" : fmt::format("<p>{}</p>\n{}", text, content), open);
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

std::string scene_html(const AccuracyScene& scene, Anchors& anchors) {
  std::string html =
      "<div class=\"pair\">\n" + methods_table(scene) + tradeoff_figure(scene, anchors) + "</div>\n";
  html += folded_with(
      "Error by source: model and optimisation",
      "total² = model² + optimisation² + 2 covariance. Model: the distance of the energy's fixed point from "
      "FEM, which iterations do not change. Optimisation: the distance of ICM from the fixed point. A "
      "negative covariance (hatched) means that the two errors partly cancel.",
      decomposition_table(scene), true);
  html += folded("Profiles against FEM", profile_figure(scene, anchors), true);
  html += folded("Difference to FEM", difference_figure(scene));
  html += folded("Convergence", convergence_figure(scene, anchors));
  html += folded("Displacement on each level", level_figure(scene, anchors));
  html += folded("Deformed grids", grid_figure(scene));
  html +=
      folded_with("Variants: what differs from the thesis",
                  "Each variant changes one thing against the run above it." + what_the_thesis_is_near(scene),
                  variants_table(scene));
  html += folded_with(
      "Error at material interfaces",
      fmt::format(
          "RMSD to FEM with {} over the free sites. A ratio above 1 says that the error is larger where the "
          "material changes (thesis 5.11).{}",
          poisson_text(scene.poisson),
          scene.find("b-spline") == nullptr
              ? ""
              : " B-spline registration sees the deformed picture itself, all others only the conditions; "
                "where the picture has no edges, registration has no information."),
      interfaces_table(scene));
  const bool beyond_bound = std::ranges::any_of(scene.rows, [](const AccuracyRow* row) {
    return row->arithmetic && row->arithmetic->resynchronised.beyond_bound > 0;
  });
  html += folded_with(
      "Single against double precision",
      "Iterations are repeated in double precision from the same field. A step that differs must be a "
      "near-tie: its gap in energy is within the rounding error bound derived for that site.",
      arithmetic_table(scene), beyond_bound);
  return html;
}

/// "square: a square, 300 x 300, nu = 0.3".
std::string title_of(const AccuracyScene& scene) {
  const std::string title =
      scene.title.empty() ? scene.scene : fmt::format("{}: {}", scene.scene, scene.title);
  return escape(
      fmt::format("{}, {}, {}", title, size_text(scene.width, scene.height), poisson_text(scene.poisson)));
}

} // namespace

std::string accuracy_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "accuracy", "Accuracy", no_data("fields to judge", "accuracy"),
      R"(<p>RMSD is over all sites, in pixels of the full image, as in the thesis; over the sites that no condition
prescribes beneath. The truth is plane-stress FEM with its nodes at the sites, with Poisson ratio ν = 0, since the
energy does not couple x and y, and with the ratio of the scene; the thesis does not print its own.</p>
)"};
  return section(results, results.accuracy, anchors, text, [&](const std::string& machine, const auto&) {
    const std::vector<AccuracyScene> scenes = accuracy_scenes(results, machine);
    std::string html =
        overview_table(scenes) +
        "<p class=\"empty\">Against FEM with ν = 0; with the ratio of the scene beneath.</p>\n";
    for (const AccuracyScene& scene : scenes) {
      const bool has_failure = !std::ranges::all_of(scene.rows, &AccuracyRow::valid);
      html += folded(title_of(scene), scene_html(scene, anchors), has_failure);
    }
    return html;
  });
}

} // namespace hdmbench::report
