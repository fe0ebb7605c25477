#include "harness/report/accuracy_figures.hpp"
#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <array>
#include <numeric>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 520.0;
constexpr double plot_height = 400.0;
constexpr Margins margins{58.0, 12.0, 10.0, 48.0};
constexpr double middle = 158.0; // between values and differences, from the bottom

struct Line {
  std::string name;
  const figures::Profiles* profiles = nullptr;
  std::string colour;
  double width = 1.0;
  int dash = 1; ///< gnuplot's dash type; 1 is solid
};

// FEM first: a broad pale band on which the thin lines of the others lie.
std::vector<Line> lines_of(const AccuracyScene& scene) {
  std::vector<Line> lines;
  const auto add = [&](const AccuracyRow* row, double width, int dash) {
    if (row != nullptr && row->profiles) {
      lines.push_back(
          {method_name(*row), &*row->profiles, width > 2.0 ? "b9c0c9" : method_colour(*row), width, dash});
    }
  };
  // Of several backends one carries the profiles.
  const auto carrier = [&](const char* method) {
    return scene.first([&](const AccuracyRow& row) {
      return row.method == method && row.variant.empty() && row.profiles.has_value();
    });
  };
  add(scene.find_fem(scene.poisson), 6.0, 1);
  if (scene.poisson != 0.0) {
    add(scene.find_fem(0.0), 1.2, 2);
  }
  add(carrier("fixed-point"), 1.4, 1);
  add(carrier("sequential"), 1.4, 1);
  add(carrier("icm"), 1.4, 1);
  add(carrier("interpolation"), 1.2, 3);
  return lines;
}

struct Path {
  std::vector<double> figures::Profiles::*values;
  const char* name;
  const char* what;
};
constexpr std::array<Path, 4> paths{{
    {&figures::Profiles::horizontal, "horizontal", "dx along the middle row, left to right"},
    {&figures::Profiles::vertical, "vertical", "dy along the middle column, top to bottom"},
    {&figures::Profiles::falling, "falling", "|d| from the top left to the bottom right corner"},
    {&figures::Profiles::rising, "rising", "|d| from the bottom left to the top right corner"},
}};

std::vector<double> differences(const std::vector<double>& values, const std::vector<double>& truth) {
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    result[i] = values[i] - truth[i];
  }
  return result;
}

std::string plot_lines(const std::vector<Line>& lines, const char* block, std::size_t from) {
  std::string command = "plot ";
  for (std::size_t i = from; i < lines.size(); ++i) {
    command += fmt::format("{}${}{} with lines lw {} dt {} lc rgb \"#{}\" notitle", i == from ? "" : ", ",
                           block, i, lines[i].width, lines[i].dash, lines[i].colour);
  }
  return command + '\n';
}

// The first line is FEM, which the differences are taken to.
std::string profile_plot(const AccuracyScene& scene, const std::vector<Line>& lines, const Path& path,
                         const std::string& prefix) {
  const std::vector<double>& truth = lines.front().profiles->*path.values;
  std::vector<double> positions(truth.size());
  std::iota(positions.begin(), positions.end(), 0.0);
  Interval values;
  Interval gaps;
  gaps.include(0.0);
  std::string blocks;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<double>& line = lines[i].profiles->*path.values;
    if (line.size() != truth.size()) {
      throw InputError(fmt::format("{}: the {} profile of {} has {} values, that of {} has {}", scene.scene,
                                   path.name, lines[i].name, line.size(), lines.front().name, truth.size()));
    }
    const std::vector<double> gap = differences(line, truth);
    values.include(line);
    if (lines[i].dash != 3 || lines.size() == 2) { // interpolation may leave the panel
      gaps.include(gap);
    }
    blocks += data_block(fmt::format("value{}", i), positions, line) +
              data_block(fmt::format("gap{}", i), positions, gap);
  }

  std::string script = plot_start(plot_width, plot_height) + blocks + "set multiplot\n" +
                       fmt::format("set xrange [0:{}]\n", std::max<std::size_t>(truth.size(), 2) - 1);
  script += plot_margins(plot_width, plot_height, {margins.left, margins.right, margins.top, middle + 8.0});
  script += "set format x ''\n" +
            y_title("displacement [px]", plot_width, plot_height,
                    (plot_height - margins.top + middle + 8.0) / 2.0) +
            fmt::format("set yrange {}\n", values.range()) + plot_lines(lines, "value", 0);
  if (lines.size() > 1) {
    script += plot_margins(plot_width, plot_height,
                           {margins.left, margins.right, plot_height - middle + 8.0, margins.bottom});
    script += "set format x '%g'\n" +
              y_title("minus FEM [px]", plot_width, plot_height, (middle - 8.0 + margins.bottom) / 2.0) +
              x_title("pixel along the line", plot_height) +
              "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead back lw 3 lc rgb \"#b9c0c9\"\n" +
              fmt::format("set yrange {}\nset ytics {:.6g}\n", gaps.range(), gaps.step(4)) +
              plot_lines(lines, "gap", 1);
  }
  return gnuplot_svg(
      script + "unset multiplot\n", prefix,
      fmt::format("{}, scene {}, by every method, and the difference to FEM", path.what, scene.scene));
}

std::string legend_html(const std::vector<Line>& lines) {
  std::string html = "<p class=\"legend\">";
  for (const Line& line : lines) {
    html += fmt::format(
        "<span class=\"key\"><i class=\"stroke\" style=\"border-top:{:.0f}px {} #{}\"></i>{}</span>",
        std::max(2.0, line.width),
        line.dash == 1   ? "solid"
        : line.dash == 2 ? "dashed"
                         : "dotted",
        line.colour, escape(line.name));
  }
  return html + "</p>\n";
}

} // namespace

std::string profile_figure(const AccuracyScene& scene, Anchors& anchors) {
  const std::vector<Line> lines = lines_of(scene);
  if (lines.empty()) {
    return {};
  }
  std::string html = "<figure class=\"wide\">\n" + legend_html(lines) + "<div class=\"figures\">\n";
  for (const Path& path : paths) {
    const std::string id = anchors.unique(fmt::format("profile {} {}", path.name, scene.scene));
    html += fmt::format("<div><div class=\"plot\">{}</div><small>{}</small></div>\n",
                        profile_plot(scene, lines, path, id + '_'), path.what);
  }
  return html +
         fmt::format(
             "</div>\n<figcaption>Displacement along four lines; beneath each its difference to {}, in which "
             "interpolation may run out of the picture.{}</figcaption></figure>\n",
             escape(lines.front().name), thesis_reference(thesis_figures(scene.scene).profiles));
}

} // namespace hdmbench::report
