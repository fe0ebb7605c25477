#pragma once

#include "harness/measure/result_file.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <span>
#include <string>

namespace hdmbench {

/// One self-contained HTML page that runs these scenes on a browser's GPU, as the thesis's fragment shader,
/// beside scalar compiled to WebAssembly, and compares them at every site after every sweep. Every level gets
/// the iterations that its schedule has at most. Throws InputError for a scene that a one-way pyramid does
/// not solve or whose sites move in sequence.
[[nodiscard]] std::string browser_page(std::span<const Scene> scenes, const Context& context,
                                       Progress& progress);

} // namespace hdmbench
