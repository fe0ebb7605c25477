#include "harness/measure/comparison/verdict.hpp"

#include "harness/measure/median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace hdmbench::comparison {

namespace {

// Quantiles of the standard normal distribution: 1 - significant_p / 2, and 9 of 10.
constexpr double significant = 2.575829;
constexpr double nine_of_ten = 1.281552;
// Median absolute deviation of the standard normal distribution.
constexpr double normal_deviation = 0.674490;

double spread_of(std::span<const double> samples) {
  std::vector<double> logarithms;
  std::ranges::transform(samples, std::back_inserter(logarithms),
                         [](double value) { return std::log(value); });
  const double middle = median(logarithms);
  std::ranges::for_each(logarithms, [&](double& value) { value = std::abs(value - middle); });
  return median(std::move(logarithms)) / normal_deviation;
}

/// The change (of the logarithm) that is seen in nine of ten comparisons, for normal noise of standard
/// deviation 1 on both sides: the variance of the Hodges-Lehmann estimate is pi / 3 (1 / m + 1 / n).
double change_seen(double m, double n) {
  return (significant + nine_of_ten) * std::sqrt(std::numbers::pi / 3.0 * (1.0 / m + 1.0 / n));
}

Change change_of(const Comparison& comparison, double tolerance) {
  if (comparison.p < significant_p) {
    return comparison.ratio.estimate > 1.0 ? Change::slower : Change::faster;
  }
  const bool narrow =
      comparison.ratio.low >= 1.0 / (1.0 + tolerance) && comparison.ratio.high <= 1.0 + tolerance;
  return narrow ? Change::none_seen : Change::too_noisy;
}

} // namespace

Comparison compare_samples(std::span<const double> first, std::span<const double> second, double tolerance) {
  Comparison result;
  result.first_median = median({first.begin(), first.end()});
  result.second_median = median({second.begin(), second.end()});
  if (first.empty() || second.empty()) {
    return result;
  }
  result.ratio_of_medians = result.second_median / result.first_median;
  const auto m = static_cast<double>(first.size());
  const auto n = static_cast<double>(second.size());
  const double tolerated = std::log1p(tolerance);
  result.ratio = ratio_of(first, second);
  result.p = rank_test(first, second).p;
  result.first_spread = spread_of(first);
  result.second_spread = spread_of(second);
  result.largest_good_spread = tolerated / change_seen(m, n);
  const double spread = std::hypot(result.first_spread, result.second_spread) / std::numbers::sqrt2;
  result.samples_needed =
      static_cast<std::size_t>(std::ceil(std::pow(spread * change_seen(1.0, 1.0) / tolerated, 2.0)));
  if (smallest_p(first.size(), second.size()) >= significant_p) {
    return result; // too few
  }
  result.change = change_of(result, tolerance);
  result.slower_than_tolerated = result.change == Change::slower && result.ratio.estimate > 1.0 + tolerance;
  return result;
}

std::string noise_text(const Comparison& comparison, double tolerance) {
  if (!comparison.noisy() && comparison.change != Change::too_noisy) {
    return {};
  }
  std::string text =
      fmt::format("noise: spread {:.1f} % old, {:.1f} % new; to see {:.3g} % takes at most {:.1f} %",
                  100.0 * comparison.first_spread, 100.0 * comparison.second_spread, 100.0 * tolerance,
                  100.0 * comparison.largest_good_spread);
  if (comparison.noisy() && comparison.samples_needed > 0) {
    text += fmt::format(", or {} samples a side", comparison.samples_needed);
  }
  return text;
}

std::size_t samples_that_can_tell(std::size_t first, std::size_t at_least) {
  std::size_t second = at_least;
  // p of one sample against n is 2 / (n + 1): it takes 200 of them.
  while (first > 0 && smallest_p(first, second) >= significant_p) {
    ++second;
  }
  return second;
}

} // namespace hdmbench::comparison
