#include "harness/check/compare.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hdmbench {

FieldDifference compare(const VectorField& expected, const VectorField& found) {
  if (expected.extent != found.extent) {
    throw std::logic_error("compare: the fields have different extents");
  }
  FieldDifference result;
  for (std::size_t i = 0; i < expected[0].size(); ++i) {
    if (!differs(expected, found, i)) {
      continue;
    }
    ++result.sites;
    result.first = result.first.value_or(i);
    if (!is_finite(found, i)) {
      ++result.not_finite;
      continue;
    }
    for (std::size_t axis = 0; axis < found.extent.axes(); ++axis) {
      result.largest =
          std::max(result.largest, std::abs(static_cast<double>(expected[axis][i]) - found[axis][i]));
    }
  }
  return result;
}

bool is_finite(const VectorField& field, std::size_t site) {
  bool all = true;
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    all = all && std::isfinite(field[axis][site]);
  }
  return all;
}

bool is_finite(const VectorField& field) {
  return std::ranges::all_of(field.planes, [](const std::vector<float>& plane) {
    return std::ranges::all_of(plane, [](float value) { return std::isfinite(value); });
  });
}

double largest_magnitude(const VectorField& field, const ScalarField& tissue) {
  double largest = 0.0;
  for (std::size_t i = 0; i < field[0].size(); ++i) {
    if (tissue.values.empty() || tissue.values[i] > 0.0F) {
      largest = std::max(largest, length_at(field, i));
    }
  }
  return largest;
}

void RestingTiles::begin_level(Extent extent) {
  const auto tiles = [](int sites) { return (sites + side - 1) / side; };
  extent_ = extent;
  tiles_ = {tiles(extent.width), tiles(extent.height), tiles(extent.depth)};
  awake_.assign(tiles_.sites(), 1);
}

std::int64_t RestingTiles::sweep(const VectorField& before, const VectorField& after) {
  std::int64_t at_rest = 0;
  for_each_site(extent_, [&](int x, int y, int z) { at_rest += rests(x, y, z) ? 1 : 0; });
  std::ranges::fill(awake_, 0);
  // The tiles of both neighbours along an axis: all that the site belongs to or touches.
  const auto around = [](int at, int sites) {
    return std::array{std::max(at - 1, 0) / side, std::min(at + 1, sites - 1) / side};
  };
  for_each_site(extent_, [&](int x, int y, int z) {
    if (differs(before, after, extent_.index(x, y, z))) {
      for (const int slice : around(z, extent_.depth)) {
        for (const int row : around(y, extent_.height)) {
          for (const int column : around(x, extent_.width)) {
            awake_[tiles_.index(column, row, slice)] = 1;
          }
        }
      }
    }
  });
  return at_rest;
}

} // namespace hdmbench
