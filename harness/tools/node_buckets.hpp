#pragma once

#include "harness/tools/mesh.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace hdmbench {

/// Nodes sorted into square buckets over all of them, on average about one in each, to find the nearest one
/// without asking every node.
class NodeBuckets {
public:
  /// At least one node; they must outlive this object.
  explicit NodeBuckets(std::span<const MeshNode> nodes);

  /// Index of the nearest node at most `reach` away, the lowest one among equals.
  [[nodiscard]] std::optional<std::size_t> nearest(double x, double y, double reach) const;

private:
  [[nodiscard]] int column_of(double x) const;
  [[nodiscard]] int row_of(double y) const;
  [[nodiscard]] std::size_t bucket(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  std::span<const MeshNode> nodes_;
  double left_ = 0.0;
  double top_ = 0.0;
  double side_ = 1.0;
  int columns_ = 1;
  int rows_ = 1;
  std::vector<std::vector<std::size_t>> buckets_;
};

} // namespace hdmbench
