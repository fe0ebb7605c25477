#include "kernels/data/elastic/hierarchy.hpp"

#include "kernels/data/elastic/coarsest_inverse.hpp"

#include <algorithm>
#include <cstdint>

namespace hdmbench {

namespace {

using InFloat = ElasticInFloat;

/// Below this many sites threads cost more than they bring.
constexpr std::size_t sites_worth_threads = 1 << 15;

/// Where |xx yy - xy^2| is less than this share of xx yy, the two components of a site move as one.
constexpr float least_determinant = 1e-6F;

/// What a coarser level has to know of a level's cells.
enum class CellKind : std::uint8_t {
  whole,  ///< described by its moments, no basis function of it cut
  masked, ///< in the list of masked cells
  empty   ///< nothing of it can move, or there is nothing of it
};

/// A level's cells without a ring; `index` of a masked one in the list.
struct CellKinds {
  Extent extent;
  std::vector<CellKind> kind;
  std::vector<std::uint32_t> index;
};

/// Not 0 where a component is prescribed, with the grid's ring, which is not.
struct Prescribed {
  std::array<std::vector<std::uint8_t>, 2> component;

  Prescribed(const Level& full, const RingedGrid& grid) {
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
};

ElasticLevel empty_level(Extent sites) {
  ElasticLevel level;
  level.grid = RingedGrid(sites);
  for (auto& values : level.moments) {
    values.resize(level.grid.size());
  }
  for (auto& values : level.response) {
    values.resize(level.grid.size());
  }
  return level;
}

void set_cell(ElasticLevel& level, std::size_t index, const InFloat::CellMoments& cell) {
  level.moments[0][index] = cell.m;
  level.moments[1][index] = cell.mr;
  level.moments[2][index] = cell.ms;
  level.moments[3][index] = cell.mrr;
  level.moments[4][index] = cell.mss;
  level.moments[5][index] = cell.mrs;
}

void set_image_moments(ElasticLevel& level, const Level& full) {
  const Extent cells = level.grid.cells();
#pragma omp parallel for if (full.extent.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    const float* const top = full.modulus.values.data() + full.extent.index(0, y);
    const float* const bottom = top + full.extent.width;
    for (int x = 0; x < cells.width; ++x) {
      set_cell(level, level.grid.index(x, y),
               InFloat::image_cell({top[x], top[x + 1], bottom[x], bottom[x + 1]}));
    }
  }
}

/// Children that stick out of the image lie in the ring: they add nothing.
void set_parent_moments(ElasticLevel& level, const ElasticLevel& fine) {
  const Extent cells = level.grid.cells();
#pragma omp parallel for if (level.grid.sites.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t child = fine.grid.index(2 * x, 2 * y);
      const std::size_t below = child + fine.grid.pitch;
      InFloat::CellMoments sum{0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
      sum = InFloat::with_child(sum, fine.cell(child), -1.0F, -1.0F);
      sum = InFloat::with_child(sum, fine.cell(child + 1), 1.0F, -1.0F);
      sum = InFloat::with_child(sum, fine.cell(below), -1.0F, 1.0F);
      sum = InFloat::with_child(sum, fine.cell(below + 1), 1.0F, 1.0F);
      set_cell(level, level.grid.index(x, y), sum);
    }
  }
}

/// Of the first coarse level: a cell is cut where any of the 3 x 3 sites in it has a prescribed component.
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

/// Of the other ones: cut where a child is.
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

void set_masked_cells(ElasticLevel& level, CellKinds& kinds, const Galerkin& galerkin) {
  const Extent cells = kinds.extent;
  std::vector<int> rows;
  kinds.index.resize(cells.sites());
  for (int y = 0; y < cells.height; ++y) {
    level.masked.row_begin.push_back(level.masked.cells.size());
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t at = cells.index(x, y);
      if (kinds.kind[at] != CellKind::whole) {
        set_cell(level, level.grid.index(x, y), {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F});
      }
      if (kinds.kind[at] == CellKind::masked) {
        kinds.index[at] = static_cast<std::uint32_t>(level.masked.cells.size());
        level.masked.cells.push_back({.x = x});
        rows.push_back(y);
      }
    }
  }
  level.masked.row_begin.push_back(level.masked.cells.size());
#pragma omp parallel for schedule(static) if (rows.size() > 2048)
  for (std::size_t i = 0; i < rows.size(); ++i) {
    MaskedCell& cell = level.masked.cells[i];
    const CellMatrix matrix = galerkin.parent(cell.x, rows[i]);
    for (std::size_t column = 0; column < 8; ++column) {
      for (std::size_t row = 0; row < 8; ++row) { // of the two halves, which rounding made different, one
        cell.stiffness[8 * column + row] =
            static_cast<float>(matrix[8 * std::max(row, column) + std::min(row, column)]);
      }
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
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole),
                  std::vector<std::uint32_t>(cells.sites())};
  const auto cell_of = [&](int x, int y) {
    return cells.index(std::min(x, cells.width - 1), std::min(y, cells.height - 1));
  };
  const auto for_each_spring = [&](const auto& call) {
    for (int y = 0; y < sites.height; ++y) {
      for (int x = 0; x < sites.width; ++x) {
        const SpringAt spring = spring_at(sites.index(x, y));
        if (!spring.is_none()) {
          call(x, y, spring);
        }
      }
    }
  };
  for_each_spring([&](int x, int y, const SpringAt&) { kinds.kind[cell_of(x, y)] = CellKind::masked; });
  std::vector<CellMatrix> matrices;
  for (int y = 0; y < cells.height; ++y) {
    image.masked.row_begin.push_back(image.masked.cells.size());
    for (int x = 0; x < cells.width; ++x) {
      if (kinds.kind[cells.index(x, y)] == CellKind::masked) {
        kinds.index[cells.index(x, y)] = static_cast<std::uint32_t>(matrices.size());
        matrices.push_back(cell_matrix(image.cell(image.grid.index(x, y)), ratio));
        image.masked.cells.push_back({.x = x});
        set_cell(image, image.grid.index(x, y), {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F});
      }
    }
  }
  image.masked.row_begin.push_back(image.masked.cells.size());
  const double unit = force_unit(poisson);
  for_each_spring([&](int x, int y, const SpringAt& spring) {
    const int column = std::min(x, cells.width - 1);
    const int row = std::min(y, cells.height - 1);
    const auto entry = static_cast<std::size_t>(2 * ((x - column) + 2 * (y - row)));
    CellMatrix& matrix = matrices[kinds.index[cells.index(column, row)]];
    matrix[9 * entry] += unit * spring.xx;
    matrix[9 * entry + 1] += unit * spring.xy;
    matrix[9 * entry + 8] += unit * spring.xy;
    matrix[9 * entry + 9] += unit * spring.yy;
  });
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    std::ranges::transform(matrices[i], image.masked.cells[i].stiffness.begin(),
                           [](double value) { return static_cast<float>(value); });
  }
  return kinds;
}

