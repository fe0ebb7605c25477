#include "harness/ranks/ranked_resampling.hpp"

#include "kernels/data/sites_worth_threads.hpp"
#include "kernels/specification/projection.hpp"

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// The indices of an axis from `first` on, `count` of them, that `indices` (rising) has: where they begin,
/// and how many.
std::pair<int, int> indices_within(const std::vector<int>& indices, int first, int count) {
  const auto begin = std::ranges::lower_bound(indices, first);
  const auto end = std::ranges::lower_bound(indices, first + count);
  return {static_cast<int>(begin - indices.begin()), static_cast<int>(end - begin)};
}

/// What prolongation reads of the coarse level for `fine` sites of an axis from `first` on.
std::pair<int, int> coarse_range(const std::vector<Interpolation>& axis, int first, int count) {
  if (count == 0) {
    return {0, 0};
  }
  const int begin = axis[static_cast<std::size_t>(first)].first;
  return {begin, axis[static_cast<std::size_t>(first + count - 1)].second + 1 - begin};
}

/// A coarse row at all fine columns.
struct WideRow {
  int row = -1;
  std::vector<float> values{};
};

} // namespace

RankedSampler::RankedSampler(Extent full, Extent level, Alignment alignment)
    : columns_(sampled_indices(level.width, full.width, alignment)),
      rows_(sampled_indices(level.height, full.height, alignment)) {}

Rectangle RankedSampler::sites(const Rectangle& part) const {
  const auto [left, width] = indices_within(columns_, part.left, part.width);
  const auto [top, height] = indices_within(rows_, part.top, part.height);
  return {.left = left, .top = top, .width = width, .height = height};
}

void RankedSampler::operator()(const Rectangle& part, std::span<const float> values, const Rectangle& held,
                               std::span<float> to, const Rectangle& to_sites) const {
  const int* const columns = columns_.data() + part.left;
#pragma omp parallel for schedule(static) if (part.extent().sites() > sites_worth_threads)
  for (int y = part.top; y < part.top + part.height; ++y) {
    const float* const row =
        values.data() + held.extent().index(0, rows_[static_cast<std::size_t>(y)] - held.top);
    float* const sampled = to.data() + to_sites.extent().index(part.left - to_sites.left, y - to_sites.top);
    for (int i = 0; i < part.width; ++i) {
      sampled[i] = row[columns[i] - held.left];
    }
  }
}

RankedProjection::RankedProjection(Extent coarse, Extent fine, Alignment alignment)
    : columns_(interpolations(coarse.width, fine.width, alignment)),
      rows_(interpolations(coarse.height, fine.height, alignment)) {}

Rectangle RankedProjection::sites(const Rectangle& part) const {
  const auto [left, width] = coarse_range(columns_, part.left, part.width);
  const auto [top, height] = coarse_range(rows_, part.top, part.height);
  return {.left = left, .top = top, .width = width, .height = height};
}

VectorField RankedProjection::operator()(const VectorField& coarse, const Rectangle& part) const {
  VectorField fine(part.extent());
  project(coarse.x, part, fine.x);
  project(coarse.y, part, fine.y);
  return fine;
}

/// As Projection (kernels/data/pyramid.hpp) does it: first along x, which rows share, then along y.
void RankedProjection::project(const std::vector<float>& coarse, const Rectangle& part,
                               std::vector<float>& fine) const {
  if (fine.empty()) {
    return;
  }
  const Rectangle from = sites(part);
  const auto first = columns_.begin() + part.left;
  const std::vector<Interpolation> columns(first, first + part.width);
  const auto widen = [&](int row, WideRow& wide) {
    if (wide.row == row) {
      return;
    }
    wide.row = row;
    wide.values.resize(columns.size());
    const float* const values = coarse.data() + from.extent().index(0, row - from.top);
    std::ranges::transform(columns, wide.values.begin(), [&](const Interpolation& column) {
      return projection::interpolated(values[column.first - from.left], values[column.second - from.left],
                                      column.weight);
    });
  };
#pragma omp parallel if (fine.size() > sites_worth_threads)
  {
    WideRow above;
    WideRow below;
#pragma omp for schedule(static)
    for (int y = 0; y < part.height; ++y) {
      const Interpolation& between = rows_[static_cast<std::size_t>(part.top + y)];
      if (above.row != between.first && below.row == between.first) {
        std::swap(above, below);
      }
      widen(between.first, above);
      widen(between.second, below);
      const float* const upper = above.values.data();
      const float* const lower = below.values.data();
      float* const to = fine.data() + part.extent().index(0, y);
      const float weight = between.weight;
#pragma omp simd
      for (int x = 0; x < part.width; ++x) {
        to[x] = projection::interpolated(upper[x], lower[x], weight);
      }
    }
  }
}

} // namespace hdmbench
