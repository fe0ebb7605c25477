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

/// The settings a method is measured at on an image, rising, its usual effort among them unless quick.
/// `own_iterations` are the scene's, the usual effort of the methods that have none. With `quick` the two
/// smallest on the full resolution; else full multigrid also solves sampled images, the coarsest first.
[[nodiscard]] std::vector<int> efforts(const Method& method, int own_iterations, bool quick);

/// "4 cycles", "1 iteration on the full resolution", "2 cycles on every 8th pixel".
[[nodiscard]] std::string effort_text(const Method& method, int effort);

/// The effort on every backend: the method's usual one or the scene's, less for annealing.
[[nodiscard]] int usual_effort(const Method& method, int own_iterations);

/// The method name of rows for which an accuracy was requested (harness/solve/planner.hpp).
inline constexpr std::string_view requested_name = "as-needed-elastic";

struct TradeoffOptions {
  SessionOptions session{};
  int repeats = 3;                    ///< samples per row, fewer where they take long
  std::vector<std::string> methods{}; ///< names of methods and rivals; empty: all
  bool quick = false;                 ///< fewer efforts, one sample
};

/// Every method at all its efforts on Judge::main_place() and at its usual effort on the other backends, what
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

/// What reaches an accuracy soonest. Points into the rows it was made from, of which those of status ok
/// count.
struct EqualAccuracy {
  double target = 0.0;          ///< RMSD to FEM with Poisson ratio 0, pixels
  const Judged* ours = nullptr; ///< the fastest method at most `target` away; nullptr: none is
  double nearest = 0.0;         ///< RMSD of the most accurate method, pixels; infinite: none
  /// A rival of finite elements with ratio 0, and its fastest setting that reaches the target.
  struct Rival {
    const char* key;             ///< in results
    const char* title;           ///< for people
    const char* method;          ///< one of rival_names
    const Judged* row = nullptr; ///< where both sides reach the target
    double ratio = 0.0;          ///< of its median to ours: how many times as long it takes
  };
  std::vector<Rival> rivals{{"direct", "direct FEM", "fem"},
                            {"iterative", "FEM by conjugate gradients", "fem-cg"},
                            {"multigrid", "FEM by multigrid of others", "fem-amg"},
                            {"coarse", "FEM on a coarse mesh", "fem-coarse"}};
};

[[nodiscard]] EqualAccuracy compare_at(std::span<const Judged> rows, double target);

/// As it stands in a result file.
[[nodiscard]] nlohmann::json to_json(const Scene& scene, const EqualAccuracy& equal);

} // namespace hdmbench
