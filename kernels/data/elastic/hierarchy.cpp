#include "kernels/data/elastic/hierarchy.hpp"

#include "kernels/data/elastic/set_up.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace hdmbench {

namespace {

using InFloat = ElasticInFloat;

/// Of cells that a thread makes at a time: conditions are often in a few rows.
constexpr int rows_together = 8;

/// What a coarser level has to know of a level's cells.
enum class CellKind : std::uint8_t {
  whole,  ///< described by its moments, no basis function of it cut
  masked, ///< in the list of masked cells
  empty   ///< nothing of it can move, or there is nothing of it
};

/// A level's cells without a ring; `index` of a masked one in ElasticLevel::masked.
struct CellKinds {
  Extent extent;
  std::vector<CellKind> kind;
  std::vector<std::uint32_t> index;
};

/// Of the first coarse level: a cell is cut where any of the 3 x 3 sites in it has a prescribed component.
CellKinds kinds_below_image(Extent cells, const Prescribed& prescribed, const RingedGrid& grid) {
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole), {}};
  const Extent sites = grid.sites;
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      bool any = false;
      bool all = true;
      for (int j = 2 * y; j <= std::min(2 * y + 2, sites.height - 1); ++j) {
        for (int i = 2 * x; i <= std::min(2 * x + 2, sites.width - 1); ++i) {
          for (const std::vector<std::uint8_t>& component : prescribed.component) {
            const bool is_prescribed = component[grid.index(i, j)] != 0;
            any |= is_prescribed;
            all &= is_prescribed;
          }
        }
      }
      if (any) {
        kinds.kind[cells.index(x, y)] = all ? CellKind::empty : CellKind::masked;
      }
    }
  }
  return kinds;
}

/// Nor has a cell moments with a child that has a spring.
void mask_above(CellKinds& kinds, const CellKinds& image) {
  for (int y = 0; y < image.extent.height; ++y) {
    for (int x = 0; x < image.extent.width; ++x) {
      if (image.kind[image.extent.index(x, y)] == CellKind::masked) {
        kinds.kind[kinds.extent.index(x / 2, y / 2)] = CellKind::masked;
      }
    }
  }
}

/// Of the other levels: cut where a child is.
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

void clear_cell(ElasticLevel& level, int x, int y) {
  for (std::vector<float>& moment : level.moments) {
    moment[level.grid.index(x, y)] = 0.0F;
  }
}

/// The children's matrices between the functions that may move. `prescribed` is null but on the image, whose
/// `kinds` are empty where all its cells are whole.
class Galerkin {
public:
  Galerkin(const ElasticLevel& fine, const CellKinds& kinds, const InFloat::PoissonRatio& ratio,
           const Prescribed* prescribed)
      : fine_(fine), kinds_(kinds), ratio_(ratio), prescribed_(prescribed) {}

  [[nodiscard]] CellMatrix parent(int x, int y) const {
    const Extent cells = fine_.grid.cells();
    CellMatrix sum{};
    for (int row = 0; row < 2 && 2 * y + row < cells.height; ++row) {
      for (int column = 0; column < 2 && 2 * x + column < cells.width; ++column) {
        add_child(sum, 2 * x + column, 2 * y + row, column, row);
      }
    }
    return sum;
  }

private:
  void add_child(CellMatrix& sum, int x, int y, int column, int row) const {
    const std::size_t at = fine_.grid.index(x, y);
    CellMask mask;
    mask.fill(1.0);
    if (prescribed_ != nullptr) {
      for (std::size_t i = 0; i < 8; ++i) {
        const std::size_t site = at + i / 2 % 2 + i / 4 * fine_.grid.pitch;
        mask[i] = prescribed_->component[i % 2][site] != 0 ? 0.0 : 1.0;
      }
    }
    const std::size_t cell = fine_.grid.cells().index(x, y);
    const CellKind kind = kinds_.kind.empty() ? CellKind::whole : kinds_.kind[cell];
    if (kind == CellKind::whole) {
      add_galerkin(sum, cell_matrix(fine_.cell(at), ratio_), column, row, mask);
    } else if (kind == CellKind::masked) {
      const MaskedCell& masked = fine_.masked.cells[kinds_.index[cell]];
      CellMatrix matrix{};
      std::copy(masked.stiffness.begin(), masked.stiffness.end(), matrix.begin());
      add_galerkin(sum, matrix, column, row, mask);
    }
  }

  const ElasticLevel& fine_;
  const CellKinds& kinds_;
  InFloat::PoissonRatio ratio_;
  const Prescribed* prescribed_;
};

