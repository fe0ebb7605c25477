#include "harness/report/gnuplot.hpp"

#include "harness/measure/subprocess.hpp"
#include "harness/report/html.hpp"
#include "harness/scene/temporary_directory.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <utility>

namespace hdmbench::report {

namespace {

// A third of what gnuplot writes says nothing: empty groups, defaults, hundredths of a unit, space.
std::string compact(std::string svg) {
  static const std::regex defaults(
      R"( stroke-linecap="butt"| stroke-linejoin="miter"| class="gridline"|<tspan font-family="sans-serif" >|</tspan>)");
  static const std::regex hundredths(R"((\d\.\d)\d(?=[ ,"')]))");
  static const std::regex space(R"(\s*\n\s*)");
  static const std::regex empty_groups(R"(<g [^>]*>\s*</g>)");
  svg = std::regex_replace(svg, defaults, "");
  svg = std::regex_replace(svg, hundredths, "$1");
  svg = std::regex_replace(svg, space, "\n");
  return std::regex_replace(svg, empty_groups, "");
}

} // namespace

std::string gnuplot_text(std::string_view text) {
  std::string result = "'";
  for (const char letter : text) {
    if (letter == '\'') {
      result += "''";
    } else {
      result += static_cast<unsigned char>(letter) < 0x20 ? ' ' : letter;
    }
  }
  return result + '\'';
}

std::string gnuplot_svg_file(const std::string& script) {
  const TemporaryDirectory directory;
  const std::filesystem::path script_file = directory.path() / "plot.gnuplot";
  const std::filesystem::path output = directory.path() / "plot.svg";
  const std::filesystem::path errors = directory.path() / "errors.txt";
  std::ofstream stream(script_file, std::ios::binary);
  stream << script;
  stream.close();
  if (!stream) {
    throw InputError(fmt::format("{}: cannot be written", script_file.string()));
  }

  // Default settings: not the user's own start-up file.
  const ProcessEnd end =
      run_process({"gnuplot", "--default-settings", script_file.string()}, output, errors,
                  {.advice = "It draws the plots: install it (Debian: gnuplot-nox) or put it on PATH."});
  std::string svg = file_text(output);
  if (!end.good() || svg.find("<svg") == std::string::npos || svg.find("</svg>") == std::string::npos) {
    throw InputError(fmt::format("gnuplot failed ({}): {}", end.text(), file_text(errors)));
  }
  return svg;
}

std::string gnuplot_svg(const std::string& script, const std::string& prefix, const std::string& label) {
  std::string svg = gnuplot_svg_file(script);
  svg.erase(0, svg.find("<svg"));

  static const std::regex tool_tips("<(title|desc)>[^<]*</(title|desc)>\\s*");
  static const std::regex namespaces("\\sxmlns(:xlink)?=\"[^\"]*\""); // HTML knows them
  static const std::regex ids("(\\sid=['\"])");
  static const std::regex references("((?:href=['\"]|url\\(\\s*['\"]?)#)");
  svg = std::regex_replace(svg, tool_tips, "");
  svg = std::regex_replace(svg, namespaces, "");
  svg = std::regex_replace(svg, ids, "$1" + prefix);
  svg = std::regex_replace(svg, references, "$1" + prefix);
  svg = compact(std::move(svg));
  svg.insert(4, fmt::format(" role=\"img\" aria-label=\"{}\"", escape(label)));
  return svg;
}

} // namespace hdmbench::report
