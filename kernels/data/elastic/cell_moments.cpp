#include "kernels/data/elastic/set_up.hpp"

namespace hdmbench {

namespace {

using InFloat = ElasticInFloat;

// Bodies of loops are functions of their own: locals declared inside an `omp simd` loop would become arrays
// in memory.

HDM_FUNCTION void set_image_cell(const MomentsRow<float>& row, const float* top, const float* bottom, int x) {
  row.set(x, InFloat::image_cell({top[x], top[x + 1], bottom[x], bottom[x + 1]}));
}

HDM_FUNCTION void set_parent(const MomentsRow<float>& row, const MomentsRow<const float>& top,
                             const MomentsRow<const float>& bottom, int x) {
  InFloat::CellMoments sum{0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
  sum = InFloat::with_child(sum, top.cell(2 * x), -1.0F, -1.0F);
  sum = InFloat::with_child(sum, top.cell(2 * x + 1), 1.0F, -1.0F);
  sum = InFloat::with_child(sum, bottom.cell(2 * x), -1.0F, 1.0F);
  sum = InFloat::with_child(sum, bottom.cell(2 * x + 1), 1.0F, 1.0F);
  row.set(x, sum);
}

/// Where |xx yy - xy^2| is less than this share of xx yy, the two components of a site move as one.
constexpr float least_determinant = 1e-6F;

/// A row of sites: their stiffness at first, their response in the end.
struct ResponseRow {
  int width = 0;
  float* xx = nullptr;
  float* xy = nullptr;
  float* yy = nullptr;
};

ResponseRow row_of(ElasticLevel& level, int y) {
  const std::size_t first = level.grid.index(0, y);
  return {level.grid.sites.width, level.response[0].data() + first, level.response[1].data() + first,
          level.response[2].data() + first};
}

/// Of the site between two cells of the row above and two of the row below.
HDM_FUNCTION void set_stiffness_at(const ResponseRow& row, const MomentsRow<const float>& above,
                                   const MomentsRow<const float>& below, const InFloat::PoissonRatio& ratio,
                                   int x) {
  InFloat::SiteStiffness sum{0.0F, 0.0F, 0.0F};
  sum = InFloat::with_cell(sum, above.cell(x - 1), 1.0F, 1.0F, ratio);
  sum = InFloat::with_cell(sum, above.cell(x), -1.0F, 1.0F, ratio);
  sum = InFloat::with_cell(sum, below.cell(x - 1), 1.0F, -1.0F, ratio);
  sum = InFloat::with_cell(sum, below.cell(x), -1.0F, -1.0F, ratio);
  row.xx[x] = sum.xx;
  row.xy[x] = sum.xy;
  row.yy[x] = sum.yy;
}

void set_stiffness(const ResponseRow& row, const MomentsRow<const float>& above,
                   const MomentsRow<const float>& below, const InFloat::PoissonRatio& ratio) {
#pragma omp simd
  for (int x = 0; x < row.width; ++x) {
    set_stiffness_at(row, above, below, ratio, x);
  }
}

/// The row of cells above the sites, then that below.
void add_masked_cells(const ResponseRow& row, const MaskedCells& masked, int y) {
  for (int above = 1; above >= 0; --above) {
    const auto [first, last] = masked.row(y - above);
    for (std::size_t i = first; i < last; ++i) {
      const float* const stiffness = masked.matrix(i);
      for (std::size_t right = 0; right < 2; ++right) {
        const std::size_t own = 4 * static_cast<std::size_t>(above) + 2 * right;
        const std::size_t site = static_cast<std::size_t>(masked.x[i]) + right;
        row.xx[site] += stiffness[8 * own + own];
        row.xy[site] += stiffness[8 * own + own + 1];
        row.yy[site] += stiffness[8 * (own + 1) + own + 1];
      }
    }
  }
}

void leave_out(const ResponseRow& row, const std::uint8_t* x_prescribed, const std::uint8_t* y_prescribed) {
#pragma omp simd
  for (int x = 0; x < row.width; ++x) {
    const bool free_x = x_prescribed[x] == 0;
    const bool free_y = y_prescribed[x] == 0;
    row.xx[x] = free_x ? row.xx[x] : 0.0F;
    row.yy[x] = free_y ? row.yy[x] : 0.0F;
    row.xy[x] = (x_prescribed[x] | y_prescribed[x]) == 0 ? row.xy[x] : 0.0F;
  }
}

/// Relaxation times the inverse; of a matrix of rank one its pseudo-inverse. Without branches, for vectors.
void invert(const ResponseRow& row) {
  const auto relaxation = static_cast<float>(elastic_relaxation);
#pragma omp simd
  for (int x = 0; x < row.width; ++x) {
    const float xx = row.xx[x];
    const float xy = row.xy[x];
    const float yy = row.yy[x];
    const float trace = xx + yy;
    const float determinant = xx * yy - xy * xy;
    const bool whole = determinant > least_determinant * (xx * yy);
    const float quotient = relaxation / (whole ? determinant : trace * trace);
    const float scale = trace > 0.0F ? quotient : 0.0F;
    row.xx[x] = scale * (whole ? yy : xx);
    row.xy[x] = (whole ? -scale : scale) * xy;
    row.yy[x] = scale * (whole ? xx : yy);
  }
}

constexpr std::array<double, 64> identity = [] {
  std::array<double, 64> result{};
  for (std::size_t i = 0; i < 8; ++i) {
    result[9 * i] = 1.0;
  }
  return result;
}();

using InDouble = Elastic<double>;

/// One component of the corners where the component `column` of all is 1 and the others are 0.
HDM_FUNCTION InDouble::CellCorners unit_corners(std::size_t component, std::size_t column) {
  const double* const unit = identity.data() + 8 * component + column;
  return {unit[0], unit[16], unit[32], unit[48]};
}

HDM_FUNCTION void set_forces(CellMatrix& matrix, std::size_t corner, std::size_t column,
                             InDouble::Force force) {
  matrix.values[16 * corner + column] = -force.x;
  matrix.values[16 * corner + 8 + column] = -force.y;
}

HDM_FUNCTION void set_column(CellMatrix& matrix, const InDouble::CellMoments& moments,
                             const InDouble::PoissonRatio& ratio, std::size_t column) {
  const InDouble::CellTension tension =
      InDouble::cell_tension(moments, unit_corners(0, column), unit_corners(1, column), ratio);
  set_forces(matrix, 0, column, InDouble::force_on_top_left(tension));
  set_forces(matrix, 1, column, InDouble::force_on_top_right(tension));
  set_forces(matrix, 2, column, InDouble::force_on_bottom_left(tension));
  set_forces(matrix, 3, column, InDouble::force_on_bottom_right(tension));
}

CellMatrix image_cell_matrix(const ElasticLevel& level, std::size_t index,
                             const ElasticHierarchy& hierarchy) {
  const InFloat::CellMoments moments = level.cell(index);
  const InDouble::CellMoments wide{moments.m, moments.mr, moments.ms, moments.mrr, moments.mss, moments.mrs};
  const InDouble::PoissonRatio wide_ratio{hierarchy.ratio.nu, hierarchy.ratio.shear};
  CellMatrix matrix(2);
#pragma omp simd
  for (std::size_t column = 0; column < 8; ++column) {
    set_column(matrix, wide, wide_ratio, column);
  }
  return matrix;
}

} // namespace

CellMatrix cell_matrix(const ElasticLevel& level, std::size_t index, const ElasticHierarchy& hierarchy) {
  return level.grid.axes() == 3 ? volume_cell_matrix(level, index, hierarchy.lame)
                                : image_cell_matrix(level, index, hierarchy);
}

void set_image_moments(ElasticLevel& image, const Level& full) {
  const Extent cells = image.grid.cells();
#pragma omp parallel for if (full.extent.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    const MomentsRow<float> row(image, y);
    const float* const top = full.modulus.values.data() + full.extent.index(0, y);
    const float* const bottom = top + full.extent.width;
#pragma omp simd
    for (int x = 0; x < cells.width; ++x) {
      set_image_cell(row, top, bottom, x);
    }
  }
}

void set_parent_moments(ElasticLevel& level, const ElasticLevel& fine) {
  const Extent cells = level.grid.cells();
#pragma omp parallel for if (level.grid.sites.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    const MomentsRow<float> row(level, y);
    const MomentsRow<const float> top(fine, 2 * y);
    const MomentsRow<const float> bottom(fine, 2 * y + 1);
#pragma omp simd
    for (int x = 0; x < cells.width; ++x) {
      set_parent(row, top, bottom, x);
    }
  }
}

void set_response(ElasticLevel& level, const InFloat::PoissonRatio& ratio, const Prescribed* prescribed) {
  const RingedGrid& grid = level.grid;
#pragma omp parallel for if (grid.sites.sites() > sites_worth_threads)
  for (int y = 0; y < grid.sites.height; ++y) {
    const ResponseRow row = row_of(level, y);
    set_stiffness(row, {level, y - 1}, {level, y}, ratio);
    add_masked_cells(row, level.masked, y);
    if (prescribed != nullptr) {
      const std::size_t first = grid.index(0, y);
      leave_out(row, prescribed->component[0].data() + first, prescribed->component[1].data() + first);
    }
    invert(row);
  }
}

} // namespace hdmbench
