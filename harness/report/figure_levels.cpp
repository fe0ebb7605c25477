#include "harness/report/accuracy_figures.hpp"
#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 250.0;
constexpr double plot_height = 176.0;
constexpr Margins margins{38.0, 12.0, 8.0, 30.0};
constexpr const char* colour_x = plot_colours[1];
constexpr const char* colour_y = plot_colours[2];
constexpr const char* colour_fem = "b9c0c9";

struct Direction {
  LevelProfiles::Components LevelProfiles::*values;
  std::int64_t AccuracyScene::*length; ///< of the line in the full image
  std::vector<double> figures::Profiles::*fem;
  const char* fem_component;
  const char* name;
};
constexpr Direction along_row{&LevelProfiles::horizontal, &AccuracyScene::width,
                              &figures::Profiles::horizontal, "x", "middle row"};
constexpr Direction along_column{&LevelProfiles::vertical, &AccuracyScene::height,
                                 &figures::Profiles::vertical, "y", "middle column"};

// Where the sites of a level stand in the full image, corner on corner.
std::vector<double> positions(std::size_t count, double length) {
  std::vector<double> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    result[i] = count == 1 ? (length - 1.0) / 2.0
                           : static_cast<double>(i) * (length - 1.0) / static_cast<double>(count - 1);
  }
  return result;
}

std::string level_plot(const LevelProfiles& level, const Direction& direction, double length,
                       const std::vector<double>& fem, const Interval& range, const std::string& prefix,
                       const std::string& label) {
  const LevelProfiles::Components& values = level.*direction.values;
  const std::vector<double> at = positions(values.x.size(), length);
  const char* const style = values.x.size() <= 16 ? "linespoints pt 7 ps 0.35" : "lines";
  std::string script = plot_start(plot_width, plot_height) + plot_margins(plot_width, plot_height, margins) +
                       data_block("fem", positions(fem.size(), length), fem) + data_block("x", at, values.x) +
                       data_block("y", at, values.y);
  script += fmt::format("set xrange [0:{}]\nset yrange {}\nset ytics {:.6g}\nset xtics {}\nplot ",
                        std::max(length - 1.0, 1.0), range.range(), range.step(4),
                        std::max(1.0, std::round(length / 3.0)));
  if (!fem.empty()) {
    script += fmt::format("$fem with lines lw 5 lc rgb \"#{}\" notitle, ", colour_fem);
  }
  script +=
      fmt::format("$x with {0} lw 1.5 lc rgb \"#{1}\" notitle, $y with {0} lw 1.5 lc rgb \"#{2}\" notitle\n",
                  style, colour_x, colour_y);
  return gnuplot_svg(script, prefix, label);
}

std::string direction_html(const AccuracyScene& scene, const AccuracyRow& row, const Direction& direction,
                           Anchors& anchors) {
  const AccuracyRow* const fem = scene.find_fem(scene.poisson);
  const std::vector<double> truth =
      fem != nullptr && fem->profiles ? (*fem->profiles).*direction.fem : std::vector<double>{};
  Interval all;
  all.include(truth);
  for (const LevelProfiles& level : row.level_profiles) {
    all.include((level.*direction.values).x);
    all.include((level.*direction.values).y);
  }
  std::string legend = fmt::format(
      "<p class=\"legend\">{}: <span class=\"key\"><i class=\"stroke\" style=\"border-top:2px solid "
      "#{}\"></i>dx</span><span class=\"key\"><i class=\"stroke\" style=\"border-top:2px solid "
      "#{}\"></i>dy</span>",
      direction.name, colour_x, colour_y);
  if (!truth.empty()) {
    legend += fmt::format(
        "<span class=\"key\"><i class=\"stroke\" style=\"border-top:6px solid #{}\"></i>{}, d{}</span>",
        colour_fem, escape(method_name(*fem)), direction.fem_component);
  }
  std::string html = legend + "</p>\n<div class=\"levels\">\n";
  for (const LevelProfiles& level : row.level_profiles) {
    const std::string name = fmt::format("level {}, {}", level.level, size_text(level.width, level.height));
    const std::string id = anchors.unique(fmt::format("{} {} {}", direction.name, level.level, scene.scene));
    html += fmt::format(
        "<div><div class=\"plot\">{}</div><small>{}</small></div>\n",
        level_plot(level, direction, static_cast<double>(scene.*direction.length), truth, all, id + '_',
                   fmt::format("Displacement along the {}, {}, scene {}", direction.name, name, scene.scene)),
        name);
  }
  return html + "</div>\n";
}

} // namespace

std::string level_figure(const AccuracyScene& scene, Anchors& anchors) {
  const AccuracyRow* const row =
      scene.first([](const AccuracyRow& other) { return !other.level_profiles.empty(); });
  if (row == nullptr) {
    return {};
  }
  return "<figure class=\"wide\">\n" + direction_html(scene, *row, along_row, anchors) +
         direction_html(scene, *row, along_column, anchors) +
         fmt::format(
             "<figcaption>{} from the coarsest level to the full image, in pixels of the full image: the "
             "coarse levels give the shape, the fine ones its kinks.{}</figcaption></figure>\n",
             escape(method_name(*row)), thesis_reference(thesis_figures(scene.scene).levels));
}

} // namespace hdmbench::report
