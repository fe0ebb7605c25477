#include "kernels/data/elastic/hierarchy.hpp"

#include "kernels/data/elastic/set_up.hpp"
#include "kernels/data/interruption.hpp"
#include "kernels/data/modulus.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace hdmbench {

namespace {

/// Rows of cells that a thread makes at a time: conditions are often in a few.
constexpr int rows_together = 8;
constexpr std::size_t cells_worth_threads = sites_worth_threads / 8;
/// Masked cells that a thread makes at a time. A matrix takes microseconds, so that a few are worth threads.
constexpr std::size_t masked_together = 8;

/// call(place of its first cell, y, z) for every row of cells, a thread a row.
template <typename Call>
void for_each_row(Extent cells, const Call& call) {
  const int rows = cells.height * cells.depth;
#pragma omp parallel for schedule(dynamic, rows_together) if (cells.sites() > cells_worth_threads)
  for (int row = 0; row < rows; ++row) {
    call(cells.index(0, row), row % cells.height, row / cells.height);
  }
}
/// call(place of the cell, its coordinates) for every cell.
template <typename Call>
void for_each_cell(Extent cells, const Call& call) {
  for_each_row(cells, [&](std::size_t first, int y, int z) {
    for (int x = 0; x < cells.width; ++x) {
      call(first + static_cast<std::size_t>(x), x, y, z);
    }
  });
}

/// What conditions make of a coarse level's cells. One is cut where a coarse function of it is at home on a
/// site with a prescribed component and may move there. `fine` are the prescribed components of the finer
/// level, `coarse` of this one (null: none), `children` the finer level's kinds, empty where all are whole.
template <std::size_t axes>
CellKinds kinds_of(Extent cells, const RingedGrid& grid, const Prescribed* fine, const Prescribed* coarse,
                   const RingedGrid& coarse_grid, const Stride& stride, const CellKinds& children) {
  const auto halved = static_cast<unsigned>(halved_axes(stride));
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole), {}};
  constexpr std::size_t corners = std::size_t{1} << axes;
  const auto is_cut = [&](int x, int y, int z) {
    const std::size_t at = coarse_grid.index(x, y, z);
    const std::size_t fine_at = grid.index(stride[0] * x, stride[1] * y, stride[2] * z);
    for (std::size_t i = 0; i < axes * corners * corners; ++i) {
      const std::size_t corner = i / corners % corners; // whose function reaches the sites of its child
      const std::size_t site = fine_at + grid.to_corner(corner) + grid.to_corner(i % corners & halved);
      const std::size_t axis = i / corners / corners;
      if (fine->component[axis][site] != 0 &&
          coarse->component[axis][at + coarse_grid.to_corner(corner)] == 0) {
        return true;
      }
    }
    return false;
  };
  for_each_row(cells, [&](std::size_t first, int y, int z) {
    const auto there = [&](int from, std::size_t axis) {
      return std::min(stride[axis] + 1, grid.sites.sides()[axis] - stride[axis] * from);
    };
    const int width = grid.sites.width;
    const int planes = axes == 3 ? there(z, 2) : 1;
    const int components = static_cast<int>(axes) * there(y, 1) * planes;      // of a column
    std::vector<std::uint8_t> prescribed(static_cast<std::size_t>(width) + 2); // so many of each column
    for (int line = 0; fine != nullptr && line < components; ++line) {
      const int row = line / static_cast<int>(axes);
      const std::uint8_t* const from =
          fine->component[static_cast<std::size_t>(line) % axes].data() +
          grid.index(0, stride[1] * y + row / planes, stride[2] * z + row % planes);
      std::transform(from, from + width, prescribed.begin(), prescribed.begin(), std::plus<>());
    }
    for (int x = 0; x < cells.width; ++x) {
      const std::uint8_t* const columns = prescribed.data() + stride[0] * x;
      const int count = std::accumulate(columns, columns + stride[0] + 1, 0);
      const bool all = count == components * there(x, 0);
      const bool any = count > 0 && (coarse == nullptr || is_cut(x, y, z));
      std::array<bool, 3> found{false, any && !all, all}; // by CellKind
      if (!children.kind.empty()) {
        for (std::size_t child = 0; child < corners; ++child) {
          const auto bit = [&](std::size_t axis) { return static_cast<int>(child >> axis & 1); };
          const Extent fine_cells = children.extent;
          const int i = stride[0] * x + bit(0);
          const int j = stride[1] * y + bit(1);
          const int k = stride[2] * z + bit(2);
          if ((child & ~halved) == 0 && i < fine_cells.width && j < fine_cells.height &&
              k < fine_cells.depth) {
            const CellKind kind = children.kind[fine_cells.index(i, j, k)];
            found[static_cast<std::size_t>(kind)] |= !all || kind == CellKind::masked;
          }
        }
      }
      const bool masked = found[static_cast<std::size_t>(CellKind::masked)];
      const bool empty = found[static_cast<std::size_t>(CellKind::empty)];
      const bool whole = found[static_cast<std::size_t>(CellKind::whole)];
      kinds.kind[first + static_cast<std::size_t>(x)] = masked || (empty && whole) ? CellKind::masked
                                                        : empty                    ? CellKind::empty
                                                                                   : CellKind::whole;
    }
  });
  return kinds;
}

