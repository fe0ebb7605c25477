#pragma once

#include "harness/report/results.hpp"

#include <string>

namespace hdmbench::report {

/// Error over knob, a line per series, the limit dashed; logarithmic where values span much. Errors beyond a
/// thousand times the limit are drawn there. An inline <svg>, see gnuplot_svg; empty without points.
[[nodiscard]] std::string atlas_figure(const AtlasRow& row, const std::string& prefix);

} // namespace hdmbench::report
