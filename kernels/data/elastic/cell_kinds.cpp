#include "kernels/data/elastic/cell_kinds.hpp"

#include <algorithm>

namespace hdmbench {

Prescribed::Prescribed(const Level& full, const RingedGrid& grid) {
  for (std::size_t xy = 0; xy < 2; ++xy) {
    component[xy].resize(grid.size());
    const std::vector<float>& confidence = xy == 0 ? full.confidence.x : full.confidence.y;
    for (int y = 0; y < full.extent.height; ++y) {
      const float* const from = confidence.data() + full.extent.index(0, y);
      std::transform(from, from + full.extent.width, component[xy].data() + grid.index(0, y),
                     [](float value) -> std::uint8_t { return value >= 1.0F ? 1 : 0; });
    }
  }
}

CellKinds kinds_below_image(Extent cells, const Prescribed& prescribed, const RingedGrid& grid) {
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole), {}};
#pragma omp parallel for if (grid.sites.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      int sites = 0;
      int held = 0; // components
      for (int j = 2 * y; j <= std::min(2 * y + 2, grid.sites.height - 1); ++j) {
        for (int i = 2 * x; i <= std::min(2 * x + 2, grid.sites.width - 1); ++i) {
          const std::size_t at = grid.index(i, j);
          held += prescribed.component[0][at] + prescribed.component[1][at];
          ++sites;
        }
      }
      if (held > 0) {
        kinds.kind[cells.index(x, y)] = held == 2 * sites ? CellKind::empty : CellKind::masked;
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
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole), {}};
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      bool whole = true;
      bool empty = true;
      for (int j = 2 * y; j < std::min(2 * y + 2, fine.extent.height); ++j) {
        for (int i = 2 * x; i < std::min(2 * x + 2, fine.extent.width); ++i) {
          const CellKind child = fine.kind[fine.extent.index(i, j)];
          whole = whole && child == CellKind::whole;
          empty = empty && child == CellKind::empty;
        }
      }
      if (!whole) {
        kinds.kind[cells.index(x, y)] = empty ? CellKind::empty : CellKind::masked;
      }
    }
  }
  return kinds;
}

} // namespace hdmbench
