#include "harness/tools/tune.hpp"

#include "harness/tools/annealing.hpp"
#include "harness/tools/simplex.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

namespace hdmbench {

namespace {

constexpr int scan_points = 5;

double logit(double alpha) {
  return std::log(alpha / (1.0 - alpha));
}

double alpha_of(double position) {
  return 1.0 / (1.0 + std::exp(-position));
}

/// Every alpha once, in the order they are first asked for.
class Record {
public:
  Record(const std::function<double(double)>& rmsd_at, double low, double high, Tuning& tuning)
      : rmsd_at_(rmsd_at), low_(low), high_(high), tuning_(tuning) {}

  /// At log(alpha / (1 - alpha)); beyond the range the value of its end and a slope that leads back.
  double operator()(double position) {
    constexpr double resolution = 1e-6;
    const double inside = std::clamp(position, low_, high_);
    const auto key = std::llround(inside / resolution);
    auto found = known_.find(key);
    if (found == known_.end()) {
      const double alpha = alpha_of(inside);
      found = known_.emplace(key, rmsd_at_(alpha)).first;
      tuning_.evaluations.push_back({.prior_weight = alpha, .rmsd = found->second});
    }
    return found->second + std::abs(position - inside);
  }

private:
  const std::function<double(double)>& rmsd_at_;
  double low_;
  double high_;
  Tuning& tuning_;
  std::map<long long, double> known_;
};

std::size_t lowest(const std::vector<Evaluation>& evaluations) {
  const auto rank = [](const Evaluation& evaluation) {
    return std::pair(evaluation.rmsd, std::abs(logit(evaluation.prior_weight)));
  };
  return static_cast<std::size_t>(std::ranges::min_element(evaluations, {}, rank) - evaluations.begin());
}

} // namespace

double Tuning::spread() const {
  const auto [low, high] = std::ranges::minmax(evaluations, {}, &Evaluation::rmsd);
  return high.rmsd - low.rmsd;
}

Tuning::Range Tuning::plateau() const {
  std::vector<std::size_t> order(evaluations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [this](std::size_t i) { return evaluations[i].prior_weight; });
  const auto is_low = [this](std::size_t i) { return evaluations[i].rmsd < evaluations[best].rmsd + flat; };
  const auto at_best = std::ranges::find(order, best);
  const auto end = std::find_if_not(at_best, order.end(), is_low);
  const auto begin = std::find_if_not(std::reverse_iterator(at_best), order.rend(), is_low).base();
  return {.low = evaluations[*begin].prior_weight,
          .high = evaluations[*std::prev(end)].prior_weight,
          .scanned = static_cast<std::size_t>(
              std::count_if(begin, end, [this](std::size_t i) { return i < scanned; }))};
}

Tuning tune_prior_weight(const std::function<double(double)>& rmsd_at, const TuneOptions& options) {
  if (!(options.low > 0.0 && options.low < options.high && options.high < 1.0)) {
    throw InputError(fmt::format("alpha cannot be sought in {} ... {}; give 0 < low < high < 1", options.low,
                                 options.high));
  }
  const double low = logit(options.low);
  const double high = logit(options.high);
  Tuning tuning;
  Record record(rmsd_at, low, high, tuning);
  for (int i = 0; i < scan_points; ++i) {
    record(std::lerp(low, high, double(i) / (scan_points - 1)));
  }
  tuning.scanned = tuning.evaluations.size();
  tuning.best = lowest(tuning.evaluations);
  if (!tuning.matters()) {
    return tuning;
  }
  const SearchOptions search{.start = logit(tuning.evaluations[tuning.best].prior_weight),
                             .step = 0.5 * (high - low) / (scan_points - 1),
                             .tolerance = 0.01,
                             .evaluations = options.evaluations};
  const std::function<double(double)> function = [&record](double position) { return record(position); };
  if (options.method == SearchMethod::simplex) {
    (void)minimise_by_simplex(function, search);
  } else {
    // Rises of a tenth of what the scan saw are made willingly at first.
    (void)minimise_by_annealing(function, search, 0.1 * tuning.spread(), options.seed);
  }
  tuning.best = lowest(tuning.evaluations);
  return tuning;
}

} // namespace hdmbench
