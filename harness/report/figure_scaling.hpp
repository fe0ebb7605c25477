#pragma once

#include "harness/report/html.hpp"
#include "harness/report/results.hpp"

#include <string>

namespace hdmbench::report {

/// How many times as fast the backends become with more threads, with the line of as many times as threads: a
/// <figure> of the scene's largest size that was timed with several numbers of threads. Empty where none was.
[[nodiscard]] std::string scaling_figure(const Results& results, const std::string& machine,
                                         const std::string& scene, Anchors& anchors);

} // namespace hdmbench::report
