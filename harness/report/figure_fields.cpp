// Whole fields: differences as pictures, deformed grids as lines.

#include "harness/report/accuracy_figures.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace hdmbench::report {

namespace {

// "fem nu 0" as the page says it.
std::string truth_name(const std::string& against) {
  constexpr std::string_view prefix = "fem nu ";
  return against.starts_with(prefix) ? "FEM, ν\u00A0=\u00A0" + against.substr(prefix.size()) : against;
}

std::string picture_html(const AccuracyScene& scene, const std::filesystem::path& file,
                         const std::string& what, const std::string& bar) {
  const EmbeddedPng png = embed_png(file);
  if (png.width != scene.width || png.height != scene.height) {
    throw InputError(fmt::format("{}: has {} x {} pixels, but the image has {} x {} sites", file.string(),
                                 png.width, png.height, scene.width, scene.height));
  }
  return fmt::format("<div><img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}: difference, "
                     "{}\">{}<small>{}</small></div>\n",
                     png.uri, png.width, png.height, escape(scene.scene), what, bar, what);
}

// The ramp itself is in page.css.
std::string colour_bar(const char* css_class, const std::array<std::string, 3>& numbers) {
  return fmt::format(
      "<span class=\"ramp {}\"></span><span class=\"scale\"><span>{}</span><span>{}</span><span>{}</span>"
      "</span>",
      css_class, numbers[0], numbers[1], numbers[2]);
}

struct Box {
  double left = HUGE_VAL;
  double top = HUGE_VAL;
  double right = -HUGE_VAL;
  double bottom = -HUGE_VAL;

  void include(const std::vector<figures::Polyline>& lines) {
    for (const figures::Polyline& line : lines) {
      for (std::size_t i = 0; i < line.size(); i += 2) {
        left = std::min(left, line[i]);
        right = std::max(right, line[i]);
        top = std::min(top, line[i + 1]);
        bottom = std::max(bottom, line[i + 1]);
      }
    }
  }
};

long tenths(double pixels) {
  return std::lround(10.0 * pixels);
}

// Tenths of a pixel as integers; steps between rounded points, so that no error adds up.
std::string path_html(const char* css_class, const std::vector<figures::Polyline>& lines) {
  std::string path;
  for (const figures::Polyline& line : lines) {
    long x = tenths(line[0]);
    long y = tenths(line[1]);
    path += fmt::format("M{} {}l", x, y);
    for (std::size_t i = 2; i < line.size(); i += 2) {
      const long next_x = tenths(line[i]);
      const long next_y = tenths(line[i + 1]);
      path += fmt::format("{}{}{}{}", i > 2 && next_x >= x ? " " : "", next_x - x, next_y >= y ? " " : "",
                          next_y - y);
      x = next_x;
      y = next_y;
    }
  }
  return fmt::format("<path class=\"{}\" d=\"{}\"/>", css_class, path);
}

std::string grid_html(const AccuracyScene& scene, const AccuracyRow& row, const Box& box) {
  const std::string name = escape(method_name(row));
  return fmt::format(
      "<div><svg viewBox=\"{} {} {} {}\" role=\"img\" aria-label=\"{}: deformed grid by {}\">{}{}</svg>"
      "<small>{}</small></div>\n",
      tenths(box.left) - 20, tenths(box.top) - 20, tenths(box.right - box.left) + 40,
      tenths(box.bottom - box.top) + 40, escape(scene.scene), name, path_html("lines", row.grid->lines),
      path_html("interfaces", row.interfaces), name);
}

} // namespace

std::string difference_figure(const AccuracyScene& scene) {
  const AccuracyRow* const row =
      scene.first([](const AccuracyRow& other) { return other.differences.has_value(); });
  if (row == nullptr) {
    return {};
  }
  const Differences& differences = *row->differences;
  const std::string limit = fmt::format("{:.3g}", differences.limit);
  const std::string half = fmt::format("{:.3g}", differences.limit / 2.0);
  const std::string positive = colour_bar("magnitude", {"0", half, limit + " px"});
  const std::string both = colour_bar("signed", {"−" + limit, "0", "+" + limit + " px"});
  return "<figure class=\"wide\">\n<div class=\"fields\">\n" +
         picture_html(scene, scene.path_of(*row, differences.pictures.magnitude), "magnitude", positive) +
         picture_html(scene, scene.path_of(*row, differences.pictures.x), "x component", both) +
         picture_html(scene, scene.path_of(*row, differences.pictures.y), "y component", both) +
         fmt::format("</div>\n<figcaption>{} minus {}, a pixel per site: bright or coloured is where the two "
                     "differ, and "
                     "the colour ends at {} px.{}</figcaption></figure>\n",
                     escape(method_name(*row)), escape(truth_name(differences.against)), limit,
                     thesis_reference(thesis_figures(scene.scene).differences));
}

std::string grid_figure(const AccuracyScene& scene) {
  std::vector<const AccuracyRow*> rows;
  Box box;
  for (const char* const method : {"icm", "fem", "b-spline"}) {
    if (const AccuracyRow* const row = scene.first([&](const AccuracyRow& other) {
          return other.method == method && other.variant.empty() && other.grid.has_value();
        })) {
      rows.push_back(row);
      box.include(row->grid->lines);
      box.include(row->interfaces);
    }
  }
  if (rows.empty()) {
    return {};
  }
  std::string html = "<figure class=\"wide\">\n<div class=\"fields grids\">\n";
  for (const AccuracyRow* const row : rows) {
    html += grid_html(scene, *row, box);
  }
  return html +
         fmt::format(
             "</div>\n<figcaption>A grid of {:.4g} px, deformed; coloured are the deformed interfaces of the "
             "materials. A method that knows the materials bends the lines there.{}</figcaption></figure>\n",
             rows.front()->grid->spacing, thesis_reference(thesis_figures(scene.scene).grids));
}

} // namespace hdmbench::report
