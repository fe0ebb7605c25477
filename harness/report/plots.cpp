#include "harness/report/plots.hpp"

#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 460.0; // SVG units, as are all lengths here
constexpr double plot_height = 430.0;
constexpr double left_margin = 66.0;
constexpr double top_margin = 12.0;
constexpr double bottom_margin = 48.0;

struct Range {
  double low = HUGE_VAL;
  double high = 0.0;

  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void widen(double factor) {
    low /= factor;
    high *= factor;
  }
  // 0 ... 1 on the logarithmic axis
  [[nodiscard]] double position(double value) const { return std::log(value / low) / std::log(high / low); }
};

double pixels(const SizeSeries::Size& size) {
  return static_cast<double>(size.width) * static_cast<double>(size.height);
}

std::string shortened(const std::string& name) {
  constexpr std::size_t longest = 30;
  if (name.size() <= longest) {
    return name;
  }
  std::size_t end = longest - 1;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) {
    --end; // not in the middle of a UTF-8 character
  }
  return name.substr(0, end) + "…";
}

struct EndLabel {
  std::size_t series = 0;
  double position = 0.0; // fraction of the axis height, from the bottom
};

// Moves labels apart that would overlap: those that touch become a stack around the mean of where they
// belong.
void spread(std::vector<EndLabel>& labels, double gap) {
  struct Stack {
    std::size_t first = 0;
    std::size_t count = 0;
    double wanted = 0.0; // sum over its labels of the position where each wants the lowest one of the stack

    [[nodiscard]] double low() const { return wanted / static_cast<double>(count); }
  };
  std::ranges::stable_sort(labels, {}, &EndLabel::position);
  std::vector<Stack> stacks;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    Stack stack{i, 1, labels[i].position};
    while (!stacks.empty() &&
           stack.low() < stacks.back().low() + gap * static_cast<double>(stacks.back().count)) {
      const Stack below = stacks.back();
      stacks.pop_back();
      stack = {below.first, below.count + stack.count,
               below.wanted + stack.wanted - gap * static_cast<double>(below.count * stack.count)};
    }
    stacks.push_back(stack);
  }
  for (const Stack& stack : stacks) {
    for (std::size_t i = 0; i < stack.count; ++i) {
      labels[stack.first + i].position = stack.low() + gap * static_cast<double>(i);
    }
  }
}

std::string size_tics(const std::vector<SizeSeries>& series, const Range& x, double axis_width) {
  std::map<double, std::string> names;
  for (const SizeSeries& line : series) {
    for (const SizeSeries::Size& size : line.sizes) {
      names[pixels(size)] = size.width == size.height ? fmt::format("{}²", size.width)
                                                      : fmt::format("{}×{}", size.width, size.height);
    }
  }
  std::string tics;
  double end = -HUGE_VAL; // of the last name
  for (const auto& [position, name] : names) {
    const double half = 0.5 * 0.6 * plot_font_size * static_cast<double>(name.size());
    const double middle = axis_width * x.position(position);
    const bool fits = middle - half > end + 3.0;
    tics += fmt::format("{}{} {}", tics.empty() ? "" : ", ", gnuplot_text(fits ? name : ""), position);
    end = fits ? middle + half : end;
  }
  return tics;
}

std::string colour_of(const SizeSeries& line) {
  return line.published ? "6e6e6e" : plot_colours.at(line.colour % plot_colours.size());
}

int dashes(const SizeSeries& line) {
  return line.published ? 2 : line.active ? 3 : 1;
}

std::string data_blocks(const std::vector<SizeSeries>& series) {
  std::string blocks;
  for (std::size_t i = 0; i < series.size(); ++i) {
    std::string samples;
    std::string values;
    for (const SizeSeries::Size& size : series[i].sizes) {
      values += fmt::format("{} {}\n", pixels(size), size.value);
      for (const double sample : size.samples) {
        samples += fmt::format("{} {}\n", pixels(size), sample);
      }
    }
    blocks += fmt::format("$values{0} << END\n{1}END\n$samples{0} << END\n{2}END\n", i, values, samples);
  }
  return blocks;
}

std::string plot_command(const std::vector<SizeSeries>& series) {
  std::string command = "plot ";
  for (std::size_t i = 0; i < series.size(); ++i) {
    const SizeSeries& line = series[i];
    const bool sampled =
        std::ranges::any_of(line.sizes, [](const auto& size) { return !size.samples.empty(); });
    command += i == 0 ? "" : ", ";
    if (sampled) {
      command += fmt::format("$samples{} using 1:2 with points pt 7 ps 0.55 lc rgb \"#a8{}\" notitle, ", i,
                             colour_of(line));
    }
    command +=
        fmt::format("$values{} using 1:2 with linespoints lw 1.5 dt {} pt 7 ps 0.4 lc rgb \"#{}\" notitle", i,
                    dashes(line), colour_of(line));
  }
  return command + '\n';
}

} // namespace

std::string size_plot(const std::vector<SizeSeries>& series, const std::string& quantity,
                      const std::string& prefix, const std::string& label) {
  Range x;
  Range y;
  std::size_t longest_name = 0;
  for (const SizeSeries& line : series) {
    longest_name = std::max(longest_name, shortened(line.name).size());
    for (const SizeSeries::Size& size : line.sizes) {
      x.include(pixels(size));
      y.include(size.value);
      std::ranges::for_each(size.samples, [&](double sample) { y.include(sample); });
    }
  }
  x.widen(1.25);
  y.widen(1.5);

  // Sans-serif letters are on average about 0.54 of the font size wide.
  const double right_margin = 14.0 + 0.54 * plot_font_size * static_cast<double>(longest_name);
  const double axis_height = plot_height - top_margin - bottom_margin;
  std::vector<EndLabel> labels;
  for (std::size_t i = 0; i < series.size(); ++i) {
    const auto last = std::ranges::max_element(series[i].sizes, {}, pixels);
    labels.push_back({i, y.position(last->value)});
  }
  spread(labels, 1.15 * plot_font_size / axis_height);

  std::string script =
      plot_start(plot_width, plot_height) +
      plot_margins(plot_width, plot_height, {left_margin, right_margin, top_margin, bottom_margin}) +
      x_title("pixels", plot_height) +
      y_title(quantity, plot_width, plot_height, bottom_margin + axis_height / 2.0) +
      fmt::format("set logscale xy\nset xrange [{}:{}]\nset yrange [{}:{}]\nset xtics ({})\n", x.low, x.high,
                  y.low, y.high, size_tics(series, x, plot_width - left_margin - right_margin));
  for (const EndLabel& end : labels) {
    script += fmt::format("set label {} at graph 1.02, graph {} noenhanced textcolor rgb \"#{}\"\n",
                          gnuplot_text(shortened(series[end.series].name)), end.position,
                          colour_of(series[end.series]));
  }
  return gnuplot_svg(script + data_blocks(series) + plot_command(series), prefix, label);
}

} // namespace hdmbench::report
