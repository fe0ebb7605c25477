#include "kernels/data/elastic/hierarchy.hpp"

#include "kernels/data/elastic/cell_kinds.hpp"
#include "kernels/data/elastic/coarsest_inverse.hpp"
#include "kernels/data/elastic/hierarchy_part.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace hdmbench {

namespace {

using InFloat = ElasticInFloat;

/// Where |xx yy - xy^2| is less than this share of xx yy, the two components of a site move as one.
constexpr float least_determinant = 1e-6F;

constexpr Extent half_as_many(Extent sites) {
  return {sites.width / 2 + 1, sites.height / 2 + 1};
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
    // Of the two halves, which rounding made different, one.
    for (std::size_t column = 0; column < 8; ++column) {
      for (std::size_t row = column + 1; row < 8; ++row) {
        sum[8 * column + row] = sum[8 * row + column];
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

/// Lists the masked cells of `kinds`, each with `matrix_at` its place; other cells of the level that are not
/// whole have nothing.
template <typename Matrix>
void set_masked_cells(ElasticLevel& level, CellKinds& kinds, const Matrix& matrix_at) {
  const Extent cells = kinds.extent;
  std::vector<MaskedCell>& masked = level.masked.cells;
  std::vector<int> rows;
  rows.reserve(static_cast<std::size_t>(std::ranges::count(kinds.kind, CellKind::masked)));
  masked.reserve(rows.capacity());
  kinds.index.resize(cells.sites());
  for (int y = 0; y < cells.height; ++y) {
    level.masked.row_begin.push_back(masked.size());
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t at = cells.index(x, y);
      if (kinds.kind[at] == CellKind::masked) {
        kinds.index[at] = static_cast<std::uint32_t>(masked.size());
        masked.push_back({.x = x});
        rows.push_back(y);
      }
    }
  }
  level.masked.row_begin.push_back(masked.size());
#pragma omp parallel for schedule(static) if (rows.size() > 2048)
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::ranges::transform(matrix_at(masked[i].x, rows[i]), masked[i].stiffness.begin(),
                           [](double value) { return static_cast<float>(value); });
  }
  for (std::size_t at = 0; at < kinds.kind.size(); ++at) {
    if (kinds.kind[at] != CellKind::whole) {
      const auto width = static_cast<std::size_t>(cells.width);
      set_cell(level, level.grid.index(static_cast<int>(at % width), static_cast<int>(at / width)),
               {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F});
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
      const auto entry = static_cast<std::size_t>(2 * corner);
      matrix[9 * entry] += unit * spring.xx;
      matrix[9 * entry + 1] += unit * spring.xy;
      matrix[9 * entry + 8] += unit * spring.xy;
      matrix[9 * entry + 9] += unit * spring.yy;
    });
    return matrix;
  });
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

/// Makes levels, each from the one before.
class HierarchyMaker {
public:
  /// `spring_at` is null where there are no springs.
  template <typename Spring>
  HierarchyMaker(const Level& full, double poisson, const Spring* spring_at) {
    hierarchy_.ratio = InFloat::poisson_ratio(poisson);
    ElasticLevel& image = hierarchy_.levels.emplace_back(empty_level(full.extent));
    prescribed_.emplace(full, image.grid);
    set_image_moments(image, full);
    const bool has_cells = full.extent.width > 1 && full.extent.height > 1;
    if (spring_at != nullptr && has_cells) {
      kinds_ = add_springs(image, hierarchy_.ratio, poisson, *spring_at);
    }
    set_response(image, hierarchy_.ratio, &*prescribed_);
  }
  /// From a level that is not the image and has its cells.
  HierarchyMaker(ElasticHierarchy above, ElasticLevel level, CellKinds kinds)
      : hierarchy_(std::move(above)), kinds_(std::move(kinds)) {
    set_response(level, hierarchy_.ratio, nullptr);
    hierarchy_.levels.push_back(std::move(level));
  }

