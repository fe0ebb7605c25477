#include "harness/measure/pairs.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

double chance_of_heads(std::size_t coins, std::size_t heads) {
  double ways = 1.0; // to choose `shown` coins
  double sum = 0.0;
  for (std::size_t shown = 0; shown <= coins; ++shown) {
    sum += shown >= heads ? ways : 0.0;
    ways *= static_cast<double>(coins - shown) / static_cast<double>(shown + 1);
  }
  return sum * std::pow(0.5, static_cast<double>(coins));
}

std::size_t fewest_pairs(std::size_t cases) {
  std::size_t pairs = 1;
  while (chance_of_heads(pairs, pairs) * static_cast<double>(cases) >= chance_of_a_false_verdict) {
    ++pairs;
  }
  return pairs;
}

Change judge_pairs(std::span<const double> ratios, double tolerance, std::size_t cases) {
  const auto is_shown = [&](const auto& holds) {
    const auto heads = static_cast<std::size_t>(std::ranges::count_if(ratios, holds));
    return chance_of_heads(ratios.size(), heads) * static_cast<double>(cases) < chance_of_a_false_verdict;
  };
  const double most = 1.0 + tolerance;
  return is_shown([](double ratio) { return ratio < 1.0; })      ? Change::faster
         : is_shown([&](double ratio) { return ratio <= most; }) ? Change::not_slower
         : is_shown([&](double ratio) { return ratio > most; })  ? Change::slower
                                                                 : Change::inconclusive;
}

} // namespace hdmbench
