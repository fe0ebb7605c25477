#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace hdmbench {

/// Writes one HTML page that needs nothing else: style, plots (SVG by gnuplot) and pictures are inside it.
/// `results` are files that --json wrote, or folders in which all *.json files are taken; picture paths
/// inside them are relative to the JSON file. A newer row replaces an older one of the same command,
/// machine, scene, size, backend, device and mode or method (and, of accuracy, variant and Poisson ratios).
/// Written beside the target and renamed. Throws InputError naming a file that is missing, not JSON, or of
/// another schema, and where gnuplot is missing.
void write_report(std::span<const std::filesystem::path> results, const std::filesystem::path& page);

/// The timings of the same results as a CSV table for the P3 Analysis Library (portability.hpp). Throws as
/// write_report does.
void write_p3_csv(std::span<const std::filesystem::path> results, const std::filesystem::path& file);

/// The same results on a screen of a terminal: agreement, the speed of the first scene at its largest size,
/// accuracy. Throws as write_report does of the files.
[[nodiscard]] std::string summary_text(std::span<const std::filesystem::path> results);

} // namespace hdmbench
