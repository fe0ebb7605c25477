#include "harness/judge/diagnosis/regions.hpp"

#include "harness/scene/sites.hpp"

namespace hdmbench {

Regions find_regions(const ScalarField& field) {
  const Extent extent = field.extent;
  Regions regions{.all = {}, .of_site = std::vector<int>(extent.sites(), -1)};
  struct Position {
    int x, y;
  };
  std::vector<Position> waiting;
  for (int y0 = 0; y0 < extent.height; ++y0) {
    for (int x0 = 0; x0 < extent.width; ++x0) {
      const std::size_t first = extent.index(x0, y0);
      if (regions.of_site[first] >= 0) {
        continue;
      }
      const int number = static_cast<int>(regions.all.size());
      Region region{.left = x0, .right = x0, .top = y0, .bottom = y0};
      regions.of_site[first] = number;
      waiting.push_back({x0, y0});
      while (!waiting.empty()) {
        const Position at = waiting.back();
        waiting.pop_back();
        ++region.sites;
        region = {.left = std::min(region.left, at.x),
                  .right = std::max(region.right, at.x),
                  .top = std::min(region.top, at.y),
                  .bottom = std::max(region.bottom, at.y),
                  .sites = region.sites};
        const auto visit = [&](int x, int y) {
          const bool is_inside = x >= 0 && y >= 0 && x < extent.width && y < extent.height;
          const std::size_t next = is_inside ? extent.index(x, y) : first;
          if (regions.of_site[next] < 0 && field.values[next] == field.values[first]) {
            regions.of_site[next] = number;
            waiting.push_back({x, y});
          }
        };
        visit(at.x - 1, at.y);
        visit(at.x + 1, at.y);
        visit(at.x, at.y - 1);
        visit(at.x, at.y + 1);
      }
      regions.all.push_back(region);
    }
  }
  return regions;
}

std::vector<int> distance_to_nearest(Extent extent, std::span<const float> counted) {
  const int beyond = extent.width + extent.height;
  std::vector<int> distance(extent.sites());
  for (std::size_t i = 0; i < distance.size(); ++i) {
    distance[i] = counted[i] > 0.0F ? 0 : beyond;
  }
  // Two raster scans are exact for this metric (Rosenfeld and Pfaltz 1966).
  const auto shorten = [&](int x, int y, int nx, int ny) {
    if (nx >= 0 && ny >= 0 && nx < extent.width && ny < extent.height) {
      int& own = distance[extent.index(x, y)];
      own = std::min(own, distance[extent.index(nx, ny)] + 1);
    }
  };
  for_each_site(extent, [&](int x, int y) {
    shorten(x, y, x - 1, y);
    shorten(x, y, x - 1, y - 1);
    shorten(x, y, x, y - 1);
    shorten(x, y, x + 1, y - 1);
  });
  for (int y = extent.height - 1; y >= 0; --y) {
    for (int x = extent.width - 1; x >= 0; --x) {
      shorten(x, y, x + 1, y);
      shorten(x, y, x + 1, y + 1);
      shorten(x, y, x, y + 1);
      shorten(x, y, x - 1, y + 1);
    }
  }
  return distance;
}

} // namespace hdmbench
