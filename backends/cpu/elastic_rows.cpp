// Built once per instruction set: HDMBENCH_INSTRUCTION_SET is baseline, avx2 or avx512.

#include "backends/cpu/loops.hpp"

#include "kernels/specification/elastic/elastic.hpp"

namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET {

namespace {

using InFloat = Elastic<float>;
using Volume = ElasticVolume<float>;

// The bodies of loops are functions of their own: locals declared inside an `omp simd` loop would become
// arrays in memory.

HDM_FUNCTION InFloat::CellCorners corners(const ImageCells& row, int axis, int i) {
  const float* const above = row.sites[0].of[axis];
  const float* const below = row.sites[1].of[axis];
  return {above[i], above[i + 1], below[i], below[i + 1]};
}

HDM_FUNCTION void tension_of(const ImageCells& row, int i) {
  const float* const* const m = row.moments;
  const InFloat::CellTension tension =
      InFloat::cell_tension({m[0][i], m[1][i], m[2][i], m[3][i], m[4][i], m[5][i]}, corners(row, 0, i),
                            corners(row, 1, i), {row.nu, row.shear});
  row.tension[0][i] = tension.top;
  row.tension[1][i] = tension.bottom;
  row.tension[2][i] = tension.left;
  row.tension[3][i] = tension.right;
  row.tension[4][i] = tension.shear;
}

void tensions(const ImageCells& given) {
  const ImageCells row = given; // nothing that is written can change it
#pragma omp simd
  for (int i = 0; i < row.cells; ++i) {
    tension_of(row, i);
  }
}

HDM_FUNCTION InFloat::CellTension tension_at(const ImageCells& row, int i) {
  return {row.tension[0][i], row.tension[1][i], row.tension[2][i], row.tension[3][i], row.tension[4][i]};
}

HDM_FUNCTION void forces_on(const ImageCells& row, const ElasticRow& above, const ElasticRow& below, int i) {
  const InFloat::CellTension west = tension_at(row, i);
  const InFloat::CellTension east = tension_at(row, i + 1);
  const InFloat::Force west_above = InFloat::force_on_top_right(west);
  const InFloat::Force east_above = InFloat::force_on_top_left(east);
  const InFloat::Force west_below = InFloat::force_on_bottom_right(west);
  const InFloat::Force east_below = InFloat::force_on_bottom_left(east);
  above.of[0][i] = west_above.x + east_above.x;
  above.of[1][i] = west_above.y + east_above.y;
  below.of[0][i] = west_below.x + east_below.x;
  below.of[1][i] = west_below.y + east_below.y;
}

void forces(const ImageCells& given, ElasticRow above, ElasticRow below) {
  const ImageCells row = given;
#pragma omp simd
  for (int i = 0; i < row.cells - 1; ++i) {
    forces_on(row, above, below, i);
  }
}

HDM_FUNCTION Volume::Coefficients coefficients_at(const VolumeCells& row, int axis, int i) {
  const float* const r0 = row.sites[0].of[axis];
  const float* const r1 = row.sites[1].of[axis];
  const float* const r2 = row.sites[2].of[axis];
  const float* const r3 = row.sites[3].of[axis];
  return Volume::coefficients_of({r0[i], r0[i + 1], r1[i], r1[i + 1], r2[i], r2[i + 1], r3[i], r3[i + 1]});
}

HDM_FUNCTION void store_component(float* const* to, const Volume::Coefficients& tension, int i) {
  const Volume::CellCorners force = Volume::forces_of(tension);
  to[0][i] = force.c000;
  to[1][i] = force.c100;
  to[2][i] = force.c010;
  to[3][i] = force.c110;
  to[4][i] = force.c001;
  to[5][i] = force.c101;
  to[6][i] = force.c011;
  to[7][i] = force.c111;
}

HDM_FUNCTION void store_tension(const VolumeCells& row, const Volume::CellTension& tension, int i) {
  store_component(row.tension, tension.x, i);
  store_component(row.tension + 8, tension.y, i);
  store_component(row.tension + 16, tension.z, i);
}

HDM_FUNCTION void volume_tension_of(const VolumeCells& row, int i) {
  const float* const* const m = row.moments;
  const Volume::CellMoments moments{m[0][i],  m[1][i],  m[2][i],  m[3][i],  m[4][i],  m[5][i],
                                    m[6][i],  m[7][i],  m[8][i],  m[9][i],  m[10][i], m[11][i],
                                    m[12][i], m[13][i], m[14][i], m[15][i], m[16][i], m[17][i],
                                    m[18][i], m[19][i], m[20][i], m[21][i], m[22][i]};
  store_tension(row,
                Volume::cell_tension(moments, coefficients_at(row, 0, i), coefficients_at(row, 1, i),
                                     coefficients_at(row, 2, i), row.lame),
                i);
}

void volume_tensions(const VolumeCells& given) {
  const VolumeCells row = given;
#pragma omp simd
  for (int i = 0; i < row.cells; ++i) {
    volume_tension_of(row, i);
  }
}

HDM_FUNCTION void image_tension_of(const VolumeCells& row, int i) {
  const float* const* const m = row.moments;
  const Volume::CellMoments moments = Volume::image_cell(
      {m[0][i], m[0][i + 1], m[1][i], m[1][i + 1], m[2][i], m[2][i + 1], m[3][i], m[3][i + 1]});
  store_tension(row,
                Volume::cell_tension(moments, coefficients_at(row, 0, i), coefficients_at(row, 1, i),
                                     coefficients_at(row, 2, i), row.lame),
                i);
}

void image_tensions(const VolumeCells& given, int first, int last) {
  const VolumeCells row = given;
#pragma omp simd
  for (int i = first; i < last; ++i) {
    image_tension_of(row, i);
  }
}

HDM_FUNCTION void uniform_tension_of(const VolumeCells& row, int i) {
  store_tension(row,
                Volume::uniform_tension(row.moments[0][i], coefficients_at(row, 0, i),
                                        coefficients_at(row, 1, i), coefficients_at(row, 2, i), row.lame),
                i);
}

void uniform_tensions(const VolumeCells& given) {
  const VolumeCells row = given;
#pragma omp simd
  for (int i = 0; i < row.cells; ++i) {
    uniform_tension_of(row, i);
  }
}

/// On one row of sites: from the cells to the west, whose corner is the eastern one, and to the east.
void volume_forces(const VolumeCells& row, const ElasticRow* on_rows) {
  for (int number = 0; number < 4; ++number) {
    for (int axis = 0; axis < 3; ++axis) {
      const float* const east = row.tension[8 * axis + 2 * number];
      const float* const west = row.tension[8 * axis + 2 * number + 1] - 1;
      float* const to = on_rows[number].of[axis];
#pragma omp simd
      for (int i = 0; i <= row.cells; ++i) {
        to[i] = west[i] + east[i];
      }
    }
  }
}

template <int components>
HDM_FUNCTION void forces_of_masked(const float* stiffness, const float* values, float* force) {
  float sum[components] = {};
  for (int column = 0; column < components; ++column) {
#pragma omp simd
    for (int row = 0; row < components; ++row) {
      sum[row] = InFloat::masked_force(sum[row], stiffness[components * column + row], values[column]);
    }
  }
  for (int row = 0; row < components; ++row) {
    force[row] = sum[row];
  }
}

void masked_forces(int components, const float* stiffness, const float* values, float* force) {
  components == 8 ? forces_of_masked<8>(stiffness, values, force)
                  : forces_of_masked<24>(stiffness, values, force);
}

void add(int count, const float* first, const float* second, float* sum) {
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    sum[i] = first[i] + second[i];
  }
}

void residual(int sites, const float* load, const float* north, const float* south, float* to) {
  if (load == nullptr) {
    add(sites, north, south, to);
    return;
  }
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    to[i] = load[i] + (north[i] + south[i]);
  }
}

