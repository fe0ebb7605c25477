#include "backends/shared/fastest_way.hpp"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

constexpr int repeats = 5; // odd

/// Of an odd number.
double median(std::vector<double> samples) {
  const auto middle = samples.begin() + repeats / 2;
  std::ranges::nth_element(samples, middle);
  return *middle;
}

} // namespace

Choice fastest_way(const Variants& variants, const std::function<void(std::size_t)>& take,
                   const std::function<double()>& seconds) {
  Choice choice{.what = variants.what, .options = {}};
  for (std::size_t way = 0; way < variants.worth_trying; ++way) {
    choice.options.push_back({.name = variants.names[way]});
  }
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t way = 0; way < choice.options.size(); ++way) {
      take(way);
      choice.options[way].seconds.push_back(seconds());
    }
  }
  const auto fastest = std::ranges::min_element(
      choice.options, {}, [](const Choice::Option& option) { return median(option.seconds); });
  choice.chosen = static_cast<std::size_t>(fastest - choice.options.begin());
  return choice;
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Level measured_level(Extent extent, float modulus_of_square) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 1.0F),
              .penalty = 1000.0F};
  for (int y = extent.height / 4; y < extent.height / 2; ++y) {
    for (int x = extent.width / 4; x < extent.width / 2; ++x) {
      level.modulus.values[extent.index(x, y)] = modulus_of_square;
    }
  }
  set_inverse_modulus(level);
  const auto hold = [&](int x, int y) {
    level.confidence.x[extent.index(x, y)] = 1.0F;
    level.confidence.y[extent.index(x, y)] = 1.0F;
  };
  for (int x = 0; x < extent.width; ++x) {
    hold(x, 0);
    hold(x, extent.height - 1);
  }
  for (int y = 0; y < extent.height; ++y) {
    hold(0, y);
    hold(extent.width - 1, y);
  }
  level.target.x.front() = 8.0F;
  return level;
}

} // namespace hdmbench
