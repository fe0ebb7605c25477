#pragma once

#include <string>
#include <string_view>

namespace hdmbench::report {

/// A text as a single-quoted gnuplot string: nothing in it is interpreted; control characters become spaces.
[[nodiscard]] std::string gnuplot_text(std::string_view text);

/// Runs gnuplot on a script that sets the terminal to svg and plots once; returns what it drew, a file of its
/// own. Throws InputError where gnuplot is not installed, with gnuplot's own words where it fails.
[[nodiscard]] std::string gnuplot_svg_file(const std::string& script);

/// The same as an <svg> element to stand inside an HTML page: without prolog and tool tips, every id made
/// unique by `prefix`, `label` (plain text) for screen readers.
[[nodiscard]] std::string gnuplot_svg(const std::string& script, const std::string& prefix,
                                      const std::string& label);

} // namespace hdmbench::report
