#include "harness/check/resting_tiles.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

constexpr int side = 16;

} // namespace

void RestingTiles::begin_level(Extent extent) {
  extent_ = extent;
  tiles_ = {(extent.width + side - 1) / side, (extent.height + side - 1) / side};
  awake_.assign(tiles_.sites(), 1);
}

std::int64_t RestingTiles::sweep(const VectorField& before, const VectorField& after) {
  std::int64_t at_rest = 0;
  for_each_site(tiles_, [&](int x, int y) {
    const int width = std::min(side, extent_.width - x * side);
    const int height = std::min(side, extent_.height - y * side);
    at_rest += awake_[tiles_.index(x, y)] != 0 ? 0 : width * height;
  });
  std::ranges::fill(awake_, 0);
  for_each_site(extent_, [&](int x, int y) {
    const std::size_t site = extent_.index(x, y);
    if (before.x[site] != after.x[site] || before.y[site] != after.y[site]) {
      wake_around(x, y);
    }
  });
  return at_rest;
}

bool RestingTiles::rests(int x, int y) const {
  return awake_[tiles_.index(x / side, y / side)] == 0;
}

void RestingTiles::wake_around(int x, int y) {
  for (int row = std::max(y - 1, 0) / side; row <= std::min(y + 1, extent_.height - 1) / side; ++row) {
    for (int column = std::max(x - 1, 0) / side; column <= std::min(x + 1, extent_.width - 1) / side;
         ++column) {
      awake_[tiles_.index(column, row)] = 1;
    }
  }
}

} // namespace hdmbench
