#include "backends/gl/tiles.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace hdmbench::gl {

namespace {

/// A level as it samples the full image; an interior tile's sites are first ... last, the last one excluded.
class Classifier {
public:
  Classifier(const Level& full, std::span<const int> columns, std::span<const int> rows)
      : full_(full), columns_(columns), rows_(rows) {}

  [[nodiscard]] TileKind kind(int left, int top, int side) const {
    const int right = std::min(left + side, static_cast<int>(columns_.size()));
    const int bottom = std::min(top + side, static_cast<int>(rows_.size()));
    if (left == 0 || top == 0 || right == static_cast<int>(columns_.size()) ||
        bottom == static_cast<int>(rows_.size())) {
      return {};
    }
    const bool candidates = full_.rule == Rule::steps;
    return {.interior = true,
            .homogeneous = candidates && homogeneous(left - 1, top - 1, right + 1, bottom + 1),
            .unobserved = candidates && unobserved(left, top, right, bottom)};
  }

private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return full_.extent.index(columns_[static_cast<std::size_t>(x)], rows_[static_cast<std::size_t>(y)]);
  }

  [[nodiscard]] bool homogeneous(int left, int top, int right, int bottom) const {
    const float modulus = full_.modulus.values[index(left, top)];
    const float inverse = full_.inverse_modulus.values[index(left, top)];
    return modulus * inverse == 1.0F && all_of(left, top, right, bottom, [&](std::size_t site) {
             return full_.modulus.values[site] == modulus && full_.inverse_modulus.values[site] == inverse;
           });
  }

  [[nodiscard]] bool unobserved(int left, int top, int right, int bottom) const {
    return all_of(left, top, right, bottom, [&](std::size_t site) {
      return full_.confidence.x[site] == 0.0F && full_.confidence.y[site] == 0.0F;
    });
  }

  template <typename Predicate>
  [[nodiscard]] bool all_of(int left, int top, int right, int bottom, Predicate holds) const {
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        if (!holds(index(x, y))) {
          return false;
        }
      }
    }
    return true;
  }

  const Level& full_;
  std::span<const int> columns_;
  std::span<const int> rows_;
};

} // namespace

std::vector<TilesOfAKind> classify_tiles(const Level& full, std::span<const int> columns,
                                         std::span<const int> rows, int side) {
  const Classifier classifier(full, columns, rows);
  std::map<TileKind, std::vector<TilesOfAKind::Tile>> by_kind;
  for (int row = 0; row < tiles_along(static_cast<int>(rows.size()), side); ++row) {
    for (int column = 0; column < tiles_along(static_cast<int>(columns.size()), side); ++column) {
      by_kind[classifier.kind(column * side, row * side, side)].push_back({.column = column, .row = row});
    }
  }
  std::vector<TilesOfAKind> kinds;
  for (auto& [kind, tiles] : by_kind) {
    kinds.push_back({.kind = kind, .tiles = std::move(tiles)});
  }
  return kinds;
}

} // namespace hdmbench::gl