/// Whether two cells that are whole have the same moments.
bool are_alike(const ElasticLevel& level, std::size_t a, std::size_t b) {
  const std::size_t sites = level.moments.size() == 1 ? 8 : 1; // that one array has of a cell
  return std::ranges::all_of(level.moments, [&](const std::vector<float>& values) {
    bool same = true;
    for (std::size_t site = 0; site < sites; ++site) {
      const std::size_t to = level.grid.to_corner(site);
      same &= values[a + to] == values[b + to];
    }
    return same;
  });
}

/// The children's matrices between the functions that may move. `prescribed` is null where all may; `kinds`
/// are empty where all cells are whole.
CellMatrix galerkin(const ElasticLevel& fine, const Stride& stride, const CellKinds& kinds,
                    const Prescribed* prescribed, int x, int y, int z) {
  const auto halved = static_cast<unsigned>(halved_axes(stride));
  const std::size_t axes = fine.grid.axes();
  const Extent cells = fine.grid.cells();
  CellMatrix sum(axes);
  CellMatrix whole(axes);
  std::optional<std::size_t> made; // the cell that `whole` is the matrix of: children are often alike
  for (std::size_t child = 0; child < std::size_t{1} << axes; ++child) {
    const auto bit = [&](std::size_t axis) { return static_cast<int>(child >> axis & 1); };
    const int i = stride[0] * x + bit(0);
    const int j = stride[1] * y + bit(1);
    const int k = stride[2] * z + bit(2);
    if ((child & ~halved) != 0 || i >= cells.width || j >= cells.height || k >= cells.depth) {
      continue;
    }
    const std::size_t at = fine.grid.index(i, j, k);
    CellMask mask;
    mask.fill(1.0);
    for (std::size_t c = 0; prescribed != nullptr && c < sum.components; ++c) {
      mask[c] = prescribed->component[c % axes][at + fine.grid.to_corner(c / axes)] != 0 ? 0.0 : 1.0;
    }
    const std::size_t cell = cells.index(i, j, k);
    const CellKind kind = kinds.kind.empty() ? CellKind::whole : kinds.kind[cell];
    if (kind == CellKind::whole) {
      if (!made || !are_alike(fine, *made, at)) {
        whole = cell_matrix(fine, at);
      }
      made = at;
      add_galerkin(sum, whole, child, mask, halved);
    } else if (kind == CellKind::masked) {
      CellMatrix matrix(axes);
      std::copy_n(fine.masked.matrix(kinds.index[cell]), sum.components * sum.components,
                  matrix.values.begin());
      add_galerkin(sum, matrix, child, mask, halved);
    }
  }
  return sum;
}

