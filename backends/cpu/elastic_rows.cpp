// Built once per instruction set: HDMBENCH_INSTRUCTION_SET is baseline, avx2 or avx512.

#include "backends/cpu/loops.hpp"

#include "kernels/specification/elastic/elastic.hpp"

namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET {

namespace {

using InFloat = Elastic<float>;

// The bodies of loops are functions of their own: locals declared inside an `omp simd` loop would become
// arrays in memory.

HDM_FUNCTION InFloat::CellCorners corners(const float* above, const float* below, int i) {
  return {above[i], above[i + 1], below[i], below[i + 1]};
}

HDM_FUNCTION void tension_of(const CellRow& row, int i) {
  const float* const* const m = row.moments;
  const InFloat::CellTension tension = InFloat::cell_tension(
      {m[0][i], m[1][i], m[2][i], m[3][i], m[4][i], m[5][i]}, corners(row.above.x, row.below.x, i),
      corners(row.above.y, row.below.y, i), {row.nu, row.shear});
  row.tension[0][i] = tension.top;
  row.tension[1][i] = tension.bottom;
  row.tension[2][i] = tension.left;
  row.tension[3][i] = tension.right;
  row.tension[4][i] = tension.shear;
}

void tensions(const CellRow& given) {
  const CellRow row = given; // nothing that is written can change it
#pragma omp simd
  for (int i = 0; i < row.cells; ++i) {
    tension_of(row, i);
  }
}

HDM_FUNCTION InFloat::CellTension tension_at(const CellRow& row, int i) {
  return {row.tension[0][i], row.tension[1][i], row.tension[2][i], row.tension[3][i], row.tension[4][i]};
}

HDM_FUNCTION void forces_on(const CellRow& row, const ElasticRow& above, const ElasticRow& below, int i) {
  const InFloat::CellTension west = tension_at(row, i);
  const InFloat::CellTension east = tension_at(row, i + 1);
  const InFloat::Force west_above = InFloat::force_on_top_right(west);
  const InFloat::Force east_above = InFloat::force_on_top_left(east);
  const InFloat::Force west_below = InFloat::force_on_bottom_right(west);
  const InFloat::Force east_below = InFloat::force_on_bottom_left(east);
  above.x[i] = west_above.x + east_above.x;
  above.y[i] = west_above.y + east_above.y;
  below.x[i] = west_below.x + east_below.x;
  below.y[i] = west_below.y + east_below.y;
}

void forces(const CellRow& given, ElasticRow above, ElasticRow below) {
  const CellRow row = given;
#pragma omp simd
  for (int i = 0; i < row.cells - 1; ++i) {
    forces_on(row, above, below, i);
  }
}

void masked_forces(const float* stiffness, const float* values, float* force) {
  float sum[8] = {};
  for (int column = 0; column < 8; ++column) {
#pragma omp simd
    for (int row = 0; row < 8; ++row) {
      sum[row] = InFloat::masked_force(sum[row], stiffness[8 * column + row], values[column]);
    }
  }
  for (int row = 0; row < 8; ++row) {
    force[row] = sum[row];
  }
}

HDM_FUNCTION void residual_at(const ConstElasticRow& load, const ConstElasticRow& north,
                              const ConstElasticRow& south, const ElasticRow& to, int i) {
  const InFloat::Force residual =
      InFloat::residual_of({load.x[i], load.y[i]}, {north.x[i] + south.x[i], north.y[i] + south.y[i]});
  to.x[i] = residual.x;
  to.y[i] = residual.y;
}

void residual(int sites, ConstElasticRow load, ConstElasticRow north, ConstElasticRow south, ElasticRow to) {
  if (load.x != nullptr) {
#pragma omp simd
    for (int i = 0; i < sites; ++i) {
      residual_at(load, north, south, to, i);
    }
    return;
  }
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    to.x[i] = north.x[i] + south.x[i];
    to.y[i] = north.y[i] + south.y[i];
  }
}

HDM_FUNCTION void relax_site(float x, float y, const ConstElasticRow& residual, const Response& response,
                             const ElasticRow& to, int i) {
  const float across = response.xy[i];
  to.x[i] = InFloat::relaxed(x, response.xx[i], residual.x[i], across, residual.y[i]);
  to.y[i] = InFloat::relaxed(y, response.yy[i], residual.y[i], across, residual.x[i]);
}

void relax(int sites, ConstElasticRow from, ConstElasticRow residual, const Response& given, ElasticRow to) {
  const Response response = given;
  if (from.x == nullptr) {
#pragma omp simd
    for (int i = 0; i < sites; ++i) {
      relax_site(0.0F, 0.0F, residual, response, to, i);
    }
    return;
  }
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    relax_site(from.x[i], from.y[i], residual, response, to, i);
  }
}

