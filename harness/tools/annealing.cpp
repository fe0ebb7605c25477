#include "harness/tools/annealing.hpp"

#include <array>
#include <cmath>
#include <random>

namespace hdmbench {

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

} // namespace hdmbench