/// Relaxation times the inverse; of a matrix of rank one its pseudo-inverse.
InFloat::SiteResponse response_of(const InFloat::SiteStiffness& site) {
  const auto relaxation = static_cast<float>(elastic_relaxation);
  const float trace = site.xx + site.yy;
  const float determinant = site.xx * site.yy - site.xy * site.xy;
  if (determinant > least_determinant * (site.xx * site.yy)) {
    const float scale = relaxation / determinant;
    return {scale * site.yy, -scale * site.xy, scale * site.xx};
  }
  const float scale = trace > 0.0F ? relaxation / (trace * trace) : 0.0F;
  return {scale * site.xx, scale * site.xy, scale * site.yy};
}

void set_response(ElasticLevel& level, const InFloat::PoissonRatio& ratio, const Prescribed* prescribed) {
  const Extent sites = level.grid.sites;
  const std::size_t pitch = level.grid.pitch;
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
  for (int y = 0; y < sites.height; ++y) {
    std::vector<InFloat::SiteStiffness> row(static_cast<std::size_t>(sites.width));
    for (int x = 0; x < sites.width; ++x) {
      const std::size_t at = level.grid.index(x, y);
      InFloat::SiteStiffness sum{0.0F, 0.0F, 0.0F};
      sum = InFloat::with_cell(sum, level.cell(at - pitch - 1), 1.0F, 1.0F, ratio);
      sum = InFloat::with_cell(sum, level.cell(at - pitch), -1.0F, 1.0F, ratio);
      sum = InFloat::with_cell(sum, level.cell(at - 1), 1.0F, -1.0F, ratio);
      row[static_cast<std::size_t>(x)] = InFloat::with_cell(sum, level.cell(at), -1.0F, -1.0F, ratio);
    }
    for (int above = 1; above >= 0; --above) { // the row of cells above the sites, then that below
      const auto [first, last] = level.masked.row(y - above);
      for (std::size_t i = first; i < last; ++i) {
        const MaskedCell& cell = level.masked.cells[i];
        for (std::size_t right = 0; right < 2; ++right) {
          const std::size_t own = 4 * static_cast<std::size_t>(above) + 2 * right;
          InFloat::SiteStiffness& site = row[static_cast<std::size_t>(cell.x) + right];
          site.xx += cell.stiffness[8 * own + own];
          site.xy += cell.stiffness[8 * own + own + 1];
          site.yy += cell.stiffness[8 * (own + 1) + own + 1];
        }
      }
    }
    for (int x = 0; x < sites.width; ++x) {
      const std::size_t at = level.grid.index(x, y);
      InFloat::SiteStiffness& site = row[static_cast<std::size_t>(x)];
      if (prescribed != nullptr) {
        const bool free_x = prescribed->component[0][at] == 0;
        const bool free_y = prescribed->component[1][at] == 0;
        site.xx = free_x ? site.xx : 0.0F;
        site.yy = free_y ? site.yy : 0.0F;
        site.xy = free_x && free_y ? site.xy : 0.0F;
      }
      const InFloat::SiteResponse response = response_of(site);
      level.response[0][at] = response.xx;
      level.response[1][at] = response.xy;
      level.response[2][at] = response.yy;
    }
  }
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
ElasticHierarchy make_hierarchy(const Level& full, double poisson, const Spring* spring_at) {
  ElasticHierarchy hierarchy;
  hierarchy.ratio = InFloat::poisson_ratio(poisson);
  hierarchy.levels.push_back(empty_level(full.extent));
  const Prescribed prescribed(full, hierarchy.levels.front().grid);
  set_image_moments(hierarchy.levels.front(), full);
  CellKinds kinds;
  const bool has_cells = full.extent.width > 1 && full.extent.height > 1;
  if (spring_at != nullptr && has_cells) {
    kinds = add_springs(hierarchy.levels.front(), hierarchy.ratio, poisson, *spring_at);
  }
  set_response(hierarchy.levels.front(), hierarchy.ratio, &prescribed);
  for (;;) {
    const ElasticLevel& fine = hierarchy.levels.back();
    const Extent cells = fine.grid.cells();
    if (std::max(cells.width, cells.height) <= most_coarsest_cells) {
      break;
    }
    const bool is_image = hierarchy.levels.size() == 1;
    const Extent coarse_cells{(cells.width + 1) / 2, (cells.height + 1) / 2};
    ElasticLevel level = empty_level({coarse_cells.width + 1, coarse_cells.height + 1});
    set_parent_moments(level, fine);
    CellKinds coarse_kinds =
        is_image ? kinds_below_image(coarse_cells, prescribed, fine.grid) : kinds_below(coarse_cells, kinds);
    if (is_image && !kinds.kind.empty()) {
      mask_above(coarse_kinds, kinds);
    }
    set_masked_cells(level, coarse_kinds,
                     Galerkin(fine, kinds, hierarchy.ratio, is_image ? &prescribed : nullptr));
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

} // namespace

ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson, Springs springs) {
  const auto spring_at = [&full](std::size_t at) {
    const auto stiffness = [&](float confidence) {
      return is_spring(confidence) ? spring_stiffness(full.modulus.values[at], confidence) : 0.0;
    };
    return SpringAt{stiffness(full.confidence.x[at]), 0.0, stiffness(full.confidence.y[at])};
  };
  return make_hierarchy(full, poisson, springs == Springs::pull && has_springs(full) ? &spring_at : nullptr);
}

ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson, const SiteSprings& springs) {
  const auto spring_at = [&springs](std::size_t at) {
    return SpringAt{static_cast<double>(springs.xx.values[at]), static_cast<double>(springs.xy.values[at]),
                    static_cast<double>(springs.yy.values[at])};
  };
  return make_hierarchy(full, poisson, &spring_at);
}

} // namespace hdmbench
