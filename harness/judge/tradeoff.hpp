#pragma once

#include "harness/judge/judge.hpp"
#include "harness/scene/method.hpp"

#include <span>
#include <string_view>
#include <vector>

namespace hdmbench {

/// The method name of rows for which an accuracy was requested (harness/solve/planner.hpp).
inline constexpr std::string_view requested_name = "as-needed-elastic";
/// The variant of rows that have the linear law in place of a scene's laws of large strains.
inline constexpr const char* linear_law = "linear law";

/// Rivals, then every method of the scene's energy on every backend, in both designs of the thesis. The first
/// backend is the reference for bits; it also runs the sequential method. Throws InputError as find_truths
/// does, and where a picture cannot be written; a backend that is not there becomes a row without result.
[[nodiscard]] std::vector<Judged> measure_accuracy(const Scene& scene,
                                                   std::span<const Backend* const> backends,
                                                   const JudgeOptions& options, Progress& progress);

/// A sheet with a round inclusion, whose displacement is known in closed form
/// (reference/round_inclusion.hpp) and prescribed on the border, on meshes of pixels: a row {energy,
/// width, height, contrast: modulus of the inclusion over that around it, poisson, stretch: how much longer
/// the image gets, pixels, backend, device, method: that of `algebraic`} for each side, and four distances
/// {rmsd, largest of any site} in pixels: `discretisation`, of finite elements on the pixels (direct, double)
/// from the closed form; `algebraic`, of our field from these; `rounding`, of our field when no step changes
/// it any more (float32) from these; `total`, of our field from the closed form. From the second row on
/// `order`, that of discretisation.rmsd in the width since the first one. Sides rise and are 8 pixels at
/// least. Throws InputError, and what a session throws.
[[nodiscard]] nlohmann::json measure_continuum(double contrast, std::span<const int> sides,
                                               const Backend& backend, const SessionOptions& options,
                                               Progress& progress);

/// Every method at all its efforts on Where::main_place and at its usual effort on the other backends, what
/// `run --accuracy` gives, and every rival: rows by method, effort and backend, then rivals. The first
/// backend is the reference for bits. What fails is a row with the reason. A scene that is_of_tissue() gets
/// the elastic energy's alone. Throws InputError for an unknown method and as find_truths does.
[[nodiscard]] std::vector<Judged> measure_tradeoff(const Scene& scene,
                                                   std::span<const Backend* const> backends,
                                                   const JudgeOptions& options, Progress& progress);

/// Sets is_on_front of all rows: whether no other is both as fast, by the median, and as near to finite
/// elements with Poisson ratio 0, and better in one. Of equal rows the first stands for all. Rows of status
/// ok count, and of these not what is not finite.
void mark_front(std::vector<Judged>& rows);

/// What reaches an accuracy soonest, as it stands in a result file: {kind: "equal accuracy", scene, title,
/// width, height, poisson, target: RMSD to FEM with Poisson ratio 0, pixels; nearest: the same of the most
/// accurate method; ours: the fastest method at most `target` away; direct, iterative, multigrid, coarse: the
/// fastest rival of finite elements with ratio 0 that is, and the `ratio` of its median to ours}, null what
/// there is not. Rows of status ok count.
[[nodiscard]] nlohmann::json compare_at(const Scene& scene, std::span<const Judged> rows, double target);

} // namespace hdmbench
