#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace hdmbench {

enum class SearchMethod { simplex, annealing };

struct TuneOptions {
  SearchMethod method = SearchMethod::simplex;
  double low = 0.01; ///< alpha is sought in low ... high, 0 < low < high < 1
  double high = 0.99;
  int evaluations = 40; ///< of the search, after the scan, about the most that are made; >= 1
};

struct Evaluation {
  double prior_weight; ///< alpha
  double rmsd;         ///< pixels
};

struct Tuning {
  /// Below this spread of the RMSD in pixels alpha is said not to matter.
  static constexpr double flat = 1e-3;

  std::vector<Evaluation> evaluations; ///< in the order they were made; the first ones are the scan
  std::size_t best = 0;                ///< index of the smallest RMSD; of equals the nearest to alpha = 0.5
  std::size_t scanned = 0;             ///< how many belong to the scan

  [[nodiscard]] double spread() const; ///< largest RMSD minus smallest
  [[nodiscard]] bool matters() const { return spread() >= flat; }
};

/// The alpha of the smallest RMSD (A.8). First a scan of five alphas over the range; where that is flat it is
/// all that is done. Then a search from the best of them over log(alpha / (1 - alpha)), so that it cannot
/// leave 0 ... 1: the downhill simplex of Nelder and Mead (thesis A.7.2), or simulated annealing (thesis
/// A.7.1, Alg. 1, which prints the rise with the other sign), the same chain on every machine. `rmsd_at` is
/// asked once for each alpha. Throws InputError where the range is impossible, and what rmsd_at throws.
[[nodiscard]] Tuning tune_prior_weight(const std::function<double(double)>& rmsd_at,
                                       const TuneOptions& options);

} // namespace hdmbench
