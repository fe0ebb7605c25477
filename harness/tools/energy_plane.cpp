#include "harness/tools/thesis_tools.hpp"

#include "harness/report/html.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hdmbench {

namespace {

double site_energy(const ThesisEnergy& energy, SiteIndex site) {
  const ThesisEnergy::Value value = energy.at(site.x, site.y);
  return value.x + value.y;
}

void require_range(const EnergyPlaneOptions& options) {
  const bool finite =
      std::isfinite(static_cast<float>(options.low)) && std::isfinite(static_cast<float>(options.high));
  if (!(options.low < options.high) || !finite) {
    throw InputError(
        fmt::format("the range {} ... {} pixels is empty or not finite", options.low, options.high));
  }
  if (options.points < 2) {
    throw InputError(fmt::format("{} points are too few, at least 2 are needed", options.points));
  }
}

constexpr int bands = 24; ///< of energy, which stand for contour lines

/// Bands lie denser towards the lowest energy: a trough is flat, the rim steep.
std::string colour_of(int band) {
  constexpr std::array<std::array<double, 3>, 5> palette{
      {{11, 29, 81}, {31, 95, 158}, {79, 167, 168}, {199, 216, 138}, {255, 247, 194}}};
  const double at = double(band) / (bands - 1) * (palette.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(at), palette.size() - 2);
  const auto mix = [&](std::size_t i) {
    return static_cast<int>(
        std::lerp(palette[first][i], palette[first + 1][i], at - static_cast<double>(first)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2));
}

/// The energy of every pair as squares of side 1, those of one band in a row as one.
std::string cells(const EnergyPlane& plane, double lowest, double highest) {
  std::string svg;
  for (std::size_t second = 0; second < plane.values.size(); ++second) {
    int band_before = -1;
    for (std::size_t first = plane.values.size(); first-- > 0;) { // from the left side on, over those before
      const double share = highest > lowest ? (plane.at(first, second) - lowest) / (highest - lowest) : 0.0;
      const int band = std::min(bands - 1, static_cast<int>(std::sqrt(share) * bands));
      if (band != band_before) {
        svg += fmt::format("<rect y=\"{}\" width=\"{}\" height=\"1\" fill=\"{}\"/>\n", second, first + 1,
                           colour_of(band));
      }
      band_before = band;
    }
  }
  return svg;
}

std::string words(double x, double y, std::string_view text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x, y, report::escape(text));
}

} // namespace

void require_sites(const std::array<SiteIndex, 2>& sites, Extent extent) {
  for (const SiteIndex site : sites) {
    if (site.x < 0 || site.x >= extent.width || site.y < 0 || site.y >= extent.height) {
      throw InputError(
          fmt::format("there is no site {},{} in an image of {} pixels", site.x, site.y, extent.text()));
    }
  }
  if (sites[0] == sites[1]) {
    throw InputError(
        fmt::format("the site {},{} is given twice, two different ones are needed", sites[0].x, sites[0].y));
  }
}

double total_energy(const Level& level, const VectorField& displacement) {
  const ThesisEnergy energy(level, displacement);
  double sum = 0.0;
  for_each_site(level.extent, [&](int x, int y) { sum += site_energy(energy, {x, y}); });
  return sum;
}