/// Of the two halves, which rounding made different, one; column by column.
std::array<float, 64> symmetric(const CellMatrix& matrix) {
  std::array<float, 64> result{};
  for (std::size_t column = 0; column < 8; ++column) {
    for (std::size_t row = 0; row < 8; ++row) {
      result[8 * column + row] =
          static_cast<float>(matrix[8 * std::max(row, column) + std::min(row, column)]);
    }
  }
  return result;
}

/// Lists the masked cells of `kinds`, each with `stiffness_at` its place, which may look at the moments
/// there; a cell of the level that is not whole then has none.
template <typename Stiffness>
void set_masked_cells(ElasticLevel& level, CellKinds& kinds, const Stiffness& stiffness_at) {
  const Extent cells = kinds.extent;
  kinds.index.resize(cells.sites());
  std::vector<std::size_t>& row_begin = level.masked.row_begin;
  row_begin.assign(static_cast<std::size_t>(cells.height) + 1, 0);
  for (int y = 0; y < cells.height; ++y) {
    const CellKind* const row = kinds.kind.data() + cells.index(0, y);
    row_begin[static_cast<std::size_t>(y) + 1] =
        row_begin[static_cast<std::size_t>(y)] +
        static_cast<std::size_t>(std::count(row, row + cells.width, CellKind::masked));
  }
  level.masked.cells.resize(row_begin.back());
#pragma omp parallel for schedule(dynamic, rows_together) if (cells.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    std::size_t next = row_begin[static_cast<std::size_t>(y)];
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t at = cells.index(x, y);
      if (kinds.kind[at] == CellKind::whole) {
        continue;
      }
      if (kinds.kind[at] == CellKind::masked) {
        kinds.index[at] = static_cast<std::uint32_t>(next);
        level.masked.cells[next] = {.x = x, .stiffness = stiffness_at(x, y)};
        ++next;
      }
      clear_cell(level, x, y);
    }
  }
}

/// The stiffness of a site's spring.
struct SpringAt {
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;

  [[nodiscard]] bool is_none() const { return xx == 0.0 && xy == 0.0 && yy == 0.0; }
};

/// Springs of the image: each is a part of the matrix of the cell at the bottom right of its site, at the
/// last row and column of the one before. `spring_at` tells that of a site of the level.
template <typename Spring>
CellKinds add_springs(ElasticLevel& image, const InFloat::PoissonRatio& ratio, double poisson,
                      const Spring& spring_at) {
  const Extent sites = image.grid.sites;
  const Extent cells = image.grid.cells();
  const auto for_each_spring = [&](int cell_x, int cell_y, const auto& call) {
    for (int y = cell_y; y <= (cell_y + 1 == cells.height ? cell_y + 1 : cell_y); ++y) {
      for (int x = cell_x; x <= (cell_x + 1 == cells.width ? cell_x + 1 : cell_x); ++x) {
        const SpringAt spring = spring_at(sites.index(x, y));
        if (!spring.is_none()) {
          call(x - cell_x + 2 * (y - cell_y), spring);
        }
      }
    }
  };
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole), {}};
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      for_each_spring(x, y, [&](int, const SpringAt&) { kinds.kind[cells.index(x, y)] = CellKind::masked; });
    }
  }
  const double unit = force_unit(poisson);
  set_masked_cells(image, kinds, [&](int x, int y) {
    CellMatrix matrix = cell_matrix(image.cell(image.grid.index(x, y)), ratio);
    for_each_spring(x, y, [&](int corner, const SpringAt& spring) {
      const std::size_t entry = 2 * static_cast<std::size_t>(corner);
      matrix[9 * entry] += unit * spring.xx;
      matrix[9 * entry + 1] += unit * spring.xy;
      matrix[9 * entry + 8] += unit * spring.xy;
      matrix[9 * entry + 9] += unit * spring.yy;
    });
    std::array<float, 64> stiffness{};
    std::ranges::transform(matrix, stiffness.begin(), [](double value) { return static_cast<float>(value); });
    return stiffness;
  });
  return kinds;
}

bool is_coarsest(Extent sites) {
  return std::max(sites.width, sites.height) - 1 <= most_coarsest_cells;
}

std::vector<std::uint8_t> in_turn(const Prescribed& prescribed, const RingedGrid& grid) {
  std::vector<std::uint8_t> components;
  for (int y = 0; y < grid.sites.height; ++y) {
    for (int x = 0; x < grid.sites.width; ++x) {
      components.push_back(prescribed.component[0][grid.index(x, y)]);
      components.push_back(prescribed.component[1][grid.index(x, y)]);
    }
  }
  return components;
}

