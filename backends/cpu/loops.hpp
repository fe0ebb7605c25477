#pragma once

#include "kernels/specification/elastic/elastic.hpp"

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

/// The components of a row of sites; of an image there is no third.
struct ElasticRow {
  float* of[3] = {};
};
struct ConstElasticRow {
  ConstElasticRow() = default;
  ConstElasticRow(const ElasticRow& row) // NOLINT(google-explicit-constructor)
      : of{row.of[0], row.of[1], row.of[2]} {}

  const float* of[3] = {};
};

/// ElasticLevel::response of a row of sites.
struct Response {
  const float* entry[6] = {};
};

/// A row of cells. Pointers are to the first cell, and to the site at its first corner. All that is read is
/// set: there are many rows, and most are short.
template <std::size_t axes>
struct CellRow {
  /// The moments as ElasticLevel has them; in a volume's image four rows of moduli, as sites.
  const float* moments[axes == 2 ? 6 : 23];
  ConstElasticRow sites[2 << (axes - 2)]; ///< displacements of the rows at its corners: y, then z
  ElasticRatios<float> ratio;
  float bend; ///< ElasticLevel::bend
  int cells;
  /// Written: of an image the CellTension, of a volume the force on each corner, component by component.
  float* made[axes == 2 ? 5 : 24];
};

/// What is computed of rows of cells.
template <std::size_t axes>
struct CellRows {
  /// CellRow::made of all cells by their moments; of a volume's image of cells first ... last - 1 by eight
  /// moduli each, and of all as if each had the modulus of its first corner (null of an image).
  void (*by_moments)(const CellRow<axes>& row);
  void (*by_moduli)(const CellRow<axes>& row, int first, int last);
  void (*by_one_modulus)(const CellRow<axes>& row);
  /// The force of a masked cell from its matrix, column by column, and its displacements.
  void (*by_matrix)(const float* stiffness, const float* displacement, float* force);
  /// From CellRow::made, which is 0 before the first cell and after the last one, to the rows of sites.
  void (*forces)(const CellRow<axes>& row, const ElasticRow* to);
};

/// Rows of the elastic energy.
struct ElasticRows {
  template <std::size_t axes>
  [[nodiscard]] const CellRows<axes>& cells(bool are_boxes) const {
    if constexpr (axes == 2) {
      return of_image[are_boxes ? 1 : 0];
    } else {
      return of_volume[are_boxes ? 1 : 0];
    }
  }

  CellRows<2> of_image[2]; ///< of squares, of rectangles
  CellRows<3> of_volume[2];
  void (*add)(int count, const float* first, const float* second, float* sum);
  /// residual = (from_north + from_south), with the load where there is one.
  void (*residual)(int sites, const float* load, const float* from_north, const float* from_south,
                   float* residual);
  /// `to` may be `from`, whose pointers may be null: 0.
  void (*relax)(int axes, int sites, ConstElasticRow from, ConstElasticRow residual, const Response& response,
                ElasticRow to);
  /// In place: 0 where a component may not move.
  void (*keep_free)(int sites, const float* straight, float* values);
  /// From fine sites -1 ... 2 * sites - 1 of a row.
  void (*restrict_along)(int sites, const float* fine, float* to);
  void (*restrict_across)(int sites, const float* before, const float* at, const float* after, float* to);
  /// In place; `straight` is null where every component may move. The fine row is the first coarse one, or
  /// lies between 2 or 4 of them, whose sites are `stride` fine ones apart.
  void (*correct)(int fine_sites, int stride, int coarse_rows, const float* const* coarse,
                  const float* straight, float* values);
  void (*advance)(int count, const float* value, float factor, const float* direction, float* to);
  /// Sums of the products of 2 x 2 sites, in a volume of 2 x 2 x 2; the second row and the second plane lie
  /// so far behind the first.
  void (*product_squares)(int axes, int squares, ConstElasticRow first, ConstElasticRow second,
                          std::size_t second_row, std::size_t second_plane, float* to);
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