/// Lists the masked cells of `kinds`, each with matrix_at(x, y, z), which may look at the moments there; a
/// cell of the level that is not whole then has none. Of the two halves of a matrix, which rounding made
/// different, the upper one counts.
template <typename Matrix>
void set_masked_cells(ElasticLevel& level, CellKinds& kinds, const Matrix& matrix_at) {
  const Extent cells = kinds.extent;
  MaskedCells& masked = level.masked;
  kinds.index.resize(cells.sites());
  masked.components = level.grid.axes() << level.grid.axes();
  masked.rows = static_cast<std::size_t>(cells.height);
  masked.begin.assign(1, 0);
  std::vector<int> row_of; // of each masked cell
  for (int row = 0; row < cells.height * cells.depth; ++row) {
    const std::size_t first = cells.index(0, row);
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t cell = first + static_cast<std::size_t>(x);
      if (kinds.kind[cell] == CellKind::masked) {
        kinds.index[cell] = static_cast<std::uint32_t>(masked.x.size());
        masked.x.push_back(x);
        row_of.push_back(row);
      }
    }
    masked.begin.push_back(masked.x.size());
  }
  const std::size_t size = masked.components;
  masked.stiffness.resize(masked.x.size() * size * size);
#pragma omp parallel for schedule(dynamic, masked_together) if (masked.x.size() > masked_together)
  for (std::size_t i = 0; i < masked.x.size(); ++i) {
    const CellMatrix matrix = matrix_at(masked.x[i], row_of[i] % cells.height, row_of[i] / cells.height);
    float* const to = masked.stiffness.data() + i * size * size;
    for (std::size_t column = 0; column < size; ++column) {
      for (std::size_t row = 0; row < size; ++row) {
        to[size * column + row] = static_cast<float>(matrix.at(std::max(row, column), std::min(row, column)));
      }
    }
  }
  if (level.moments.size() > 1) {
    for_each_cell(cells, [&](std::size_t cell, int x, int y, int z) {
      if (kinds.kind[cell] != CellKind::whole) {
        for (std::vector<float>& moment : level.moments) {
          moment[level.grid.index(x, y, z)] = 0.0F;
        }
      }
    });
  }
}

/// The stiffness of a site's spring: symmetric_entry() of it.
using Spring = std::array<double, 6>;

/// Springs of the image: each is a part of the matrix of the cell at the far corner of its site, at the last
/// row, column and plane of the one before. `spring_at` tells that of a site of the level.
template <typename SpringAt>
CellKinds add_springs(ElasticLevel& image, double unit, const SpringAt& spring_at) {
  const Extent sites = image.grid.sites;
  const Extent cells = image.grid.cells();
  const std::size_t axes = sites.axes();
  const auto for_each_spring = [&](int cell_x, int cell_y, int cell_z, const auto& call) {
    for (std::size_t corner = 0; corner < std::size_t{1} << axes; ++corner) {
      const auto bit = [&](std::size_t axis) { return static_cast<int>(corner >> axis & 1); };
      if ((bit(0) == 0 || cell_x + 1 == cells.width) && (bit(1) == 0 || cell_y + 1 == cells.height) &&
          (bit(2) == 0 || cell_z + 1 == cells.depth)) {
        const Spring spring = spring_at(sites.index(cell_x + bit(0), cell_y + bit(1), cell_z + bit(2)));
        if (spring != Spring{}) {
          call(corner, spring);
        }
      }
    }
  };
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites(), CellKind::whole), {}};
  for_each_cell(cells, [&](std::size_t cell, int x, int y, int z) {
    for_each_spring(x, y, z, [&](std::size_t, const Spring&) { kinds.kind[cell] = CellKind::masked; });
  });
  set_masked_cells(image, kinds, [&](int x, int y, int z) {
    CellMatrix matrix = cell_matrix(image, image.grid.index(x, y, z));
    for_each_spring(x, y, z, [&](std::size_t corner, const Spring& spring) {
      for (std::size_t a = 0; a < axes; ++a) {
        for (std::size_t b = 0; b < axes; ++b) {
          matrix.at(axes * corner + a, axes * corner + b) += unit * spring[symmetric_entry(axes, a, b)];
        }
      }
    });
    return matrix;
  });
  return kinds;
}

bool is_coarsest(Extent sites) {
  return std::max({sites.width, sites.height, sites.depth}) - 1 <= most_coarsest_cells(sites.axes());
}
bool has_coarser(const ElasticLevel& level) {
  return !is_coarsest(level.grid.sites);
}