EnergyPlane energy_plane(const Level& level, VectorField displacement, const EnergyPlaneOptions& options) {
  require_sites(options.sites, level.extent);
  require_range(options);
  const ThesisEnergy energy(level, displacement);
  const auto sees = [&](SiteIndex site) {
    return std::ranges::any_of(options.sites, [&](SiteIndex moved) {
      return std::abs(moved.x - site.x) <= 1 && std::abs(moved.y - site.y) <= 1;
    });
  };
  std::vector<SiteIndex> affected;
  double constant = 0.0;
  for_each_site(level.extent, [&](int x, int y) {
    if (sees({x, y})) {
      affected.push_back({x, y});
    } else {
      constant += site_energy(energy, {x, y});
    }
  });

  EnergyPlane plane;
  for (int i = 0; i < options.points; ++i) {
    plane.values.push_back(
        static_cast<float>(std::lerp(options.low, options.high, double(i) / (options.points - 1))));
  }
  std::vector<float>& component = displacement[options.axis];
  float& first = component[level.extent.index(options.sites[0].x, options.sites[0].y)];
  float& second = component[level.extent.index(options.sites[1].x, options.sites[1].y)];
  plane.energy.reserve(plane.values.size() * plane.values.size());
  for (const float value_of_second : plane.values) {
    for (const float value_of_first : plane.values) {
      first = value_of_first;
      second = value_of_second;
      double sum = constant;
      for (const SiteIndex site : affected) {
        sum += site_energy(energy, site);
      }
      plane.energy.push_back(sum);
    }
  }
  plane.lowest = static_cast<std::size_t>(std::ranges::min_element(plane.energy) - plane.energy.begin());
  return plane;
}

std::string energy_plot_svg(const EnergyPlane& plane, const EnergyPlaneOptions& options,
                            std::array<float, 2> here, const std::string& title) {
  constexpr double left = 100.0; // of the square that is drawn
  constexpr double bottom = 590.0;
  constexpr double side = 520.0;
  const auto count = static_cast<double>(plane.values.size());
  const double low = static_cast<double>(plane.values.front());
  const double high = static_cast<double>(plane.values.back());
  const double lowest = plane.energy[plane.lowest];
  const double highest = std::ranges::max(plane.energy);
  const auto in_cells = [&](double value) { return 0.5 + (value - low) / (high - low) * (count - 1.0); };
  const auto ring = [&](float first, float second, std::string_view colour) {
    const bool is_inside =
        std::min(first, second) >= plane.values.front() && std::max(first, second) <= plane.values.back();
    return is_inside ? fmt::format("<circle cx=\"{:.3f}\" cy=\"{:.3f}\" r=\"{}\" fill=\"none\" stroke=\"{}\" "
                                   "stroke-width=\"{}\"/>\n",
                                   in_cells(double{first}), in_cells(double{second}), count / 60.0, colour,
                                   count / 200.0)
                     : std::string();
  };
  const auto axis = [&](SiteIndex site) {
    return fmt::format("{} displacement of site {},{} [px]", "xy"[options.axis], site.x, site.y);
  };
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 660 650\" font-family=\"sans-serif\" "
      "font-size=\"14\" text-anchor=\"middle\">\n<rect width=\"660\" height=\"650\" fill=\"#fff\"/>\n"
      "<g transform=\"translate({} {}) scale({} -{})\" shape-rendering=\"crispEdges\">\n{}</g>\n"
      "<g transform=\"translate({} {}) scale({} -{})\">\n{}{}</g>\n",
      left, bottom, side / count, side / count, cells(plane, lowest, highest), left, bottom, side / count,
      side / count, ring(here[0], here[1], "#ff9a3c"),
      ring(plane.lowest_first(), plane.lowest_second(), "#ff3b4e"));
  svg += words(left + side / 2.0, 22.0, title) +
         words(left + side / 2.0, 42.0,
               fmt::format("total energy U, dark {:.4g} ... light {:.4g}; red: lowest on the grid, orange: "
                           "as it is",
                           lowest, highest));
  for (const double value : {low, (low + high) / 2.0, high}) {
    const double along = in_cells(value) * side / count;
    svg += words(left + along, bottom + 18.0, fmt::format("{:.4g}", value)) +
           words(left - 26.0, bottom - along + 5.0, fmt::format("{:.4g}", value));
  }
  return svg + words(left + side / 2.0, bottom + 42.0, axis(options.sites[0])) +
         fmt::format("<g transform=\"translate(22 {}) rotate(-90)\">{}</g>\n</svg>\n", bottom - side / 2.0,
                     words(0.0, 0.0, axis(options.sites[1])));
}

} // namespace hdmbench
