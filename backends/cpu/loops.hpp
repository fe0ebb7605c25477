#pragma once

#include <cstddef>

/// Loops that are compiled once per instruction set, but not per energy (ceiling_loops.cpp,
/// elastic_rows.cpp). Plain pointers only, for the reason that row.hpp gives. Arrays do not overlap unless
/// said so.
namespace hdmbench::openmp {

/// What a processor can do: value = value * factor + term, `rounds` times for each of `chain_sites` values
/// side by side.
using MultiplyAdd = void (*)(float* values, float factor, float term, int rounds);

/// How many values a call takes: more than any processor needs to keep all its units busy.
inline constexpr int chain_sites = 24 * 16;

/// Both components of a row of sites.
struct ElasticRow {
  float* x = nullptr;
  float* y = nullptr;
};
struct ConstElasticRow {
  ConstElasticRow() = default;
  ConstElasticRow(const float* x_, const float* y_) : x(x_), y(y_) {}
  ConstElasticRow(const ElasticRow& row) : x(row.x), y(row.y) {} // NOLINT(google-explicit-constructor)

  const float* x = nullptr;
  const float* y = nullptr;
};

/// ElasticLevel::response of a row of sites.
struct Response {
  const float* xx = nullptr;
  const float* xy = nullptr;
  const float* yy = nullptr;
};

/// A row of cells, the one west of the first site first and the one east of the last site last: pointers are
/// to that first one, and to the site at its top left and bottom left.
struct CellRow {
  const float* moments[6] = {}; ///< as ElasticLevel::moments
  ConstElasticRow above;        ///< displacements
  ConstElasticRow below;
  float nu = 0;
  float shear = 0;
  int cells = 0;
  float* tension[5] = {}; ///< written: top, bottom, left, right, shear
};

/// Rows of the elastic energy.
struct ElasticRows {
  void (*tensions)(const CellRow& row);
  /// From the tensions of a row of cells: its forces on the sites above and on those below.
  void (*forces)(const CellRow& row, ElasticRow on_above, ElasticRow on_below);
  /// From a masked cell's matrix, column by column, and its eight displacements.
  void (*masked_forces)(const float* stiffness, const float* values, float* force);
  /// residual = (from_north + from_south), with the load where there is one.
  void (*residual)(int sites, ConstElasticRow load, ConstElasticRow from_north, ConstElasticRow from_south,
                   ElasticRow residual);
  /// `to` may be `from`, whose pointers may be null: 0.
  void (*relax)(int sites, ConstElasticRow from, ConstElasticRow residual, const Response& response,
                ElasticRow to);
  /// In place: 0 where a component may not move.
  void (*keep_free)(int sites, const Response& response, ElasticRow values);
  /// From fine sites -1 ... 2 * sites - 1 of a row.
  void (*restrict_along)(int sites, const float* fine, float* to);
  void (*restrict_across)(int sites, const float* before, const float* at, const float* after, float* to);
  /// In place; `straight` is null where every component may move. The fine row is `first` where that is
  /// `second`, else between the two.
  void (*correct)(int fine_sites, const float* first, const float* second, const float* straight,
                  float* values);
  void (*advance)(int count, const float* value, float factor, const float* direction, float* to);
  /// Sums of the products of 2 x 2 sites; `second_row` is how far below the second row lies.
  void (*product_squares)(int squares, ConstElasticRow first, ConstElasticRow second, std::size_t second_row,
                          float* to);
  /// Sums of 2 x 2 numbers; both rows have 2 * squares of them. `to` may be `above`.
  void (*square_sums)(int squares, const float* above, const float* below, float* to);
  /// sums += column * load.
  void (*add_column)(int rows, const float* column, float load, float* sums);
};

namespace baseline {
void multiply_add(float* values, float factor, float term, int rounds);
extern const ElasticRows elastic_rows;
} // namespace baseline
namespace avx2 {
void multiply_add(float* values, float factor, float term, int rounds);
extern const ElasticRows elastic_rows;
} // namespace avx2
namespace avx512 {
void multiply_add(float* values, float factor, float term, int rounds);
extern const ElasticRows elastic_rows;
} // namespace avx512

} // namespace hdmbench::openmp