/// ElasticLevel::bend of the image.
float bend_of(const ElasticBody& body) {
  return body.level.extent.axes() == 2 || body.model.integration == Integration::full ? 1.0F : 0.0F;
}

/// Makes the sites of levels respond, one level after the other from the image on.
class Responses {
public:
  explicit Responses(const ElasticBody& body)
      : full_(body.level), moduli_{body.whole_modulus != nullptr ? *body.whole_modulus : body.level.modulus,
                                   body.first},
        poisson_(body.model.poisson), sides_(body.level.sides), contrast_(contrast_of(moduli_.whole)),
        bend_(bend_of(body)) {
    prepare();
  }

  [[nodiscard]] const std::array<double, 3>& sides() const { return sides_; }
  [[nodiscard]] ElasticRatios<float> ratio() const { return ElasticRatios<float>::of(poisson_, sides_); }
  /// The next level is so much coarser.
  void coarsen(const Stride& stride) {
    const std::array<double, 3> before = sides_;
    for (std::size_t axis = 0; axis < 3; ++axis) { // the third of an image is a side without a cell
      sides_[axis] *= stride[axis];
      cells_of_image_[axis] *= stride[axis];
    }
    if (sides_[0] * before[1] != sides_[1] * before[0] || sides_[0] * before[2] != sides_[2] * before[0]) {
      prepare(); // cells of another form
    }
  }
  void respond(ElasticLevel& level, const Prescribed* prescribed) const {
    may_end_here();
    if (!of_volume_) {
      set_response(level, of_image_, prescribed);
      return;
    }
    const std::array<int, 3> cells = level.grid.cells().sides();
    std::array<int, 3> whole = cells;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      whole[axis] -= cells[axis] * cells_of_image_[axis] > full_.extent.sides()[axis] - 1 ? 1 : 0;
    }
    set_volume_response(level, *of_volume_, moduli_, whole, *prescribed);
  }

private:
  void prepare() {
    const auto ratio = ElasticRatios<double>::of(poisson_, sides_);
    if (full_.extent.axes() == 3) {
      of_volume_.emplace(ratio, contrast_, bend_);
    } else {
      of_image_ = image_relaxation(ratio);
    }
  }

  const Level& full_;
  ModuliAround moduli_;
  double poisson_;
  std::array<double, 3> sides_; ///< of the level's cells
  double contrast_;
  double bend_;
  std::array<int, 3> cells_of_image_{1, 1, 1}; ///< in one of the level's, along each axis
  float of_image_ = 0.0F;
  std::optional<VolumeRelaxation> of_volume_;
};

/// The image itself, without masked cells; sites do not respond yet.
ElasticLevel image_level(const ElasticBody& body) {
  const Level& full = body.level;
  const bool is_volume = full.extent.axes() == 3;
  ElasticLevel image = empty_level(full.extent, is_volume ? 1 : moments_of_cells(2));
  image.ratio = ElasticRatios<float>::of(body.model.poisson, full.sides);
  image.bend = bend_of(body);
  if (is_volume) {
    set_volume_moments(image, full);
  } else {
    set_image_moments(image, full);
  }
  return image;
}

/// The image, from which the other levels are made. `spring_at` is null where there are no springs.
template <typename SpringAt>
Coarsening add_image(const ElasticBody& body, std::vector<ElasticLevel>& levels, const SpringAt* spring_at) {
  const Level& full = body.level;
  ElasticLevel& image = levels.emplace_back(image_level(body));
  Coarsening coarsening{.kinds = {}, .prescribed = Prescribed(full, image.grid)};
  may_end_here();
  if (spring_at != nullptr && full.extent.width > 1 && full.extent.height > 1) {
    coarsening.kinds = add_springs(image, force_unit(full, body.model.poisson), *spring_at);
  }
  return coarsening;
}