void keep_free(int sites, const Response& given, ElasticRow values) {
  const Response response = given;
#pragma omp simd
  for (int i = 0; i < sites; ++i) {
    values.x[i] = InFloat::free_part(values.x[i], response.xx[i]);
    values.y[i] = InFloat::free_part(values.y[i], response.yy[i]);
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

/// The sites 2 i and 2 i + 1 of a row that is a coarse one (`between` false), or lies between two.
template <bool between>
HDM_FUNCTION float even_site(const float* first, const float* second, const float* values, int i) {
  return between ? InFloat::corrected_by_two(values[2 * i], first[i], second[i])
                 : InFloat::corrected_by_one(values[2 * i], first[i]);
}
template <bool between>
HDM_FUNCTION float odd_site(const float* first, const float* second, const float* values, int i) {
  return between
             ? InFloat::corrected_by_four(values[2 * i + 1], first[i], first[i + 1], second[i], second[i + 1])
             : InFloat::corrected_by_two(values[2 * i + 1], first[i], first[i + 1]);
}

HDM_FUNCTION float where_free(float straight, float corrected, float value) {
  return straight > 0.0F ? corrected : value;
}

template <bool between>
HDM_FUNCTION void correct_row(int sites, const float* first, const float* second, const float* straight,
                              float* values) {
  if (straight == nullptr) {
#pragma omp simd
    for (int i = 0; i < sites / 2; ++i) {
      values[2 * i] = even_site<between>(first, second, values, i);
      values[2 * i + 1] = odd_site<between>(first, second, values, i);
    }
  } else {
#pragma omp simd
    for (int i = 0; i < sites / 2; ++i) {
      values[2 * i] =
          where_free(straight[2 * i], even_site<between>(first, second, values, i), values[2 * i]);
      values[2 * i + 1] =
          where_free(straight[2 * i + 1], odd_site<between>(first, second, values, i), values[2 * i + 1]);
    }
  }
  if (sites % 2 != 0 && (straight == nullptr || straight[sites - 1] > 0.0F)) {
    values[sites - 1] = even_site<between>(first, second, values, sites / 2);
  }
}

void correct(int fine_sites, const float* first, const float* second, const float* straight, float* values) {
  if (first == second) {
    correct_row<false>(fine_sites, first, second, straight, values);
  } else {
    correct_row<true>(fine_sites, first, second, straight, values);
  }
}

void advance(int count, const float* value, float factor, const float* direction, float* to) {
#pragma omp simd
  for (int i = 0; i < count; ++i) {
    to[i] = InFloat::advanced(value[i], factor, direction[i]);
  }
}

HDM_FUNCTION float product(const ConstElasticRow& first, const ConstElasticRow& second, std::size_t at) {
  return InFloat::site_product(first.x[at], second.x[at], first.y[at], second.y[at]);
}
HDM_FUNCTION float product_square(const ConstElasticRow& first, const ConstElasticRow& second, std::size_t at,
                                  std::size_t below) {
  return InFloat::square_sum(product(first, second, at), product(first, second, at + 1),
                             product(first, second, below), product(first, second, below + 1));
}

void product_squares(int squares, ConstElasticRow first, ConstElasticRow second, std::size_t second_row,
                     float* to) {
#pragma omp simd
  for (int i = 0; i < squares; ++i) {
    const auto at = 2 * static_cast<std::size_t>(i);
    to[i] = product_square(first, second, at, at + second_row);
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

const ElasticRows elastic_rows{tensions,        forces,         masked_forces,   residual, relax,
                               keep_free,       restrict_along, restrict_across, correct,  advance,
                               product_squares, square_sums,    add_column};

} // namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET
