#include "harness/measure/comparison/rank_test.hpp"

#include "harness/measure/median.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace hdmbench::comparison {

namespace {

double standard_normal(double z) {
  return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

/// Twice the rank of every value, first side before second; values that are equal share the mean of their
/// ranks, so that doubled they are whole.
std::vector<std::size_t> doubled_ranks(std::span<const double> first, std::span<const double> second) {
  std::vector<double> values(first.begin(), first.end());
  values.insert(values.end(), second.begin(), second.end());
  std::vector<double> sorted = values;
  std::ranges::sort(sorted);
  std::vector<std::size_t> ranks;
  for (const double value : values) {
    const auto first_equal = std::ranges::lower_bound(sorted, value);
    const auto behind_equal = std::ranges::upper_bound(sorted, value);
    ranks.push_back(
        static_cast<std::size_t>((first_equal - sorted.begin()) + (behind_equal - sorted.begin()) + 1));
  }
  return ranks;
}

/// shares[s]: of all ways to pick `count` of the ranks, the share whose sum is s.
std::vector<double> sum_distribution(const std::vector<std::size_t>& ranks, std::size_t count) {
  std::size_t largest = 0;
  for (const std::size_t rank : ranks) {
    largest += rank;
  }
  std::vector<std::vector<double>> ways(count + 1, std::vector<double>(largest + 1, 0.0));
  ways[0][0] = 1.0;
  for (const std::size_t rank : ranks) {
    for (std::size_t picked = count; picked > 0; --picked) {
      for (std::size_t sum = largest; sum >= rank; --sum) {
        ways[picked][sum] += ways[picked - 1][sum - rank];
      }
    }
  }
  std::vector<double> shares = std::move(ways[count]);
  double all = 0.0;
  for (const double share : shares) {
    all += share;
  }
  std::ranges::for_each(shares, [&](double& share) { share /= all; });
  return shares;
}

double exact_p(const std::vector<std::size_t>& ranks, std::size_t second, std::size_t sum) {
  const std::vector<double> shares = sum_distribution(ranks, second);
  double below = 0.0;
  double above = 0.0;
  for (std::size_t s = 0; s < shares.size(); ++s) {
    below += s <= sum ? shares[s] : 0.0;
    above += s >= sum ? shares[s] : 0.0;
  }
  return std::min(1.0, 2.0 * std::min(below, above));
}

double approximate_p(const std::vector<std::size_t>& ranks, double m, double n, double u) {
  const double all = m + n;
  // The sum over groups of t equal values of t^3 - t is that over values of t^2 - 1.
  double ties = 0.0;
  for (const std::size_t rank : ranks) {
    const auto equal = static_cast<double>(std::ranges::count(ranks, rank));
    ties += equal * equal - 1.0;
  }
  const double variance = m * n / 12.0 * (all + 1.0 - ties / (all * (all - 1.0)));
  const double distance = std::max(0.0, std::abs(u - 0.5 * m * n) - 0.5);
  return variance > 0.0 ? 2.0 * standard_normal(-distance / std::sqrt(variance)) : 1.0;
}

/// The number of pairs to leave out at either end of an interval, and what it covers.
struct Tail {
  std::size_t pairs = 0;
  double coverage = 0.0;
};

Tail exact_tail(std::size_t m, std::size_t n, double outside) {
  std::vector<std::size_t> ranks(m + n);
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    ranks[i] = i + 1; // U is the sum of n of them less the smallest possible sum
  }
  const std::vector<double> shares = sum_distribution(ranks, n);
  const std::size_t smallest = n * (n + 1) / 2;
  double below = shares[smallest];
  Tail tail{0, 1.0 - 2.0 * below};
  while (below + shares[smallest + tail.pairs + 1] <= 0.5 * outside) {
    ++tail.pairs;
    below += shares[smallest + tail.pairs];
    tail.coverage = 1.0 - 2.0 * below;
  }
  return tail;
}

Tail approximate_tail(double m, double n, double outside) {
  const double deviation = std::sqrt(m * n * (m + n + 1.0) / 12.0);
  const auto share_below = [&](double u) { return standard_normal((u + 0.5 - 0.5 * m * n) / deviation); };
  Tail tail{0, 1.0 - 2.0 * share_below(0.0)};
  while (share_below(static_cast<double>(tail.pairs + 1)) <= 0.5 * outside) {
    ++tail.pairs;
    tail.coverage = 1.0 - 2.0 * share_below(static_cast<double>(tail.pairs));
  }
  return tail;
}

} // namespace

RankTest rank_test(std::span<const double> first, std::span<const double> second) {
  if (first.empty() || second.empty()) {
    return {};
  }
  const std::vector<std::size_t> ranks = doubled_ranks(first, second);
  std::size_t sum = 0;
  for (std::size_t i = first.size(); i < ranks.size(); ++i) {
    sum += ranks[i];
  }
  const auto m = static_cast<double>(first.size());
  const auto n = static_cast<double>(second.size());
  const double u = 0.5 * static_cast<double>(sum) - 0.5 * n * (n + 1.0);
  return {u, ranks.size() <= most_exact ? exact_p(ranks, second.size(), sum) : approximate_p(ranks, m, n, u)};
}

double smallest_p(std::size_t first, std::size_t second) {
  if (first == 0 || second == 0) {
    return 1.0;
  }
  double p = 2.0;
  for (std::size_t i = 1; i <= first; ++i) {
    p *= static_cast<double>(i) / static_cast<double>(second + i);
  }
  return std::min(1.0, p);
}

Ratio ratio_of(std::span<const double> first, std::span<const double> second, double coverage) {
  std::vector<double> ratios;
  for (const double denominator : first) {
    std::ranges::transform(second, std::back_inserter(ratios),
                           [&](double numerator) { return numerator / denominator; });
  }
  std::ranges::sort(ratios);
  const Tail tail = first.size() + second.size() <= most_exact
                        ? exact_tail(first.size(), second.size(), 1.0 - coverage)
                        : approximate_tail(static_cast<double>(first.size()),
                                           static_cast<double>(second.size()), 1.0 - coverage);
  return {median(ratios), ratios[tail.pairs], ratios[ratios.size() - 1 - tail.pairs], tail.coverage};
}

} // namespace hdmbench::comparison
