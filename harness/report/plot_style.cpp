#include "harness/report/plot_style.hpp"

#include "harness/report/gnuplot.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::report {

std::string plot_start(double width, double height) {
  return fmt::format("set encoding utf8\n"
                     "set terminal svg size {},{} dynamic font \"sans-serif,{}\" background \"#ffffff\"\n"
                     "set border 3 lc rgb \"#8a8f98\"\nset format y \"%g\"\n"
                     "set tics nomirror scale 0.6,0.3 textcolor rgb \"#{}\"\n"
                     "set grid xtics ytics lt 1 lw 0.6 lc rgb \"#e3e5e8\"\n",
                     width, height, plot_font_size, text_colour);
}

std::string plot_margins(double width, double height, const Margins& margins) {
  return fmt::format("set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {}\n"
                     "set bmargin at screen {}\n",
                     margins.left / width, 1.0 - margins.right / width, 1.0 - margins.top / height,
                     margins.bottom / height);
}

std::string y_title(std::string_view text, double width, double height, double from_bottom) {
  return fmt::format("set label 1 {} at screen {}, screen {} center rotate textcolor rgb \"#{}\"\n",
                     gnuplot_text(text), 12.0 / width, from_bottom / height, text_colour);
}

std::string x_title(std::string_view text, double height) {
  return fmt::format("set label 2 {} at graph 0.5, screen {} center textcolor rgb \"#{}\"\n",
                     gnuplot_text(text), 11.0 / height, text_colour);
}

void Interval::include(double value) {
  if (std::isfinite(value)) {
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
}

void Interval::include(std::span<const double> values) {
  std::ranges::for_each(values, [&](double value) { include(value); });
}

std::string Interval::range() const {
  if (empty()) {
    return "[0:1]";
  }
  const double length = high_ - low_;
  const double margin = length > 0.0 ? 0.05 * length : std::max(0.1 * std::abs(high_), 1e-9);
  return fmt::format("[{:.6g}:{:.6g}]", low_ - margin, high_ + margin);
}

double Interval::step(int count) const {
  const double wanted = empty() || high_ <= low_ ? 1.0 : (high_ - low_) / count;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= wanted) {
      return factor * decade;
    }
  }
  return 10.0 * decade;
}

std::string data_block(std::string_view name, std::span<const double> x, std::span<const double> y) {
  std::string block = fmt::format("${} << END\n", name);
  for (std::size_t i = 0; i < x.size(); ++i) {
    block += std::isfinite(y[i]) ? fmt::format("{:.6g} {:.6g}\n", x[i], y[i]) : std::string("\n");
  }
  return block + "END\n";
}

} // namespace hdmbench::report