/// `spring_at` is null where there are no springs.
template <typename Spring>
ElasticHierarchy hierarchy_of(const Level& full, double poisson, const Spring* spring_at) {
  ElasticHierarchy hierarchy;
  hierarchy.ratio = InFloat::poisson_ratio(poisson);
  ElasticLevel& image = hierarchy.levels.emplace_back(empty_level(full.extent));
  const Prescribed prescribed(full, image.grid);
  set_image_moments(image, full);
  CellKinds kinds; // of the last level
  if (spring_at != nullptr && full.extent.width > 1 && full.extent.height > 1) {
    kinds = add_springs(image, hierarchy.ratio, poisson, *spring_at);
  }
  set_response(image, hierarchy.ratio, &prescribed);
  while (!is_coarsest(hierarchy.levels.back().grid.sites)) {
    const ElasticLevel& fine = hierarchy.levels.back();
    const bool is_image = hierarchy.levels.size() == 1;
    ElasticLevel level = empty_level({fine.grid.sites.width / 2 + 1, fine.grid.sites.height / 2 + 1});
    const Extent cells = level.grid.cells();
    set_parent_moments(level, fine);
    CellKinds coarse_kinds =
        is_image ? kinds_below_image(cells, prescribed, fine.grid) : kinds_below(cells, kinds);
    if (is_image && !kinds.kind.empty()) {
      mask_above(coarse_kinds, kinds);
    }
    const Galerkin galerkin(fine, kinds, hierarchy.ratio, is_image ? &prescribed : nullptr);
    set_masked_cells(level, coarse_kinds, [&](int x, int y) { return symmetric(galerkin.parent(x, y)); });
    set_response(level, hierarchy.ratio, nullptr);
    kinds = std::move(coarse_kinds);
    hierarchy.levels.push_back(std::move(level));
  }
  const ElasticLevel& coarsest = hierarchy.levels.back();
  hierarchy.coarsest_inverse = coarsest_inverse(
      coarsest, hierarchy.ratio,
      hierarchy.levels.size() == 1 ? in_turn(prescribed, coarsest.grid) : std::vector<std::uint8_t>{});
  return hierarchy;
}

/// The springs that confidences below 1 make.
auto springs_of(const Level& full) {
  return [&full](std::size_t at) {
    const auto stiffness = [&](float confidence) {
      return is_spring(confidence) ? spring_stiffness(full.modulus.values[at], confidence) : 0.0;
    };
    return SpringAt{stiffness(full.confidence[0][at]), 0.0, stiffness(full.confidence[1][at])};
  };
}

} // namespace

Prescribed::Prescribed(const Level& full, const RingedGrid& grid) {
  for (std::size_t xy = 0; xy < 2; ++xy) {
    component[xy].resize(grid.size());
    const std::vector<float>& confidence = xy == 0 ? full.confidence[0] : full.confidence[1];
#pragma omp parallel for if (full.extent.sites() > sites_worth_threads)
    for (int y = 0; y < full.extent.height; ++y) {
      const float* const from = confidence.data() + full.extent.index(0, y);
      std::transform(from, from + full.extent.width, component[xy].data() + grid.index(0, y),
                     [](float value) -> std::uint8_t { return value >= 1.0F ? 1 : 0; });
    }
  }
}

ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson, Springs springs) {
  const auto spring_at = springs_of(full);
  const bool pulls = springs == Springs::pull && has_springs(full);
  return hierarchy_of(full, poisson, pulls ? &spring_at : nullptr);
}

ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson, const SiteSprings& springs) {
  const auto spring_at = [&springs](std::size_t at) {
    return SpringAt{static_cast<double>(springs.xx.values[at]), static_cast<double>(springs.xy.values[at]),
                    static_cast<double>(springs.yy.values[at])};
  };
  return hierarchy_of(full, poisson, &spring_at);
}

ElasticLevel empty_level(Extent sites) {
  ElasticLevel level;
  level.grid = RingedGrid(sites);
  std::array<std::vector<float>*, 9> arrays{};
  std::ranges::transform(level.moments, arrays.begin(), [](auto& values) { return &values; });
  std::ranges::transform(level.response, arrays.begin() + level.moments.size(),
                         [](auto& values) { return &values; });
  for (std::vector<float>* const values : arrays) { // where memory is short, outside of the threads
    values->reserve(level.grid.size());
  }
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
  for (std::vector<float>* const values : arrays) {
    values->resize(level.grid.size());
  }
  return level;
}

} // namespace hdmbench
