#include "harness/applications/similarity.hpp"

#include <array>
#include <cmath>

namespace hdmbench {

Similarity similarity(const ScalarField& a, const ScalarField& b) {
  constexpr std::size_t bins = Similarity::bins;
  Similarity result;
  const auto sites = static_cast<double>(a.values.size());
  double sum_a = 0.0, sum_b = 0.0, sum_aa = 0.0, sum_bb = 0.0, sum_ab = 0.0;
  for (std::size_t site = 0; site < a.values.size(); ++site) {
    const auto first = static_cast<double>(a.values[site]);
    const auto second = static_cast<double>(b.values[site]);
    sum_a += first;
    sum_b += second;
    sum_aa += first * first;
    sum_bb += second * second;
    sum_ab += first * second;
    result.mean_squares += (first - second) * (first - second) / sites;
  }
  const double spread = std::sqrt((sum_aa - sum_a * sum_a / sites) * (sum_bb - sum_b * sum_b / sites));
  if (!(spread > 0.0)) {
    return result;
  }
  result.correlation = (sum_ab - sum_a * sum_b / sites) / spread;
  const auto bin_of = [](const ScalarField& picture) {
    const auto [low, high] = std::ranges::minmax(picture.values);
    return [low = low, scale = static_cast<float>(bins) / (high - low)](float gray) {
      return std::min(static_cast<std::size_t>((gray - low) * scale), bins - 1);
    };
  };
  const auto bin_a = bin_of(a);
  const auto bin_b = bin_of(b);
  std::array<std::array<double, bins>, bins> joint{};
  std::array<double, bins> of_a{};
  std::array<double, bins> of_b{};
  for (std::size_t site = 0; site < a.values.size(); ++site) {
    const std::size_t row = bin_a(a.values[site]);
    const std::size_t column = bin_b(b.values[site]);
    joint[row][column] += 1.0 / sites;
    of_a[row] += 1.0 / sites;
    of_b[column] += 1.0 / sites;
  }
  for (std::size_t row = 0; row < bins; ++row) {
    for (std::size_t column = 0; column < bins; ++column) {
      if (joint[row][column] > 0.0) {
        result.mutual_information +=
            joint[row][column] * std::log2(joint[row][column] / (of_a[row] * of_b[column]));
      }
    }
  }
  return result;
}

} // namespace hdmbench
