#include "kernels/data/elastic/set_up.hpp"

#include <bit>

namespace hdmbench {

namespace {

template <typename InDouble>
HDM_FUNCTION void set_matrix(CellMatrix& matrix, const typename InDouble::CellMoments& moments,
                             const ElasticRatios<double>& ratio) {
  constexpr std::size_t components = InDouble::axes << InDouble::axes;
#pragma omp simd
  for (std::size_t column = 0; column < components; ++column) {
    const auto unit = [&](std::size_t axis) HDM_INLINED {
      return InDouble::corners_of([&](std::size_t corner) HDM_INLINED {
        return InDouble::axes * corner + axis == column ? 1.0 : 0.0;
      });
    };
    InDouble::for_each_force(moments, unit, ratio, [&](int axis, int corner, double force) HDM_INLINED {
      const std::size_t row =
          InDouble::axes * static_cast<std::size_t>(corner) + static_cast<std::size_t>(axis);
      matrix.values[components * row + column] = -force;
    });
  }
}

} // namespace

HDM_WIDE_VECTORS CellMatrix matrix_of(const VolumeCell::CellMoments& moments,
                                      const ElasticRatios<double>& ratio) {
  CellMatrix matrix(3);
  set_matrix<VolumeCell>(matrix, moments, ratio);
  return matrix;
}

CellMatrix matrix_of(const ImageCell::CellMoments& moments, const ElasticRatios<double>& ratio) {
  CellMatrix matrix(2);
  set_matrix<ImageCell>(matrix, moments, ratio);
  return matrix;
}

namespace {

using InFloat = MomentsRow<float>::InFloat;

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

/// The same with x and y exchanged.
HDM_FUNCTION InFloat::CellMoments turned(const InFloat::CellMoments& cell) {
  return {cell.m, cell.ms, cell.mr, cell.mss, cell.mrr, cell.mrs};
}

/// What two cells beside each other along x make, but for a factor.
HDM_FUNCTION InFloat::CellMoments joined(const InFloat::CellMoments& low, const InFloat::CellMoments& high) {
  return {low.m + high.m,     first_moment(low.m, low.mr, high.m, high.mr),
          low.ms + high.ms,   second_moment(low.m, low.mr, low.mrr, high.m, high.mr, high.mrr),
          low.mss + high.mss, first_moment(low.ms, low.mrs, high.ms, high.mrs)};
}

/// Sets a cell that is made of two. Moments are those of slopes along x over the side along x: where that
/// doubles, a quarter of their energy is left.
HDM_FUNCTION void set_parent_of_two(const MomentsRow<float>& row, const MomentsRow<const float>& top,
                                    const MomentsRow<const float>& bottom, bool along_y, int x) {
  const InFloat::CellMoments sum = along_y ? turned(joined(turned(top.cell(x)), turned(bottom.cell(x))))
                                           : joined(top.cell(2 * x), top.cell(2 * x + 1));
  const float share = along_y ? 1.0F : 0.25F;
  row.set(x,
          {share * sum.m, share * sum.mr, share * sum.ms, share * sum.mrr, share * sum.mss, share * sum.mrs});
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
                                   const MomentsRow<const float>& below, const InFloat::Law& law, int x) {
  InFloat::SiteStiffness sum{0.0F, 0.0F, 0.0F};
  sum = InFloat::with_cell(sum, above.cell(x - 1), 1.0F, 1.0F, law);
  sum = InFloat::with_cell(sum, above.cell(x), -1.0F, 1.0F, law);
  sum = InFloat::with_cell(sum, below.cell(x - 1), 1.0F, -1.0F, law);
  sum = InFloat::with_cell(sum, below.cell(x), -1.0F, -1.0F, law);
  row.xx[x] = sum.xx;
  row.xy[x] = sum.xy;
  row.yy[x] = sum.yy;
}

void set_stiffness(const ResponseRow& row, const MomentsRow<const float>& above,
                   const MomentsRow<const float>& below, const InFloat::Law& law) {
#pragma omp simd
  for (int x = 0; x < row.width; ++x) {
    set_stiffness_at(row, above, below, law, x);
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
void invert(const ResponseRow& row, float relaxation) {
#pragma omp simd
  for (int x = 0; x < row.width; ++x) {
    const float power = power_to_one(std::max(row.xx[x], row.yy[x]));
    const float xx = power * row.xx[x];
    const float xy = power * row.xy[x];
    const float yy = power * row.yy[x];
    const float trace = xx + yy;
    const float determinant = xx * yy - xy * xy;
    const bool whole = determinant > least_determinant * (xx * yy);
    const float quotient = relaxation / (whole ? determinant : trace * trace);
    const float scale = trace > 0.0F ? quotient : 0.0F;
    row.xx[x] = power * (scale * (whole ? yy : xx));
    row.xy[x] = power * ((whole ? -scale : scale) * xy);
    row.yy[x] = power * (scale * (whole ? xx : yy));
  }
}

/// Of a cell that is not masked, its moments being floats.
template <typename InDouble, typename OfLevel>
CellMatrix matrix_at(const ElasticLevel& level, std::size_t index) {
  using Cell = typename OfLevel::CellMoments;
  const auto moments =
      std::bit_cast<std::array<float, sizeof(Cell) / sizeof(float)>>(level.template cell<OfLevel>(index));
  auto cell = InDouble::moments_of([&](std::size_t number) { return double{moments[number]}; });
  if constexpr (InDouble::axes == 3) {
    cell.bend = level.bend;
    cell.volume = double{moments.back()};
  }
  return matrix_of(cell, level.ratio.as<double>());
}

} // namespace

CellMatrix cell_matrix(const ElasticLevel& level, std::size_t index) {
  return level.grid.axes() == 3 ? matrix_at<VolumeCell, VolumeInFloat>(level, index)
                                : matrix_at<ImageCell, ElasticInFloat>(level, index);
}

void add_masked_cells(ElasticLevel& level, int y, int z, const std::function<float(int, int, int)>& weight) {
  const std::size_t axes = level.grid.axes();
  const std::size_t row = level.grid.index(0, y, z);
  for (int number = 0; number < 2 << (axes - 2); ++number) {
    const int beside =
        axes == 2 ? 1 - number : number; // in an image those of the row of cells above go first
    const auto [first, last] = level.masked.row(y - beside % 2, z - beside / 2);
    for (std::size_t i = first; i < last; ++i) {
      const float times = weight(level.masked.x[i], y - beside % 2, z - beside / 2);
      for (std::size_t right = 0; right < 2; ++right) {
        const std::size_t own = axes * (right + 2 * static_cast<std::size_t>(beside));
        const std::size_t site = row + static_cast<std::size_t>(level.masked.x[i]) + right;
        for (std::size_t a = 0; a < axes; ++a) {
          for (std::size_t b = a; b < axes; ++b) {
            level.response[symmetric_entry(axes, a, b)][site] +=
                times * level.masked.matrix(i)[level.masked.components * (own + a) + own + b];
          }
        }
      }
    }
  }
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
    const MomentsRow<const float> top(fine, level.stride[1] * y);
    const MomentsRow<const float> bottom(fine, level.stride[1] * y + level.stride[1] - 1);
    if (level.stride[0] != level.stride[1]) {
      for (int x = 0; x < cells.width; ++x) {
        set_parent_of_two(row, top, bottom, level.stride[1] == 2, x);
      }
      continue;
    }
#pragma omp simd
    for (int x = 0; x < cells.width; ++x) {
      set_parent(row, top, bottom, x);
    }
  }
}

void set_response(ElasticLevel& level, float relaxation, const Prescribed* prescribed) {
  const RingedGrid& grid = level.grid;
  const InFloat::Law law = InFloat::law_of(level.ratio);
#pragma omp parallel for if (grid.sites.sites() > sites_worth_threads)
  for (int y = 0; y < grid.sites.height; ++y) {
    const ResponseRow row = row_of(level, y);
    set_stiffness(row, {level, y - 1}, {level, y}, law);
    add_masked_cells(level, y, 0, [](int, int, int) { return 1.0F; });
    if (prescribed != nullptr) {
      const std::size_t first = grid.index(0, y);
      leave_out(row, prescribed->component[0].data() + first, prescribed->component[1].data() + first);
    }
    invert(row, relaxation);
  }
}

} // namespace hdmbench