/// The next coarser level, whose sites do not respond yet.
void add_level(Responses& responses, std::vector<ElasticLevel>& levels, Coarsening& of) {
  const ElasticLevel& fine = levels.back();
  const std::size_t axes = fine.grid.axes();
  const bool is_volume = axes == 3;
  const Stride stride = stride_of(responses.sides(), axes);
  responses.coarsen(stride);
  ElasticLevel level = empty_level(coarser(fine.grid.sites, stride), moments_of_cells(axes));
  level.stride = stride;
  level.ratio = responses.ratio();
  is_volume ? set_volume_parents(level, fine) : set_parent_moments(level, fine);
  may_end_here();
  const Prescribed* const of_fine = of.prescribed_components();
  Prescribed coarse;
  if (is_volume) {
    coarse = Prescribed(of.prescribed, fine.grid, level.grid, stride);
  }
  CellKinds kinds =
      is_volume ? kinds_of<3>(level.grid.cells(), fine.grid, of_fine, &coarse, level.grid, stride, of.kinds)
                : kinds_of<2>(level.grid.cells(), fine.grid, of_fine, nullptr, level.grid, stride, of.kinds);
  may_end_here();
  set_masked_cells(level, kinds,
                   [&](int x, int y, int z) { return galerkin(fine, stride, of.kinds, of_fine, x, y, z); });
  of = {.kinds = std::move(kinds), .prescribed = std::move(coarse)};
  levels.push_back(std::move(level));
}

/// The springs that confidences below 1 make, and those by direction.
auto springs_of(const Level& full) {
  return [&full](std::size_t at) {
    Spring spring{};
    const std::size_t axes = full.extent.axes();
    for (std::size_t row = 0; row < axes; ++row) {
      for (std::size_t column = row; column < axes; ++column) {
        spring[symmetric_entry(axes, row, column)] = spring_entry(full, at, row, column);
      }
    }
    return spring;
  };
}

Coarsening add_image(const ElasticBody& body, std::vector<ElasticLevel>& levels) {
  if (body.site_springs != nullptr) {
    const auto spring_at = [&springs = *body.site_springs](std::size_t at) {
      Spring spring{};
      std::ranges::transform(springs.entries, spring.begin(), [at](const std::vector<float>& entry) {
        return static_cast<double>(entry[at]);
      });
      return spring;
    };
    return add_image(body, levels, &spring_at);
  }
  const auto spring_at = springs_of(body.level);
  const bool pulls = body.springs == Springs::pull && has_springs(body.level);
  return add_image(body, levels, pulls ? &spring_at : nullptr);
}

/// Adds levels as long as more(the last one), which respond.
template <typename More>
Coarsening add_levels(Responses& responses, std::vector<ElasticLevel>& levels, Coarsening of,
                      const More& more) {
  responses.respond(levels.back(), of.prescribed_components());
  while (more(levels.back())) {
    add_level(responses, levels, of);
    responses.respond(levels.back(), of.prescribed_components());
  }
  return of;
}

} // namespace

Prescribed::Prescribed(const Level& full, const RingedGrid& grid) : component(grid.axes()) {
  const bool is_large = full.extent.sites() > sites_worth_threads;
  on_all_threads(grid.axes(), is_large, [&](std::size_t axis) { component[axis].resize(grid.size()); });
  for (std::size_t axis = 0; axis < grid.axes(); ++axis) {
    const int rows = full.extent.height * full.extent.depth;
#pragma omp parallel for if (is_large)
    for (int row = 0; row < rows; ++row) {
      const float* const from = full.confidence[axis].data() + full.extent.index(0, row);
      std::transform(from, from + full.extent.width,
                     component[axis].data() +
                         grid.index(0, row % full.extent.height, row / full.extent.height),
                     [](float value) -> std::uint8_t { return value >= 1.0F ? 1 : 0; });
    }
  }
}

Prescribed::Prescribed(const Prescribed& fine, const RingedGrid& fine_grid, const RingedGrid& grid,
                       const Stride& stride) {
  const Extent sites = fine_grid.sites;
  const auto there = [&](std::size_t axis) { return (sites.sides()[axis] - 1) / stride[axis] + 1; };
  const int height = there(1);
  const int rows = height * there(2);
  const int width = there(0);
  for (const std::vector<std::uint8_t>& from : fine.component) {
    std::vector<std::uint8_t>& to = component.emplace_back(grid.size());
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
    for (int row = 0; row < rows; ++row) {
      const std::size_t first = grid.index(0, row % height, row / height);
      const std::size_t fine_first =
          fine_grid.index(0, stride[1] * (row % height), stride[2] * (row / height));
      for (int x = 0; x < width; ++x) {
        to[first + static_cast<std::size_t>(x)] = from[fine_first + static_cast<std::size_t>(stride[0] * x)];
      }
    }
  }
}

