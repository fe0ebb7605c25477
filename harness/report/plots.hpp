#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hdmbench::report {

/// One quantity of one backend, one entry per image size.
struct SizeSeries {
  struct Size {
    std::int64_t width = 0;
    std::int64_t height = 0;
    double value = 0.0;          ///< > 0
    std::vector<double> samples; ///< > 0; empty where there are none to show
  };
  std::string name;
  bool published = false; ///< drawn dashed and grey
  bool active = false;    ///< drawn dotted, in the colour of the dense one
  std::size_t colour = 0; ///< the same number is the same colour in every plot
  std::vector<Size> sizes;
};

/// A quantity over pixels, both logarithmic, every sample a faint point, the values a line named at its end.
/// An inline <svg>, see gnuplot_svg. `series` must hold at least one size.
[[nodiscard]] std::string size_plot(const std::vector<SizeSeries>& series, const std::string& quantity,
                                    const std::string& prefix, const std::string& label);

} // namespace hdmbench::report
