#include "harness/judge/accuracy/figures.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace hdmbench::figures {

namespace {

/// i-th of `count` equidistant sites on an axis of `sites`, first and last included.
int spread(int i, int count, int sites) {
  return count == 1 ? sites / 2
                    : static_cast<int>(std::lround(static_cast<double>(i) * (sites - 1) / (count - 1)));
}

/// Where the point (x, y) between sites goes: bilinear.
std::pair<double, double> moved(const ReferenceField& field, double x, double y) {
  const Extent extent = field.extent;
  const auto axis = [](double at, int sites) {
    const double inside = std::clamp(at, 0.0, static_cast<double>(sites - 1));
    const int first = std::min(static_cast<int>(inside), std::max(sites - 2, 0));
    return std::pair(first, inside - first);
  };
  const auto [column, right] = axis(x, extent.width);
  const auto [row, down] = axis(y, extent.height);
  const int next_column = std::min(column + 1, extent.width - 1);
  const int next_row = std::min(row + 1, extent.height - 1);
  const auto value = [&, column = column, row = row, right = right,
                      down = down](const std::vector<double>& component) {
    const double above = (1.0 - right) * component[extent.index(column, row)] +
                         right * component[extent.index(next_column, row)];
    const double below = (1.0 - right) * component[extent.index(column, next_row)] +
                         right * component[extent.index(next_column, next_row)];
    return (1.0 - down) * above + down * below;
  };
  return {x + value(field.x), y + value(field.y)};
}

void append(Polyline& line, std::pair<double, double> point) {
  line.push_back(point.first);
  line.push_back(point.second);
}

/// A pixel corner: (x, y) stands at (x - 0.5, y - 0.5).
using Corner = std::pair<int, int>;

/// Undirected edges between pixel corners; lines are taken out of it one after the other.
class EdgeGraph {
public:
  void add(Corner a, Corner b) {
    neighbours_[a].push_back(b);
    neighbours_[b].push_back(a);
  }

  /// The corners of a line that cannot be longer; empty when no edge is left.
  std::vector<Corner> take_line() {
    while (!neighbours_.empty() && neighbours_.begin()->second.empty()) {
      neighbours_.erase(neighbours_.begin());
    }
    std::vector<Corner> line;
    if (neighbours_.empty()) {
      return line;
    }
    Corner at = neighbours_.begin()->first;
    line.push_back(at);
    while (!neighbours_[at].empty()) {
      const Corner next = neighbours_[at].back();
      neighbours_[at].pop_back();
      std::erase(neighbours_[next], at);
      line.push_back(next);
      at = next;
    }
    return line;
  }

private:
  std::map<Corner, std::vector<Corner>> neighbours_;
};

} // namespace

Profiles profiles(const ReferenceField& field) {
  const Extent extent = field.extent;
  Profiles result;
  for (int x = 0; x < extent.width; ++x) {
    result.horizontal.push_back(field.x[extent.index(x, extent.height / 2)]);
  }
  for (int y = 0; y < extent.height; ++y) {
    result.vertical.push_back(field.y[extent.index(extent.width / 2, y)]);
  }
  const int count = std::max(extent.width, extent.height);
  for (int i = 0; i < count; ++i) {
    const int x = spread(i, count, extent.width);
    const int y = spread(i, count, extent.height);
    const auto magnitude = [&](std::size_t at) { return std::hypot(field.x[at], field.y[at]); };
    result.falling.push_back(magnitude(extent.index(x, y)));
    result.rising.push_back(magnitude(extent.index(x, extent.height - 1 - y)));
  }
  return result;
}

LevelProfile level_profile(int level, const VectorField& field) {
  const Extent extent = field.extent;
  LevelProfile result{.level = level, .extent = extent};
  for (int x = 0; x < extent.width; ++x) {
    const std::size_t at = extent.index(x, extent.height / 2);
    result.horizontal_x.push_back(field.x[at]);
    result.horizontal_y.push_back(field.y[at]);
  }
  for (int y = 0; y < extent.height; ++y) {
    const std::size_t at = extent.index(extent.width / 2, y);
    result.vertical_x.push_back(field.x[at]);
    result.vertical_y.push_back(field.y[at]);
  }
  return result;
}

std::vector<Polyline> deformed_grid(const ReferenceField& field, int spacing) {
  const Extent extent = field.extent;
  // Enough points that a line bends where the field does, few enough to be drawn.
  const double pace = std::max(1.0, spacing / 4.0);
  std::vector<Polyline> lines;
  const auto trace = [&](int length, const auto& point) {
    Polyline line;
    const int pieces = std::max(1, static_cast<int>(std::ceil((length - 1) / pace)));
    for (int i = 0; i <= pieces; ++i) {
      append(line, point((length - 1) * static_cast<double>(i) / pieces));
    }
    lines.push_back(std::move(line));
  };
  for (int y = 0; y < extent.height; y += spacing) {
    trace(extent.width, [&](double along) { return moved(field, along, y); });
  }
  for (int x = 0; x < extent.width; x += spacing) {
    trace(extent.height, [&](double along) { return moved(field, x, along); });
  }
  return lines;
}

std::vector<Polyline> deformed_interfaces(const Scene& scene, const ReferenceField& field) {
  const Extent extent = scene.extent();
  const std::vector<float>& modulus = scene.full.modulus.values;
  EdgeGraph edges;
  for_each_site(extent, [&](int x, int y) {
    const float own = modulus[extent.index(x, y)];
    if (x + 1 < extent.width && modulus[extent.index(x + 1, y)] != own) {
      edges.add({x + 1, y}, {x + 1, y + 1});
    }
    if (y + 1 < extent.height && modulus[extent.index(x, y + 1)] != own) {
      edges.add({x, y + 1}, {x + 1, y + 1});
    }
  });
  std::vector<Polyline> lines;
  for (auto corners = edges.take_line(); !corners.empty(); corners = edges.take_line()) {
    Polyline line;
    for (const auto& [x, y] : corners) {
      append(line, moved(field, x - 0.5, y - 0.5));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

} // namespace hdmbench::figures
