#include "harness/scene/scene_content.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace hdmbench {

namespace {

class Source {
public:
  explicit Source(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}

  /// In [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  float one_of(const std::vector<float>& values) {
    return values[static_cast<std::size_t>(uniform() * static_cast<double>(values.size()))];
  }

private:
  std::mt19937_64 engine_;
};

/// Values to draw from; empty where the key is absent.
template <typename Predicate>
std::vector<float> read_list(TomlReader& table, std::string_view key, Predicate holds) {
  std::vector<float> values;
  if (table.has(key)) {
    values = table.numbers(key);
    if (values.empty() || !std::ranges::all_of(values, holds)) {
      table.fail(key,
                 "must be a list of values in its range (moduli > 0, confidences above 0 and at most 1)");
    }
  }
  return values;
}

} // namespace

void fill_randomly(TomlReader& table, Level& level, VectorField& start) {
  Source source(table.integer("seed"));
  if (table.has("modulus") == table.has("moduli")) {
    table.fail("modulus", "or moduli: give a range or a list of values (MPa)");
  }
  const std::vector<float> moduli = read_list(table, "moduli", [](float m) { return m > 0.0F; });
  const auto modulus = table.has("modulus") ? table.pair("modulus") : std::array{1.0, 1.0};
  if (!(modulus[0] > 0.0 && modulus[1] >= modulus[0])) {
    table.fail("modulus", "must be [low, high] with 0 < low <= high (MPa)");
  }
  const std::vector<float> confidences =
      read_list(table, "confidences", [](float c) { return c > 0.0F && c <= 1.0F; });
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
  // Without a list a third of the observed components are certain, the others anything between.
  const auto confidence = [&] {
    const double draw = source.uniform();
    if (!confidences.empty()) {
      const float certainty = source.one_of(confidences);
      return draw >= observed ? 0.0F : certainty;
    }
    return static_cast<float>(draw >= observed ? 0.0 : draw < observed / 3.0 ? 1.0 : source.uniform());
  };
  for (std::size_t i = 0; i < level.extent.sites(); ++i) { // the order of the draws is the scene's
    level.modulus.values[i] =
        moduli.empty() ? static_cast<float>(modulus[0] + (modulus[1] - modulus[0]) * source.uniform())
                       : source.one_of(moduli);
    level.target.x[i] = displacement();
    level.target.y[i] = displacement();
    level.confidence.x[i] = confidence();
    level.confidence.y[i] = confidence();
    start.x[i] = displacement();
    start.y[i] = displacement();
  }
}

} // namespace hdmbench
