#include "harness/random_content.hpp"

#include <cmath>
#include <random>

namespace hdmbench {

namespace {

class Source {
public:
  explicit Source(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}

  /// In [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

private:
  std::mt19937_64 engine_;
};

} // namespace

void fill_randomly(TomlReader& table, Level& level, VectorField& start) {
  Source source(table.integer("seed"));
  const auto modulus = table.pair("modulus");
  if (!(modulus[0] > 0.0 && modulus[1] >= modulus[0])) {
    table.fail("modulus", "must be [low, high] with 0 < low <= high (MPa)");
  }
  const double largest = table.number("displacement");
  const double grid = table.number("grid", 0.0);
  const double observed = table.number("observed");
  if (!(observed >= 0.0 && observed <= 1.0)) {
    table.fail("observed", "must be within 0 ... 1");
  }
  if (grid < 0.0) {
    table.fail("grid", "must not be negative (pixels)");
  }
  table.finish();

  const auto displacement = [&] {
    const double value = largest * (2.0 * source.uniform() - 1.0);
    return static_cast<float>(grid > 0.0 ? grid * std::round(value / grid) : value);
  };
  // A third of the observed components are certain, the others anything between.
  const auto confidence = [&] {
    const double draw = source.uniform();
    return static_cast<float>(draw >= observed ? 0.0 : draw < observed / 3.0 ? 1.0 : source.uniform());
  };
  for (std::size_t i = 0; i < level.extent.sites(); ++i) {
    level.modulus.values[i] = static_cast<float>(modulus[0] + (modulus[1] - modulus[0]) * source.uniform());
    level.target.x[i] = displacement();
    level.target.y[i] = displacement();
    level.confidence.x[i] = confidence();
    level.confidence.y[i] = confidence();
    start.x[i] = displacement();
    start.y[i] = displacement();
  }
}

} // namespace hdmbench