  [[nodiscard]] bool has_coarser() const {
    return coarser_elastic_sites(hierarchy_.levels.back().grid.sites).has_value();
  }
  void add_coarser() {
    const ElasticLevel& fine = hierarchy_.levels.back();
    const bool is_image = hierarchy_.levels.size() == 1;
    ElasticLevel level = empty_level(half_as_many(fine.grid.sites));
    const Extent cells = level.grid.cells();
    set_parent_moments(level, fine);
    CellKinds kinds =
        is_image ? kinds_below_image(cells, *prescribed_, fine.grid) : kinds_below(cells, kinds_);
    if (is_image && !kinds_.kind.empty()) {
      mask_above(kinds, kinds_);
    }
    const Galerkin galerkin(fine, kinds_, hierarchy_.ratio, is_image ? &*prescribed_ : nullptr);
    set_masked_cells(level, kinds, [&](int x, int y) { return galerkin.parent(x, y); });
    set_response(level, hierarchy_.ratio, nullptr);
    kinds_ = std::move(kinds);
    hierarchy_.levels.push_back(std::move(level));
  }

  /// All that are coarser, and the inverse of the last.
  [[nodiscard]] ElasticHierarchy take_all() {
    while (has_coarser()) {
      add_coarser();
    }
    const ElasticLevel& coarsest = hierarchy_.levels.back();
    hierarchy_.coarsest_inverse = coarsest_inverse(
        coarsest, hierarchy_.ratio,
        hierarchy_.levels.size() == 1 ? in_turn(*prescribed_, coarsest.grid) : std::vector<std::uint8_t>{});
    return std::move(hierarchy_);
  }
  /// Those that there are.
  [[nodiscard]] ElasticPart take_part() { return {std::move(hierarchy_), std::move(kinds_)}; }

private:
  ElasticHierarchy hierarchy_;
  std::optional<Prescribed> prescribed_; ///< none where the first level is not the image
  CellKinds kinds_;                      ///< of the last level
};

/// The springs that confidences below 1 make.
auto springs_of(const Level& full) {
  return [&full](std::size_t at) {
    const auto stiffness = [&](float confidence) {
      return is_spring(confidence) ? spring_stiffness(full.modulus.values[at], confidence) : 0.0;
    };
    return SpringAt{stiffness(full.confidence.x[at]), 0.0, stiffness(full.confidence.y[at])};
  };
}

HierarchyMaker maker_of(const Level& full, double poisson, Springs springs) {
  const auto spring_at = springs_of(full);
  return {full, poisson, springs == Springs::pull && has_springs(full) ? &spring_at : nullptr};
}

} // namespace

std::optional<Extent> coarser_elastic_sites(Extent sites) {
  const bool is_coarsest = std::max(sites.width, sites.height) - 1 <= most_coarsest_cells;
  return is_coarsest ? std::nullopt : std::optional(half_as_many(sites));
}

ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson, Springs springs) {
  ElasticHierarchy hierarchy = maker_of(full, poisson, springs).take_all();
  hierarchy.origin = {.image = &full, .poisson = poisson, .springs = springs};
  return hierarchy;
}

ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson, const SiteSprings& springs) {
  const auto spring_at = [&springs](std::size_t at) {
    return SpringAt{static_cast<double>(springs.xx.values[at]), static_cast<double>(springs.xy.values[at]),
                    static_cast<double>(springs.yy.values[at])};
  };
  return HierarchyMaker(full, poisson, &spring_at).take_all();
}

ElasticPart make_elastic_part(const Level& part, double poisson, Springs springs, int levels) {
  HierarchyMaker maker = maker_of(part, poisson, springs);
  for (int level = 1; level < levels; ++level) {
    maker.add_coarser();
  }
  ElasticPart result = maker.take_part();
  constexpr Extent least{2, 2};
  result.hierarchy.levels.push_back(empty_level(least));
  result.hierarchy.coarsest_inverse.resize(4 * least.sites() * least.sites());
  return result;
}

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

ElasticHierarchy make_coarse_elastic(ElasticLevel finest, CellKinds kinds,
                                     const ElasticInFloat::PoissonRatio& ratio, int number) {
  ElasticHierarchy above;
  above.ratio = ratio;
  for (int level = 0; level < number; ++level) {
    above.levels.push_back(empty_level({finest.grid.sites.width, 2}));
  }
  return HierarchyMaker(std::move(above), std::move(finest), std::move(kinds)).take_all();
}

} // namespace hdmbench