template <int axes>
HDM_FUNCTION void relax_site(float x, float y, float z, const ConstElasticRow& residual,
                             const Response& response, const ElasticRow& to, int i) {
  const float rx = residual.of[0][i];
  const float ry = residual.of[1][i];
  if constexpr (axes == 2) {
    const float across = response.entry[1][i];
    to.of[0][i] = InFloat::relaxed(x, response.entry[0][i], rx, across, ry);
    to.of[1][i] = InFloat::relaxed(y, response.entry[2][i], ry, across, rx);
  } else {
    const float rz = residual.of[2][i];
    const float xy = response.entry[1][i];
    const float xz = response.entry[2][i];
    const float yz = response.entry[4][i];
    to.of[0][i] = Volume::relaxed_in_volume(x, response.entry[0][i], rx, xy, ry, xz, rz);
    to.of[1][i] = Volume::relaxed_in_volume(y, response.entry[3][i], ry, xy, rx, yz, rz);
    to.of[2][i] = Volume::relaxed_in_volume(z, response.entry[5][i], rz, xz, rx, yz, ry);
  }
}

template <int axes>
void relax_row(int sites, const ConstElasticRow& from, const ConstElasticRow& residual,
               const Response& response, const ElasticRow& to) {
  if (from.of[0] == nullptr) {
#pragma omp simd
    for (int i = 0; i < sites; ++i) {
      relax_site<axes>(0.0F, 0.0F, 0.0F, residual, response, to, i);
    }
    return;
  }
  const float* const z = from.of[axes - 1];
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    relax_site<axes>(from.of[0][i], from.of[1][i], z[i], residual, response, to, i);
  }
}

void relax(int axes, int sites, ConstElasticRow from, ConstElasticRow residual, const Response& given,
           ElasticRow to) {
  const Response response = given;
  axes == 2 ? relax_row<2>(sites, from, residual, response, to)
            : relax_row<3>(sites, from, residual, response, to);
}

void keep_free(int sites, const float* straight, float* values) {
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    values[i] = InFloat::free_part(values[i], straight[i]);
  }
}

void restrict_along(int sites, const float* fine, float* to) {
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    to[i] = InFloat::restricted(fine[2 * i - 1], fine[2 * i], fine[2 * i + 1]);
  }
}

