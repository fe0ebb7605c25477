#include "harness/tools/node_buckets.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// The first or last bucket for what lies beyond the ends.
int clamped(double position, int count) {
  return static_cast<int>(std::clamp(position, 0.0, count - 1.0));
}

} // namespace

NodeBuckets::NodeBuckets(std::span<const MeshNode> nodes)
    : nodes_(nodes), left_(std::ranges::min(nodes, {}, &MeshNode::x).x),
      top_(std::ranges::min(nodes, {}, &MeshNode::y).y) {
  const double width = std::ranges::max(nodes, {}, &MeshNode::x).x - left_;
  const double height = std::ranges::max(nodes, {}, &MeshNode::y).y - top_;
  const double count = static_cast<double>(nodes.size());
  // A long thin cloud gets a row of buckets, not more than there are nodes.
  side_ = std::max({std::sqrt(width * height / count), width / count, height / count, 1e-9});
  columns_ = static_cast<int>(std::min(width / side_, count)) + 1;
  rows_ = static_cast<int>(std::min(height / side_, count)) + 1;
  buckets_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    buckets_[bucket(column_of(nodes[i].x), row_of(nodes[i].y))].push_back(i);
  }
}

int NodeBuckets::column_of(double x) const {
  return clamped((x - left_) / side_, columns_);
}

int NodeBuckets::row_of(double y) const {
  return clamped((y - top_) / side_, rows_);
}

std::optional<std::size_t> NodeBuckets::nearest(double x, double y, double reach) const {
  std::optional<std::size_t> best;
  double best_squared = reach * reach;
  const auto consider = [&](int column, int row) {
    for (const std::size_t i : buckets_[bucket(column, row)]) {
      const double dx = nodes_[i].x - x;
      const double dy = nodes_[i].y - y;
      const double squared = dx * dx + dy * dy;
      if (squared < best_squared || (squared == best_squared && i <= best.value_or(i))) {
        best = i;
        best_squared = squared;
      }
    }
  };
  const int column = column_of(x);
  const int row = row_of(y);
  const int last_ring = std::max({column, columns_ - 1 - column, row, rows_ - 1 - row});
  for (int ring = 0; ring <= last_ring; ++ring) {
    // A bucket of this ring is at least that far away, also from a point beside all buckets.
    const double away = std::max(ring - 1, 0) * side_;
    if (away * away > best_squared) {
      break;
    }
    for (int r = std::max(row - ring, 0); r <= std::min(row + ring, rows_ - 1); ++r) {
      const bool whole_row = std::abs(r - row) == ring;
      for (int c = column - ring; c <= column + ring; c += whole_row ? 1 : 2 * ring) {
        if (c >= 0 && c < columns_) {
          consider(c, r);
        }
      }
    }
  }
  return best;
}

} // namespace hdmbench
