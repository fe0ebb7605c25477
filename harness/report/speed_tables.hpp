#pragma once

#include "harness/report/html.hpp"
#include "harness/report/timings.hpp"

#include <string>
#include <vector>

/// What is to be said about all scenes of one machine together. Each is empty where the results do not have
/// it; `level` is that of the heading.
namespace hdmbench::report {

/// How long the thesis's fragment shader takes beside compute shaders on the same GL, dense: a <p>.
[[nodiscard]] std::string legacy_sentence(const std::vector<SceneTimings>& scenes);

/// Per scene, size and backend: how many times as fast as dense it is to leave out what cannot change.
[[nodiscard]] std::string active_table(const std::vector<SceneTimings>& scenes, int level, Anchors& anchors);

/// How many times as fast the backends become with more threads, with the line of as many times as threads: a
/// <figure> of the scene's largest size that was timed with several numbers of threads. Empty where none was.
[[nodiscard]] std::string scaling_figure(const Results& results, const std::string& machine,
                                         const std::string& scene, Anchors& anchors);

/// Per backend: bytes and operations of a site update, their rates, and the share of the ceiling that binds.
/// The first scene that has them, at its largest size; the others folded away.
[[nodiscard]] std::string ceilings_table(const std::vector<SceneTimings>& scenes, int level,
                                         Anchors& anchors);

} // namespace hdmbench::report
