#include "harness/tools/energy_plane.hpp"

#include "harness/report/html.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>

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

constexpr double left = 80.0;
constexpr double top = 56.0;
constexpr double side = 520.0; ///< of the square that is drawn
constexpr int bands = 24;      ///< of energy, which stand for contour lines

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

std::string rectangle(double x, double y, double width, double height, int band) {
  return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", x,
                     y, width, height, colour_of(band));
}

/// The energy of every pair, cells of one band in a row as one.
std::string cells(const EnergyPlane& plane, double lowest, double highest) {
  const auto count = plane.values.size();
  const double cell = side / static_cast<double>(count);
  std::string svg = "<g shape-rendering=\"crispEdges\">\n";
  for (std::size_t second = 0; second < count; ++second) {
    int band_before = -1;
    for (std::size_t first = count; first-- > 0;) { // each is drawn from the left side on, over those before
      const double share = highest > lowest ? (plane.at(first, second) - lowest) / (highest - lowest) : 0.0;
      const int band = std::min(bands - 1, static_cast<int>(std::sqrt(share) * bands));
      if (band != band_before) {
        svg += rectangle(left, top + side - cell * static_cast<double>(second + 1),
                         cell * static_cast<double>(first + 1), cell, band);
      }
      band_before = band;
    }
  }
  return svg + "</g>\n";
}

std::string words(double x, double y, std::string_view anchor, std::string_view text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                     report::escape(text));
}

} // namespace

void require_sites(const std::array<SiteIndex, 2>& sites, Extent extent) {
  for (const SiteIndex site : sites) {
    if (site.x < 0 || site.x >= extent.width || site.y < 0 || site.y >= extent.height) {
      throw InputError(fmt::format("there is no site {},{} in an image of {} x {} pixels", site.x, site.y,
                                   extent.width, extent.height));
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
  auto& component = options.component == Component::x ? displacement.x : displacement.y;
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
  const double low = static_cast<double>(plane.values.front());
  const double high = static_cast<double>(plane.values.back());
  const double cell = side / static_cast<double>(plane.values.size());
  const auto along = [&](double value) { return cell / 2.0 + (value - low) / (high - low) * (side - cell); };
  const auto axis = [&](SiteIndex site) {
    return fmt::format("{} displacement of site {},{} [px]", options.component == Component::x ? 'x' : 'y',
                       site.x, site.y);
  };
  const double lowest = plane.energy[plane.lowest];
  const double highest = std::ranges::max(plane.energy);
  std::string svg =
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 640\" font-family=\"sans-serif\" "
      "font-size=\"14\">\n<rect width=\"760\" height=\"640\" fill=\"#fff\"/>\n";
  svg += words(left + side / 2.0, 22.0, "middle", title) + cells(plane, lowest, highest);
  for (const double value : {low, (low + high) / 2.0, high}) {
    svg += words(left + along(value), top + side + 18.0, "middle", fmt::format("{:.4g}", value)) +
           words(left - 6.0, top + side - along(value) + 5.0, "end", fmt::format("{:.4g}", value));
  }
  svg += words(left + side / 2.0, top + side + 42.0, "middle", axis(options.sites[0]));
  svg += fmt::format("<g transform=\"translate(22 {}) rotate(-90)\">{}</g>\n", top + side / 2.0,
                     words(0.0, 0.0, "middle", axis(options.sites[1])));
  for (int band = 0; band < bands; ++band) {
    svg += rectangle(left + side + 24.0, top + side * (bands - 1 - band) / bands, 20.0, side / bands + 0.5,
                     band);
  }
  svg += words(left + side + 50.0, top + 12.0, "start", fmt::format("{:.4g}", highest)) +
         words(left + side + 50.0, top + side, "start", fmt::format("{:.4g}", lowest)) +
         words(left + side + 24.0, top - 8.0, "start", "total energy U");
  const auto mark = [&](double first, double second, std::string_view path, std::string_view colour) {
    return fmt::format("<path transform=\"translate({:.2f} {:.2f})\" d=\"{}\" fill=\"none\" stroke=\"{}\" "
                       "stroke-width=\"2.5\"/>\n",
                       first, second, path, colour);
  };
  constexpr std::string_view circle = "M-7 0a7 7 0 1 0 14 0a7 7 0 1 0-14 0";
  constexpr std::string_view cross = "M-6-6L6 6M-6 6L6-6";
  const auto is_inside = [&](double value) { return value >= low && value <= high; };
  if (is_inside(double{here[0]}) && is_inside(double{here[1]})) {
    svg += mark(left + along(double{here[0]}), top + side - along(double{here[1]}), circle, "#ff9a3c") +
           mark(left + 20.0, 42.0, circle, "#ff9a3c") +
           words(left + 34.0, 47.0, "start", "the field as it is");
  }
  return svg +
         mark(left + along(double{plane.lowest_first()}), top + side - along(double{plane.lowest_second()}),
              cross, "#ff3b4e") +
         mark(left + 220.0, 42.0, cross, "#ff3b4e") +
         words(left + 234.0, 47.0, "start", "lowest on the grid") + "</svg>\n";
}

} // namespace hdmbench
