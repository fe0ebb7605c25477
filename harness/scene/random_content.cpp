#include "harness/scene/scene_content.hpp"
#include "harness/scene/sites.hpp"

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

void fill_randomly(TomlReader& table, Extent extent, const Rectangle& part, Level& level,
                   VectorField& start) {
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
  // Numbers are drawn for all sites in raster order; those beside the part are drawn and dropped.
  std::size_t next = 0;
  for_each_site(extent, [&](int x, int y) {
    const float own_modulus =
        moduli.empty() ? static_cast<float>(modulus[0] + (modulus[1] - modulus[0]) * source.uniform())
                       : source.one_of(moduli);
    const std::array target{displacement(), displacement()};
    const std::array certainty{confidence(), confidence()};
    const std::array begin{displacement(), displacement()};
    if (x < part.left || x >= part.left + part.width || y < part.top || y >= part.top + part.height) {
      return;
    }
    const std::size_t i = next++;
    level.modulus.values[i] = own_modulus;
    level.target.x[i] = target[0];
    level.target.y[i] = target[1];
    level.confidence.x[i] = certainty[0];
    level.confidence.y[i] = certainty[1];
    start.x[i] = begin[0];
    start.y[i] = begin[1];
  });
}

} // namespace hdmbench
