#include "harness/applications/gray_values.hpp"

#include <array>
#include <cmath>

namespace hdmbench {

ScalarField with_values_of(const ScalarField& source, const ScalarField& target, const ScalarField& unseen) {
  constexpr std::size_t bins = 24;
  constexpr double enough = 20.0; // sites of a bin, for a mean
  const auto [low, high] = std::ranges::minmax(source.values);
  if (!(high > low)) {
    return source;
  }
  const float scale = static_cast<float>(bins - 1) / (high - low);
  const auto position = [&](float gray) {
    const float at = (gray - low) * scale;
    const auto bin = std::min(static_cast<std::size_t>(at), bins - 2);
    return std::pair{bin, at - static_cast<float>(bin)};
  };
  std::array<double, bins> weight{};
  std::array<double, bins> sum{};
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    if (!unseen.values.empty() && unseen.values[site] != 0.0F) {
      continue;
    }
    const auto [bin, past] = position(source.values[site]);
    const auto share = static_cast<double>(past);
    const double change = static_cast<double>(target.values[site]) - static_cast<double>(source.values[site]);
    weight[bin] += 1.0 - share;
    weight[bin + 1] += share;
    sum[bin] += (1.0 - share) * change;
    sum[bin + 1] += share * change;
  }
  // What a bin with too few sites changes by is what its neighbours do.
  double total = 0.0;
  double change = 0.0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    total += weight[bin];
    change += sum[bin];
  }
  const double everywhere = total > 0.0 ? change / total : 0.0;
  std::array<float, bins> shift{};
  double last = everywhere;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    last = weight[bin] >= enough ? sum[bin] / weight[bin] : last;
    shift[bin] = static_cast<float>(last);
  }
  ScalarField result(source.extent);
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    const auto [bin, past] = position(source.values[site]);
    result.values[site] = source.values[site] + shift[bin] + past * (shift[bin + 1] - shift[bin]);
  }
  return result;
}

} // namespace hdmbench
