#include "harness/tools/thesis_tools.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <random>
#include <utility>

namespace hdmbench {

namespace {

using Function = std::function<double(double)>;

double logit(double alpha) {
  return std::log(alpha / (1.0 - alpha));
}

std::size_t lowest(const std::vector<Evaluation>& evaluations) {
  const auto rank = [](const Evaluation& evaluation) {
    return std::pair(evaluation.rmsd, std::abs(logit(evaluation.prior_weight)));
  };
  return static_cast<std::size_t>(std::ranges::min_element(evaluations, {}, rank) - evaluations.begin());
}

/// The simplex of one number has two corners.
void search_by_simplex(const Function& function, double start, double step, int evaluations) {
  constexpr double tolerance = 0.01; // of the position
  constexpr double flat = 1e-6;      // values that count as equal
  struct Corner {
    double at;
    double value;
  };
  int asked = 0;
  const auto corner = [&](double at) {
    ++asked;
    return Corner{at, function(at)};
  };
  Corner best = corner(start);
  Corner other = corner(start + step);
  while (asked < evaluations &&
         (std::abs(best.at - other.at) > tolerance || std::abs(best.value - other.value) > flat)) {
    if (other.value < best.value) {
      std::swap(best, other);
    }
    const Corner reflected = corner(2.0 * best.at - other.at);
    if (reflected.value < best.value) {
      const Corner expanded = corner(3.0 * best.at - 2.0 * other.at);
      other = best;
      best = expanded.value < reflected.value ? expanded : reflected;
    } else { // a minimum lies between the two sides
      const Corner& nearer = reflected.value < other.value ? reflected : other;
      other = corner(0.5 * (best.at + nearer.at));
    }
  }
}

/// A move is made with probability min(1, exp(-rise / T)); T falls geometrically to a thousandth.
void search_by_annealing(const Function& function, double start, double step, double temperature,
                         const TuneOptions& options) {
  constexpr std::array<double, 8> moves{1.0, -1.0, 0.3, -0.3, 0.1, -0.1, 0.03, -0.03};
  std::mt19937_64 engine(1); // its output is specified, that of the standard's distributions is not
  double position = start;
  double value = function(position);
  for (int i = 0; i < options.evaluations; ++i) {
    const double next = position + step * moves[engine() % moves.size()];
    const double next_value = function(next);
    const double draw = static_cast<double>(engine() >> 11U) * 0x1p-53;
    if (next_value <= value || draw < std::exp((value - next_value) / temperature)) {
      position = next;
      value = next_value;
    }
    temperature *= std::pow(1e-3, 1.0 / options.evaluations);
  }
}

} // namespace

double Tuning::spread() const {
  const auto [low, high] = std::ranges::minmax(evaluations, {}, &Evaluation::rmsd);
  return high.rmsd - low.rmsd;
}

Tuning tune_prior_weight(const Function& rmsd_at, const TuneOptions& options) {
  if (!(options.low > 0.0 && options.low < options.high && options.high < 1.0)) {
    throw InputError(fmt::format("alpha cannot be sought in {} ... {}; give 0 < low < high < 1", options.low,
                                 options.high));
  }
  constexpr int scan_points = 5;
  const double low = logit(options.low);
  const double high = logit(options.high);
  Tuning tuning;
  std::map<long long, double> known;
  // Beyond the range the value of its end and a slope that leads back.
  const Function value_at = [&](double position) {
    constexpr double resolution = 1e-6;
    const double inside = std::clamp(position, low, high);
    const auto [found, is_new] = known.try_emplace(std::llround(inside / resolution));
    if (is_new) {
      const double alpha = 1.0 / (1.0 + std::exp(-inside));
      found->second = rmsd_at(alpha);
      tuning.evaluations.push_back({.prior_weight = alpha, .rmsd = found->second});
    }
    return found->second + std::abs(position - inside);
  };
  for (int i = 0; i < scan_points; ++i) {
    value_at(std::lerp(low, high, double(i) / (scan_points - 1)));
  }
  tuning.scanned = tuning.evaluations.size();
  tuning.best = lowest(tuning.evaluations);
  if (tuning.matters()) {
    const double start = logit(tuning.evaluations[tuning.best].prior_weight);
    const double step = 0.5 * (high - low) / (scan_points - 1);
    if (options.method == SearchMethod::simplex) {
      search_by_simplex(value_at, start, step, options.evaluations);
    } else {
      // Rises of a tenth of what the scan saw are made willingly at first.
      search_by_annealing(value_at, start, step, 0.1 * tuning.spread(), options);
    }
    tuning.best = lowest(tuning.evaluations);
  }
  return tuning;
}

} // namespace hdmbench
