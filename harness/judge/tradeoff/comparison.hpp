#pragma once

#include "harness/judge/judge.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

/// What the rows of `tradeoff` come to: the Pareto front, and who is faster at equal accuracy. Only rows of
/// status ok count.
namespace hdmbench {

/// What a result costs and how wrong it is. Any unit of which less is better.
struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

/// The Pareto front: indices of the points that no other point beats, by rising cost and so by falling error.
/// A point beats another where it is no worse in both and better in one; of equal points the first stands for
/// all. What is not finite or negative is no result and neither beats nor stands.
[[nodiscard]] std::vector<std::size_t> pareto_front(std::span<const CostAndError> points);

/// Sets is_on_front of all rows.
void mark_front(std::vector<Judged>& rows);

/// How many times faster one row is than a rival that is as accurate.
struct SpeedRatio {
  const Judged* rival = nullptr;
  double ratio = 0.0; ///< of the medians; above 1: ours is faster
  double low = 0.0;   ///< the rival's fastest sample over our slowest
  double high = 0.0;  ///< the rival's slowest sample over our fastest
};

/// What reaches an accuracy soonest. Points into the rows it was made from.
struct EqualAccuracy {
  double target = 0.0;          ///< RMSD to FEM with Poisson ratio 0, pixels
  const Judged* ours = nullptr; ///< the fastest method at most `target` away; nullptr: none is
  double nearest = 0.0;         ///< RMSD of the most accurate method, pixels; infinite: none
  /// A rival of finite elements with ratio 0, and its fastest setting that reaches the target.
  struct Rival {
    const char* key;                   ///< in results
    const char* title;                 ///< for people
    const char* method;                ///< one of rival_names
    std::optional<SpeedRatio> speed{}; ///< where both sides reach the target
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
