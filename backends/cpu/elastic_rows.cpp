// Built once per instruction set: HDMBENCH_INSTRUCTION_SET is baseline, avx2 or avx512.

#include "backends/cpu/loops.hpp"

#include "kernels/specification/elastic/elastic.hpp"

namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET {

namespace {

using InFloat = Elastic<float>;
using Volume = ElasticVolume<float>;

// The bodies of loops are functions of their own: locals declared inside an `omp simd` loop would become
// arrays in memory.

/// Eight numbers of a row of cells of a volume, or four, beside each other: of these rows of sites.
template <typename Cells, typename Row>
HDM_FUNCTION typename Cells::CellCorners corners_at(const Row& row, int i) {
  return Cells::corners_of([&](int corner) HDM_INLINED { return row(corner / 2)[i + corner % 2]; });
}

template <typename Cells>
HDM_FUNCTION auto displacements_at(const CellRow<Cells::axes>& row, int i) {
  return [&row, i](int axis) HDM_INLINED {
    return corners_at<Cells>([&](int number) HDM_INLINED { return row.sites[number].of[axis]; }, i);
  };
}

HDM_FUNCTION auto stored_at(const CellRow<3>& row, int i) {
  return [&row, i](int axis, int corner, float force) HDM_INLINED { row.made[8 * axis + corner][i] = force; };
}

template <typename Cells>
HDM_FUNCTION auto moments_at(const CellRow<Cells::axes>& row, int i) {
  return Cells::moments_of([&](int number) HDM_INLINED { return row.moments[number][i]; });
}

/// Of an image the tension, from which forces are made when the cell beside it is known: fewer numbers.
template <typename Cells>
HDM_FUNCTION void image_at(const CellRow<2>& row, int i) {
  const auto displacement = displacements_at<Cells>(row, i);
  const typename Cells::CellTension tension = Cells::cell_tension(moments_at<Cells>(row, i), displacement(0),
                                                                  displacement(1), Cells::law_of(row.ratio));
  row.made[0][i] = tension.top;
  row.made[1][i] = tension.bottom;
  row.made[2][i] = tension.left;
  row.made[3][i] = tension.right;
  row.made[4][i] = tension.shear;
}

template <typename Cells>
HDM_FUNCTION void volume_at(const CellRow<3>& row, int i) {
  Cells::for_each_force(moments_at<Cells>(row, i), displacements_at<Cells>(row, i), row.ratio,
                        stored_at(row, i));
}

template <typename Cells>
HDM_FUNCTION void of_moduli_at(const CellRow<3>& row, int i) {
  const auto moduli = corners_at<Cells>([&](int number) HDM_INLINED { return row.moments[number]; }, i);
  Cells::for_each_force(Cells::image_cell(moduli, row.bend), displacements_at<Cells>(row, i), row.ratio,
                        stored_at(row, i));
}

template <typename Cells>
HDM_FUNCTION void uniform_at(const CellRow<3>& row, int i) {
  Cells::for_each_force_of_uniform(row.moments[0][i], displacements_at<Cells>(row, i), row.ratio, row.bend,
                                   stored_at(row, i));
}

template <std::size_t axes, auto at>
HDM_FUNCTION void each_cell(const CellRow<axes>& given, int first, int last) {
  const CellRow<axes> row = given; // nothing that is written can change it
#pragma omp simd
  for (int i = first; i < last; ++i) {
    at(row, i);
  }
}

/// From the first one, which is known here: pointers are good as they are.
template <std::size_t axes, auto at>
void all_cells(const CellRow<axes>& row) {
  each_cell<axes, at>(row, 0, row.cells);
}

template <bool boxes>
void of_moduli(const CellRow<3>& row, int first, int last) {
  each_cell<3, of_moduli_at<ElasticVolume<float, boxes>>>(row, first, last);
}

template <typename Cells>
HDM_FUNCTION typename Cells::CellTension tension_at(const CellRow<2>& row, int i) {
  return {row.made[0][i], row.made[1][i], row.made[2][i], row.made[3][i], row.made[4][i]};
}

template <typename Cells>
HDM_FUNCTION void image_forces_at(const CellRow<2>& row, const ElasticRow& above, const ElasticRow& below,
                                  int i) {
  const auto law = Cells::law_of(row.ratio);
  const auto west = tension_at<Cells>(row, i - 1);
  const auto east = tension_at<Cells>(row, i);
  const auto west_above = Cells::force_on_top_right(west, law);
  const auto east_above = Cells::force_on_top_left(east, law);
  const auto west_below = Cells::force_on_bottom_right(west, law);
  const auto east_below = Cells::force_on_bottom_left(east, law);
  above.of[0][i] = west_above.x + east_above.x;
  above.of[1][i] = west_above.y + east_above.y;
  below.of[0][i] = west_below.x + east_below.x;
  below.of[1][i] = west_below.y + east_below.y;
}

template <bool boxes>
void image_forces(const CellRow<2>& given, const ElasticRow* to) {
  const CellRow<2> row = given;
  const ElasticRow above = to[0];
  const ElasticRow below = to[1];
#pragma omp simd
  for (int i = 0; i <= row.cells; ++i) {
    image_forces_at<Elastic<float, boxes>>(row, above, below, i);
  }
}

/// On a row of sites: from the cells to the west, whose corner is the eastern one, and to the east.
void volume_forces(const CellRow<3>& row, const ElasticRow* on_rows) {
  for (int number = 0; number < 4; ++number) {
    for (int axis = 0; axis < 3; ++axis) {
      const float* const east = row.made[8 * axis + 2 * number];
      const float* const west = row.made[8 * axis + 2 * number + 1] - 1;
      float* const to = on_rows[number].of[axis];
#pragma omp simd
      for (int i = 0; i <= row.cells; ++i) {
        to[i] = west[i] + east[i];
      }
    }
  }
}

template <std::size_t axes>
void of_matrix(const float* stiffness, const float* displacement, float* force) {
  constexpr std::size_t components = axes << axes;
  float sum[components] = {};
  for (std::size_t column = 0; column < components; ++column) {
#pragma omp simd
    for (std::size_t row = 0; row < components; ++row) {
      sum[row] = InFloat::masked_force(sum[row], stiffness[components * column + row], displacement[column]);
    }
  }
  for (std::size_t row = 0; row < components; ++row) {
    force[row] = sum[row];
  }
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

/// Where coarse sites lie as fine ones do.
template <int rows>
HDM_FUNCTION void correct_row_of_same(int sites, const float* const* given, const float* straight,
                                      float* values) {
  const float* const coarse[4] = {given[0], given[1], given[2], given[3]};
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    const float corrected = even_site<rows>(coarse, values[i], i);
    values[i] = straight == nullptr ? corrected : where_free(straight[i], corrected, values[i]);
  }
}

template <int rows>
HDM_FUNCTION void correct_row(int sites, int stride, const float* const* given, const float* straight,
                              float* values) {
  if (stride == 1) {
    correct_row_of_same<rows>(sites, given, straight, values);
    return;
  }
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

void correct(int fine_sites, int stride, int coarse_rows, const float* const* coarse, const float* straight,
             float* values) {
  if (coarse_rows == 1) {
    correct_row<1>(fine_sites, stride, coarse, straight, values);
  } else if (coarse_rows == 2) {
    correct_row<2>(fine_sites, stride, coarse, straight, values);
  } else {
    correct_row<4>(fine_sites, stride, coarse, straight, values);
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

template <bool boxes>
constexpr CellRows<2> of_image{all_cells<2, image_at<Elastic<float, boxes>>>, nullptr, nullptr, of_matrix<2>,
                               image_forces<boxes>};
template <bool boxes>
constexpr CellRows<3> of_volume{all_cells<3, volume_at<ElasticVolume<float, boxes>>>, of_moduli<boxes>,
                                all_cells<3, uniform_at<ElasticVolume<float, boxes>>>, of_matrix<3>,
                                volume_forces};

} // namespace

const ElasticRows elastic_rows{{of_image<false>, of_image<true>},
                               {of_volume<false>, of_volume<true>},
                               add,
                               residual,
                               relax,
                               keep_free,
                               restrict_along,
                               restrict_across,
                               correct,
                               advance,
                               product_squares,
                               square_sums,
                               add_column};

} // namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET
