#include "harness/tools/energy_plot.hpp"

#include "harness/report/gnuplot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

namespace hdmbench {

namespace {

std::string axis_title(SiteIndex site, Component component) {
  return fmt::format("{} displacement of site {},{} [px]", component == Component::x ? 'x' : 'y', site.x,
                     site.y);
}

/// One line per point, an empty line after each row, as splot wants it.
std::string data_block(const EnergyPlane& plane) {
  std::string block = "$energy << END\n";
  for (std::size_t second = 0; second < plane.values.size(); ++second) {
    for (std::size_t first = 0; first < plane.values.size(); ++first) {
      block += fmt::format("{} {} {}\n", plane.values[first], plane.values[second], plane.at(first, second));
    }
    block += '\n';
  }
  return block + "END\n";
}

/// Levels that lie denser towards the lowest energy, as the colours do: a trough is flat, the rim steep.
std::string contour_levels(const EnergyPlane& plane) {
  constexpr int count = 12;
  const double low = plane.energy[plane.lowest];
  const double height = std::ranges::max(plane.energy) - low;
  std::string levels;
  for (int i = 1; i < count; ++i) {
    const double fraction = double(i) / count;
    levels += fmt::format("{}{}", i > 1 ? "," : "", low + height * fraction * fraction);
  }
  return levels;
}

/// Without it browsers smooth the cells' edges, which shows as a grid of hairlines.
std::string with_crisp_cells(const std::string& svg) {
  static const std::regex cells("<polygon ");
  return std::regex_replace(svg, cells, "<polygon shape-rendering=\"crispEdges\" ");
}

} // namespace

std::string energy_plot_svg(const EnergyPlane& plane, const EnergyPlaneOptions& options,
                            std::array<float, 2> here, const std::string& title) {
  using report::gnuplot_text;
  const double low = static_cast<double>(plane.values.front());
  const double high = static_cast<double>(plane.values.back());
  const double half_cell = 0.5 * (high - low) / static_cast<double>(plane.values.size() - 1);
  const auto is_inside = [&](float value) {
    return value >= plane.values.front() && value <= plane.values.back();
  };
  std::string script = fmt::format(
      "set encoding utf8\n"
      "set terminal svg size 760,640 dynamic name \"hdmbench\" font \"sans-serif,14\" background "
      "\"#ffffff\"\n"
      "set title {} noenhanced\nset xlabel {} noenhanced\nset ylabel {} noenhanced\n"
      "set cblabel {} noenhanced\n"
      "set size ratio 1\nset xrange [{}:{}]\nset yrange [{}:{}]\nset tics out nomirror\nset cbtics format "
      "\"%g\"\n"
      "set palette defined (0 '#0b1d51', 0.0625 '#1f5f9e', 0.25 '#4fa7a8', 0.5625 '#c7d88a', 1 '#fff7c2')\n"
      "set key outside top center horizontal noenhanced\n",
      gnuplot_text(title), gnuplot_text(axis_title(options.sites[0], options.component)),
      gnuplot_text(axis_title(options.sites[1], options.component)), gnuplot_text("total energy U"),
      low - half_cell, high + half_cell, low - half_cell, high + half_cell);
  const double lowest = plane.energy[plane.lowest];
  const double highest = std::ranges::max(plane.energy);
  if (highest > lowest) {
    script += fmt::format("set cbrange [{}:{}]\n", lowest, highest);
  }
  script += data_block(plane);
  script += fmt::format("set contour base\nset cntrparam levels discrete {}\nunset surface\n"
                        "set table $lines\nsplot $energy using 1:2:3\nunset table\n",
                        contour_levels(plane));
  script += fmt::format("$lowest << END\n{} {}\nEND\n", plane.lowest_first(), plane.lowest_second());
  script += fmt::format("$here << END\n{} {}\nEND\n", here[0], here[1]);
  script += "plot $energy using 1:2:3 with image pixels notitle, "
            "$lines using 1:2 with lines lw 0.8 lc rgb '#66ffffff' notitle, ";
  if (is_inside(here[0]) && is_inside(here[1])) {
    script += "$here using 1:2 with points pt 6 ps 1.6 lw 2.5 lc rgb '#ff9a3c' title 'the field as it is', ";
  }
  script += "$lowest using 1:2 with points pt 2 ps 1.2 lw 2.5 lc rgb '#ff3b4e' title 'lowest on the grid'\n";
  return with_crisp_cells(report::gnuplot_svg_file(script));
}

} // namespace hdmbench
