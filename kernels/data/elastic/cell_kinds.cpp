#include "kernels/data/elastic/cell_kinds.hpp"

#include <algorithm>
#include <functional>

namespace hdmbench {

Prescribed::Prescribed(const Level& full, const RingedGrid& grid) {
  for (std::size_t xy = 0; xy < 2; ++xy) {
    component[xy].resize(grid.size());
    const std::vector<float>& confidence = xy == 0 ? full.confidence.x : full.confidence.y;
#pragma omp parallel for if (full.extent.sites() > sites_worth_threads)
    for (int y = 0; y < full.extent.height; ++y) {
      const float* const from = confidence.data() + full.extent.index(0, y);
      std::transform(from, from + full.extent.width, component[xy].data() + grid.index(0, y),
                     [](float value) -> std::uint8_t { return value >= 1.0F ? 1 : 0; });
    }
  }
}

CellKinds kinds_below_image(Extent cells, const Prescribed& prescribed, const RingedGrid& grid) {
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole), {}};
  const int width = grid.sites.width;
#pragma omp parallel for if (grid.sites.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    // Of the three sites below each other in the cell, whether a component of them is prescribed, and all.
    std::vector<std::uint8_t> any(static_cast<std::size_t>(width));
    std::vector<std::uint8_t> all(static_cast<std::size_t>(width), 1);
    for (int j = 2 * y; j <= std::min(2 * y + 2, grid.sites.height - 1); ++j) {
      for (const std::vector<std::uint8_t>& component : prescribed.component) {
        const std::uint8_t* const row = component.data() + grid.index(0, j);
        std::transform(row, row + width, any.begin(), any.begin(), std::bit_or<>());
        std::transform(row, row + width, all.begin(), all.begin(), std::bit_and<>());
      }
    }
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t left = 2 * static_cast<std::size_t>(x);
      const auto right = static_cast<std::size_t>(std::min(2 * x + 2, width - 1));
      if ((any[left] | any[left + 1] | any[right]) != 0) {
        const bool held = (all[left] & all[left + 1] & all[right]) != 0;
        kinds.kind[cells.index(x, y)] = held ? CellKind::empty : CellKind::masked;
      }
    }
  }
  return kinds;
}

void mask_above(CellKinds& kinds, const CellKinds& image) {
  for (int y = 0; y < image.extent.height; ++y) {
    for (int x = 0; x < image.extent.width; ++x) {
      if (image.kind[image.extent.index(x, y)] == CellKind::masked) {
        kinds.kind[kinds.extent.index(x / 2, y / 2)] = CellKind::masked;
      }
    }
  }
}

CellKinds kinds_below(Extent cells, const CellKinds& fine) {
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites()), {}};
#pragma omp parallel for if (fine.extent.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    const CellKind* const top = fine.kind.data() + fine.extent.index(0, 2 * y);
    const CellKind* const bottom =
        fine.kind.data() + fine.extent.index(0, std::min(2 * y + 1, fine.extent.height - 1));
    for (int x = 0; x < cells.width; ++x) {
      const int left = 2 * x;
      const int right = std::min(2 * x + 1, fine.extent.width - 1);
      const CellKind first = top[left];
      const bool alike = top[right] == first && bottom[left] == first && bottom[right] == first;
      kinds.kind[cells.index(x, y)] = alike ? first : CellKind::masked;
    }
  }
  return kinds;
}

} // namespace hdmbench
