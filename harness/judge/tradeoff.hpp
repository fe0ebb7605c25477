#pragma once

#include "harness/judge/judge.hpp"
#include "harness/scene/method.hpp"

#include <cstddef>
#include <optional>
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

/// What a result costs and how wrong it is. Any unit of which less is better.
struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

/// The Pareto front: indices of the points that no other point beats, by rising cost and so by falling error.
/// A point beats another where it is no worse in both and better in one; of equal points the first stands for
/// all. What is not finite or negative is no result and neither beats nor stands.
[[nodiscard]] std::vector<std::size_t> pareto_front(std::span<const CostAndError> points);

/// Sets is_on_front of all rows. Only rows of status ok count.
void mark_front(std::vector<Judged>& rows);

/// What reaches an accuracy soonest, as it stands in a result file: {kind: "equal accuracy", scene, title,
/// width, height, poisson, target: RMSD to FEM with Poisson ratio 0, pixels; nearest: the same of the most
/// accurate method; ours: the fastest method at most `target` away; direct, iterative, multigrid, coarse: the
/// fastest rival of finite elements with ratio 0 that is, and the `ratio` of its median to ours}, null what
/// there is not. Rows of status ok count.
[[nodiscard]] nlohmann::json compare_at(const Scene& scene, std::span<const Judged> rows, double target);

} // namespace hdmbench
