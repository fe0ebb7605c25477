#pragma once

#include "kernels/data/field.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace hdmbench {

/// What a solution is measured against.
struct Truth {
  VectorField displacement; ///< pixels
  ScalarField defined;      ///< not 0 where the truth is known; empty: everywhere
};

/// (5.1) over the sites where the truth is defined, pixels. Throws InputError where the sizes differ or the
/// truth is defined nowhere.
[[nodiscard]] double rmsd(const VectorField& displacement, const Truth& truth);

/// Where and how far a search over one number looks.
struct SearchOptions {
  double start = 0.0;
  double step = 1.0;       ///< length of the first step
  double tolerance = 1e-3; ///< of the position
  int evaluations = 40;    ///< about the most that are made; >= 1
};

/// Nelder and Mead's downhill simplex (thesis A.7.2): the position of the smallest value found.
[[nodiscard]] double minimise_by_simplex(const std::function<double(double)>& function,
                                         const SearchOptions& options);

/// Simulated annealing on a chain of one number (thesis Alg. 1 as A.7.1 has it), `options.evaluations` moves.
/// A move is one of +-step, +-0.3 step, +-0.1 step, +-0.03 step, drawn with equal probability, and is made
/// with probability min(1, exp(-rise / T)); T falls geometrically from `temperature` to a thousandth of it.
/// (Alg. 1 prints the rise with the other sign.) The same seed gives the same chain on every machine. Returns
/// the position of the smallest value seen.
[[nodiscard]] double minimise_by_annealing(const std::function<double(double)>& function,
                                           const SearchOptions& options, double temperature,
                                           std::uint64_t seed);

enum class SearchMethod { simplex, annealing };

struct TuneOptions {
  SearchMethod method = SearchMethod::simplex;
  double low = 0.01; ///< alpha is sought in low ... high, 0 < low < high < 1
  double high = 0.99;
  int evaluations = 40;   ///< of the search, after the scan; >= 1
  std::uint64_t seed = 1; ///< of annealing
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

  struct Range {
    double low;
    double high;
    std::size_t scanned; ///< how many alphas of the scan are in it
  };
  /// The alphas around the best one between which every RMSD that was seen is less than `flat` above the
  /// best.
  [[nodiscard]] Range plateau() const;
};

/// The alpha of the smallest RMSD (A.8). First a scan of five alphas over the range; where that is flat it is
/// all that is done. Then the method searches from the best of them, over log(alpha / (1 - alpha)) so that it
/// cannot leave 0 ... 1. `rmsd_at` is asked once for each alpha. Throws InputError where the range is
/// impossible, and what rmsd_at throws.
[[nodiscard]] Tuning tune_prior_weight(const std::function<double(double)>& rmsd_at,
                                       const TuneOptions& options);

} // namespace hdmbench
