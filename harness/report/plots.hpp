#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hdmbench::report {

/// All times of one backend, one entry per image size.
struct TimeSeries {
  struct Size {
    std::int64_t width = 0;
    std::int64_t height = 0;
    double median = 0.0;         ///< seconds, > 0
    std::vector<double> samples; ///< seconds, > 0; empty for published figures
  };
  std::string name;
  bool published = false; ///< drawn dashed and grey
  std::size_t colour = 0; ///< the same number is the same colour in every plot
  std::vector<Size> sizes;
};

/// Seconds over pixels, both logarithmic, every sample a faint point, the medians a line named at its end.
/// An inline <svg>, see gnuplot_svg. `series` must hold at least one size.
[[nodiscard]] std::string time_plot(const std::vector<TimeSeries>& series, const std::string& prefix,
                                    const std::string& label);

} // namespace hdmbench::report
