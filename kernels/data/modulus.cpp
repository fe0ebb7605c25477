#include "kernels/data/modulus.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace hdmbench {

namespace {

/// Indices first ... last of an axis, both included.
struct Range {
  int first = 0;
  int last = 0;

  [[nodiscard]] int count() const { return last - first + 1; }
};

/// The fine sites of an axis that each coarse one stands for: those it is the nearest to with corner
/// alignment, a site in the middle counting for both, and those with their centre in its area with center
/// alignment.
std::vector<Range> footprints(int coarse, int fine, Alignment alignment) {
  std::vector<Range> result(static_cast<std::size_t>(coarse), {0, fine - 1});
  for (int index = 0; coarse > 1 && index < coarse; ++index) {
    const long long i = index;
    const long long k = coarse;
    const long long n = fine;
    Range& sites = result[static_cast<std::size_t>(index)];
    if (alignment == Alignment::corner) { // |j (k - 1) - i (n - 1)| <= (n - 1) / 2
      const long long before = std::max((2 * i - 1) * (n - 1), 0LL);
      sites.first = static_cast<int>((before + 2 * (k - 1) - 1) / (2 * (k - 1)));
      sites.last = static_cast<int>(std::min((2 * i + 1) * (n - 1) / (2 * (k - 1)), n - 1));
    } else { // 2 i n <= (2 j + 1) k < 2 (i + 1) n
      const auto first_of = [&](long long j) { return (std::max(2 * j * n - k, 0LL) + 2 * k - 1) / (2 * k); };
      sites.first = static_cast<int>(first_of(i));
      sites.last = static_cast<int>(std::min(first_of(i + 1), n) - 1);
    }
  }
  return result;
}

} // namespace

void set_mean_modulus(const Level& full, Alignment alignment, Level& level) {
  const std::vector<Range> columns = footprints(level.extent.width, full.extent.width, alignment);
  const std::vector<Range> rows = footprints(level.extent.height, full.extent.height, alignment);
  const std::vector<Range> slices = footprints(level.extent.depth, full.extent.depth, alignment);
  std::vector<double> sums(columns.size());
  for (int line = 0; line < level.extent.rows(); ++line) {
    const Range row = rows[static_cast<std::size_t>(line % level.extent.height)];
    const Range slice = slices[static_cast<std::size_t>(line / level.extent.height)];
    std::ranges::fill(sums, 0.0);
    for (int part = 0; part < slice.count() * row.count(); ++part) {
      const float* const moduli =
          full.modulus.values.data() +
          full.extent.index(0, row.first + part % row.count(), slice.first + part / row.count());
      for (std::size_t column = 0; column < columns.size(); ++column) {
        for (int x = columns[column].first; x <= columns[column].last; ++x) {
          sums[column] += static_cast<double>(moduli[x]);
        }
      }
    }
    for (std::size_t column = 0; column < columns.size(); ++column) {
      const int sites = slice.count() * row.count() * columns[column].count();
      level.modulus.values[level.extent.index(static_cast<int>(column), line)] =
          static_cast<float>(sums[column] / sites);
    }
  }
  set_inverse_modulus(level);
}

ModulusRange modulus_range(const ScalarField& modulus) {
  const std::vector<float>& values = modulus.values;
  std::int32_t softest = ordered_bits(std::numeric_limits<float>::max());
  std::int32_t stiffest = 0;
#pragma omp parallel for simd if (values.size() > sites_worth_threads) reduction(min                         \
                                                                                 : softest)                  \
    reduction(max                                                                                            \
              : stiffest)
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::int32_t own = ordered_bits(values[i]);
    softest = own < softest ? own : softest;
    stiffest = own > stiffest ? own : stiffest;
  }
  return {.softest = static_cast<double>(std::bit_cast<float>(softest)),
          .stiffest = static_cast<double>(std::bit_cast<float>(stiffest))};
}

NeighbourContrast largest_neighbour_contrast(const ScalarField& modulus) {
  const Extent extent = modulus.extent;
  std::vector<NeighbourContrast> of_rows(static_cast<std::size_t>(extent.rows()));
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    NeighbourContrast& found = of_rows[static_cast<std::size_t>(row)];
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t at = extent.index(x, row);
      for (int i = 14; i < (extent.depth > 1 ? 27 : 18); ++i) { // the half of the neighbours that is ahead
        const int nx = x + i % 3 - 1;
        const int ny = row % extent.height + i / 3 % 3 - 1;
        const int nz = row / extent.height + i / 9 - 1;
        if (std::min(nx, ny) >= 0 && nx < extent.width && ny < extent.height && nz < extent.depth) {
          const std::size_t other = extent.index(nx, ny, nz);
          const auto [soft, stiff] = std::minmax(modulus.values[at], modulus.values[other]);
          const double ratio = static_cast<double>(stiff) / static_cast<double>(soft);
          if (ratio > found.ratio) {
            found = {ratio, modulus.values[at] < modulus.values[other] ? other : at};
          }
        }
      }
    }
  }
  return *std::ranges::max_element(of_rows, {}, &NeighbourContrast::ratio);
}

int exponent_to_safe_moduli(const ModulusRange& range) {
  const bool is_empty = range.stiffest < range.softest;
  const bool is_safe = range.stiffest >= 0x1p-20 && range.stiffest <= 0x1p40 && range.softest >= 0x1p-60;
  return is_empty || is_safe ? 0 : -(std::ilogb(range.softest) + std::ilogb(range.stiffest)) / 2;
}

void scale_moduli(Level& level, int exponent) {
  std::ranges::transform(level.modulus.values, level.modulus.values.begin(),
                         [&](float modulus) { return std::ldexp(modulus, exponent); });
  for (std::vector<float>& component : level.force.planes) {
    std::ranges::transform(component, component.begin(),
                           [&](float force) { return std::ldexp(force, exponent); });
  }
  set_inverse_modulus(level);
}

} // namespace hdmbench