FineLevels make_fine_levels(const ElasticBody& body, int coarse) {
  FineLevels made;
  Coarsening of = add_image(body, made.levels);
  Responses responses(body);
  made.coarsening = add_levels(responses, made.levels, std::move(of), [&](const ElasticLevel&) {
    return static_cast<int>(made.levels.size()) <= coarse;
  });
  return made;
}

ElasticHierarchy make_elastic_hierarchy(const ElasticBody& body) {
  ElasticHierarchy hierarchy;
  Coarsening of = add_image(body, hierarchy.levels);
  Responses responses(body);
  of = add_levels(responses, hierarchy.levels, std::move(of), has_coarser);
  hierarchy.coarsest_inverse = coarsest_inverse(hierarchy.levels.back(), of.prescribed_components());
  return hierarchy;
}

ElasticHierarchy make_coarse_levels(const ElasticBody& body, int number, ElasticLevel level,
                                    Coarsening coarsening) {
  ElasticHierarchy hierarchy = outline_of(body.level.extent, body.level.sides);
  hierarchy.levels.resize(static_cast<std::size_t>(number) + 1);
  Responses responses(body);
  for (auto next = hierarchy.levels.begin() + 1; next != hierarchy.levels.end(); ++next) {
    responses.coarsen(next->stride);
  }
  hierarchy.levels.back() = std::move(level);
  coarsening = add_levels(responses, hierarchy.levels, std::move(coarsening), has_coarser);
  hierarchy.coarsest_inverse = coarsest_inverse(hierarchy.levels.back(), coarsening.prescribed_components());
  return hierarchy;
}

ElasticHierarchy outline_of(Extent sites, std::array<double, 3> sides) {
  ElasticHierarchy outline;
  outline.levels.emplace_back().grid = RingedGrid(sites);
  while (!is_coarsest(sites)) {
    const Stride stride = stride_of(sides, sites.axes());
    sites = coarser(sites, stride);
    std::ranges::transform(sides, stride, sides.begin(), std::multiplies<>());
    ElasticLevel& level = outline.levels.emplace_back();
    level.grid = RingedGrid(sites);
    level.stride = stride;
  }
  return outline;
}

Stride stride_of(const std::array<double, 3>& sides, std::size_t axes) {
  const auto of_axes = std::span(sides).first(axes);
  const auto [shortest, longest] = std::ranges::minmax(of_axes);
  Stride stride{2, 2, 2};
  for (std::size_t axis = 0; longest > 2.0 * shortest && axis < axes; ++axis) {
    stride[axis] = sides[axis] <= std::numbers::sqrt2 * shortest ? 2 : 1;
  }
  return stride;
}

Extent coarser(Extent sites, const Stride& stride) {
  const auto along = [](int of, int step) { return step == 2 ? of / 2 + 1 : of; };
  return {along(sites.width, stride[0]), along(sites.height, stride[1]),
          sites.axes() == 3 ? along(sites.depth, stride[2]) : 1};
}

double coarse_share(Extent sites, std::array<double, 3> sides) {
  const std::vector<ElasticLevel> levels = outline_of(sites, sides).levels;
  const double all =
      std::transform_reduce(levels.begin(), levels.end(), 0.0, std::plus<>(), [](const ElasticLevel& level) {
        return static_cast<double>(level.grid.sites.sites());
      });
  return all / static_cast<double>(sites.sites()) - 1.0;
}

ElasticLevel empty_level(Extent sites, std::size_t moments) {
  ElasticLevel level;
  level.grid = RingedGrid(sites);
  level.moments.resize(moments);
  level.response.resize(sites.axes() * (sites.axes() + 1) / 2);
  std::vector<std::vector<float>*> arrays;
  for (auto* const group : {&level.moments, &level.response}) {
    for (std::vector<float>& values : *group) {
      arrays.push_back(&values);
    }
  }
  make_zeros(arrays, level.grid.size());
  return level;
}

} // namespace hdmbench
