#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What `hdmbench tradeoff` wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

/// One setting of one method or rival on one scene.
struct TradeoffRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double poisson = 0.0; ///< the scene's
  std::string method;
  bool is_rival = false;
  std::string effort;
  std::optional<double> poisson_used; ///< of finite elements
  std::string backend;                ///< empty for rivals
  std::string device;
  std::string command;         ///< repeats it
  std::string status;          ///< ok, unverified, failed or skipped
  std::string reason;          ///< empty where ok
  std::vector<double> seconds; ///< raw samples; never empty where ok
  std::optional<double> seconds_median;
  std::optional<double> fine_sweep_equivalents;
  std::optional<double> asked;      ///< accuracy asked for, pixels; only of points that asked
  std::optional<double> estimated;  ///< RMSD to the fixed point as the method estimates it, pixels
  std::optional<double> to_fem_nu0; ///< RMSD in pixels, as the next two; all three there where ok
  std::optional<double> to_fem;
  std::optional<double> to_fixed_point;
};

/// The fastest method of ours at an accuracy against finite elements.
struct EqualAccuracyRow {
  struct Entry {
    std::string method;
    std::string effort;
    std::string backend;
    double seconds_median = 0.0;
    double ratio = 1.0; ///< of a rival: its seconds over ours, with what the samples allow
    double ratio_low = 1.0;
    double ratio_high = 1.0;
  };
  std::size_t context = 0;
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double poisson = 0.0;
  double target = 0.0;           ///< RMSD to FEM with Poisson ratio 0, pixels
  std::optional<double> nearest; ///< of our most accurate method; none: there is no result
  std::optional<Entry> ours;
  std::optional<Entry> direct;    ///< finite elements by factorisation
  std::optional<Entry> iterative; ///< by conjugate gradients
  std::optional<Entry> coarse;    ///< on a coarse mesh
};

/// One element of "results" of kind "point". Throws InputError naming file and key for what is missing,
/// mistyped or contradicts itself: an "ok" without samples or with another median, a negative RMSD.
[[nodiscard]] TradeoffRow read_tradeoff(const JsonReader& json);

/// One of kind "equal accuracy"; throws as read_tradeoff.
[[nodiscard]] EqualAccuracyRow read_equal_accuracy(const JsonReader& json);

} // namespace hdmbench::report
