#include "harness/tools/tune.hpp"

#include "harness/judge/truths.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <random>
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

double rmsd(const VectorField& displacement, const Truth& truth) {
  const auto require_extent = [&](Extent found, const char* what) {
    if (found != displacement.extent) {
      throw InputError(fmt::format("{} is {} x {} pixels, the solution is {} x {}", what, found.width,
                                   found.height, displacement.extent.width, displacement.extent.height));
    }
  };
  require_extent(truth.displacement.extent, "the truth");
  std::vector<std::uint8_t> counted;
  if (!truth.defined.values.empty()) {
    require_extent(truth.defined.extent, "the mask of the truth");
    std::ranges::transform(truth.defined.values, std::back_inserter(counted),
                           [](float defined) { return static_cast<std::uint8_t>(defined != 0.0F); });
    if (std::ranges::count(counted, 1) == 0) {
      throw InputError("the truth is defined at no pixel: its mask is 0 everywhere");
    }
  }
  return rmsd(ReferenceField(displacement), ReferenceField(truth.displacement), counted);
}

double minimise_by_simplex(const std::function<double(double)>& function, const SearchOptions& options) {
  constexpr double flat = 1e-6; // values that count as equal
  struct Corner {
    double at;
    double value;
  };
  int evaluations = 0;
  const auto corner = [&](double at) {
    ++evaluations;
    return Corner{at, function(at)};
  };
  // The simplex of one number has two corners.
  Corner best = corner(options.start);
  Corner other = corner(options.start + options.step);
  while (evaluations < options.evaluations &&
         (std::abs(best.at - other.at) > options.tolerance || std::abs(best.value - other.value) > flat)) {
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
  return other.value < best.value ? other.at : best.at;
}

double minimise_by_annealing(const std::function<double(double)>& function, const SearchOptions& options,
                             double temperature, std::uint64_t seed) {
  constexpr std::array<double, 8> moves{1.0, -1.0, 0.3, -0.3, 0.1, -0.1, 0.03, -0.03};
  constexpr double coldest = 1e-3; // of the first temperature
  std::mt19937_64 engine(seed);    // its output is specified, that of the standard's distributions is not
  const auto uniform = [&engine] { return static_cast<double>(engine() >> 11U) * 0x1p-53; };
  const double cooling = std::pow(coldest, 1.0 / options.evaluations);

  double position = options.start;
  double value = function(position);
  double best = position;
  double best_value = value;
  for (int i = 0; i < options.evaluations; ++i) {
    const double next = position + options.step * moves[engine() % moves.size()];
    const double next_value = function(next);
    const double draw = uniform();
    if (next_value <= value || draw < std::exp((value - next_value) / temperature)) {
      position = next;
      value = next_value;
    }
    if (value < best_value) {
      best = position;
      best_value = value;
    }
    temperature *= cooling;
  }
  return best;
}

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
