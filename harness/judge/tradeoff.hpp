#pragma once

#include "harness/judge/judge.hpp"
#include "harness/scene/method.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// The method name of rows for which an accuracy was requested (harness/solve/planner.hpp).
inline constexpr std::string_view requested_name = "as-needed-elastic";

struct TradeoffOptions {
  SessionOptions session{};
  int repeats = 3;                    ///< samples per row, fewer where they take long
  std::vector<std::string> methods{}; ///< names of methods and rivals; empty: all
  bool quick = false;                 ///< fewer efforts, one sample
};

/// Every method at all its efforts on Where::main_place and at its usual effort on the other backends, what
/// `run --accuracy` gives, and every rival: rows by method, effort and backend, then rivals. The first
/// backend is the reference for bits. What fails is a row with the reason. Throws InputError for an unknown
/// method and as find_truths does.
[[nodiscard]] std::vector<Judged> measure_tradeoff(const Scene& scene,
                                                   std::span<const Backend* const> backends,
                                                   const TradeoffOptions& options, Progress& progress);

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