void restrict_across(int sites, const float* before, const float* at, const float* after, float* to) {
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    to[i] = InFloat::restricted(before[i], at[i], after[i]);
  }
}

/// The sites 2 i and 2 i + 1 of a row that is a coarse one, or lies between 2 or 4.
template <int rows>
HDM_FUNCTION float even_site(const float* const* c, float value, int i) {
  return rows == 1   ? InFloat::corrected_by_one(value, c[0][i])
         : rows == 2 ? InFloat::corrected_by_two(value, c[0][i], c[1][i])
                     : InFloat::corrected_by_four(value, c[0][i], c[1][i], c[2][i], c[3][i]);
}
template <int rows>
HDM_FUNCTION float odd_site(const float* const* c, float value, int i) {
  return rows == 1   ? InFloat::corrected_by_two(value, c[0][i], c[0][i + 1])
         : rows == 2 ? InFloat::corrected_by_four(value, c[0][i], c[0][i + 1], c[1][i], c[1][i + 1])
                     : Volume::corrected_by_eight(value, c[0][i], c[0][i + 1], c[1][i], c[1][i + 1], c[2][i],
                                                  c[2][i + 1], c[3][i], c[3][i + 1]);
}

HDM_FUNCTION float where_free(float straight, float corrected, float value) {
  return straight > 0.0F ? corrected : value;
}

template <int rows>
HDM_FUNCTION void correct_row(int sites, const float* const* given, const float* straight, float* values) {
  const float* const coarse[4] = {given[0], given[1], given[2], given[3]};
  if (straight == nullptr) {
#pragma omp simd
    for (int i = 0; i < sites / 2; ++i) {
      values[2 * i] = even_site<rows>(coarse, values[2 * i], i);
      values[2 * i + 1] = odd_site<rows>(coarse, values[2 * i + 1], i);
    }
  } else {
#pragma omp simd
    for (int i = 0; i < sites / 2; ++i) {
      values[2 * i] = where_free(straight[2 * i], even_site<rows>(coarse, values[2 * i], i), values[2 * i]);
      values[2 * i + 1] =
          where_free(straight[2 * i + 1], odd_site<rows>(coarse, values[2 * i + 1], i), values[2 * i + 1]);
    }
  }
  if (sites % 2 != 0 && (straight == nullptr || straight[sites - 1] > 0.0F)) {
    values[sites - 1] = even_site<rows>(coarse, values[sites - 1], sites / 2);
  }
}

void correct(int fine_sites, int coarse_rows, const float* const* coarse, const float* straight,
             float* values) {
  if (coarse_rows == 1) {
    correct_row<1>(fine_sites, coarse, straight, values);
  } else if (coarse_rows == 2) {
    correct_row<2>(fine_sites, coarse, straight, values);
  } else {
    correct_row<4>(fine_sites, coarse, straight, values);
  }
}

void advance(int count, const float* value, float factor, const float* direction, float* to) {
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    to[i] = InFloat::advanced(value[i], factor, direction[i]);
  }
}

template <int axes>
HDM_FUNCTION float product(const ConstElasticRow& first, const ConstElasticRow& second, std::size_t at) {
  const float sum =
      InFloat::site_product(first.of[0][at], second.of[0][at], first.of[1][at], second.of[1][at]);
  if constexpr (axes == 2) {
    return sum;
  } else {
    return InFloat::with_term(sum, first.of[2][at], second.of[2][at]);
  }
}
template <int axes>
HDM_FUNCTION float product_square(const ConstElasticRow& first, const ConstElasticRow& second, std::size_t at,
                                  std::size_t below) {
  return InFloat::square_sum(product<axes>(first, second, at), product<axes>(first, second, at + 1),
                             product<axes>(first, second, below), product<axes>(first, second, below + 1));
}

void product_squares(int axes, int squares, ConstElasticRow first, ConstElasticRow second,
                     std::size_t second_row, std::size_t second_plane, float* to) {
  if (axes == 2) {
#pragma omp simd
    for (int i = 0; i < squares; ++i) {
      const auto at = 2 * static_cast<std::size_t>(i);
      to[i] = product_square<2>(first, second, at, at + second_row);
    }
    return;
  }
#pragma omp simd
  for (int i = 0; i < squares; ++i) {
    const auto at = 2 * static_cast<std::size_t>(i);
    const std::size_t far = at + second_plane;
    to[i] = product_square<3>(first, second, at, at + second_row) +
            product_square<3>(first, second, far, far + second_row);
  }
}

void square_sums(int squares, const float* above, const float* below, float* to) {
  for (int i = 0; i < squares; ++i) {
    to[i] = InFloat::square_sum(above[2 * i], above[2 * i + 1], below[2 * i], below[2 * i + 1]);
  }
}

void add_column(int count, const float* column, float load, float* sums) {
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    sums[i] = InFloat::with_term(sums[i], column[i], load);
  }
}

} // namespace

const ElasticRows elastic_rows{
    tensions,        forces,  volume_tensions, image_tensions,  uniform_tensions, volume_forces,
    masked_forces,   add,     residual,        relax,           keep_free,        restrict_along,
    restrict_across, correct, advance,         product_squares, square_sums,      add_column};

} // namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET
