#pragma once

#include "backends/cpu/elastic_fields.hpp"

#include <array>
#include <cstddef>

namespace hdmbench {

/// What one step of a method (ElasticSession) makes of one site, from the fields as they stand, for any
/// scalar that specification/elastic compiles with: float is what `scalar` stores, a number that knows its
/// rounding is what certificates ask.
template <typename Scalar>
class ElasticAnswers {
  using Arithmetic = Elastic<Scalar>;
  using Force = typename Arithmetic::Force;
  using Moments = typename Arithmetic::CellMoments;
  using Corners = typename Arithmetic::CellCorners;
  using Tension = typename Arithmetic::CellTension;
  using Ratio = typename Arithmetic::PoissonRatio;

public:
  struct Answer {
    Scalar x;
    Scalar y;
  };

  /// Both must outlive this object.
  ElasticAnswers(const ElasticHierarchy& hierarchy, const ElasticFields& fields)
      : hierarchy_(hierarchy),
        fields_(fields), ratio_{Scalar(hierarchy.ratio.nu), Scalar(hierarchy.ratio.shear)} {}

  [[nodiscard]] Answer relax(int level, ElasticField field, int x, int y) const {
    const std::size_t at = grid(level).index(x, y);
    const RingedField& current = fields_.at(level, field);
    return moved(level, at, residual(level, field, x, y), Scalar(current.x[at]), Scalar(current.y[at]));
  }
  [[nodiscard]] Answer relax_from_zero(int level, int x, int y) const {
    return moved(level, grid(level).index(x, y), load(level, x, y), Scalar(0.0F), Scalar(0.0F));
  }
  [[nodiscard]] Answer forces(ElasticField of, int x, int y) const {
    return on_free(0, grid(0).index(x, y), force_on(0, of, x, y));
  }
  /// What a site of `level` hands to the coarser one.
  [[nodiscard]] Answer free_residual(int level, ElasticField of, int x, int y) const {
    return on_free(level, grid(level).index(x, y), residual(level, of, x, y));
  }
  [[nodiscard]] Answer free_load(int level, int x, int y) const {
    return on_free(level, grid(level).index(x, y), load(level, x, y));
  }
  /// Of site (x, y) of level + 1. fine(x, y) is the Answer of a site of `level`; beyond the image it is 0.
  template <typename Fine>
  [[nodiscard]] Answer restricted(int level, int x, int y, const Fine& fine) const {
    const Extent sites = grid(level).sites;
    const auto value = [&](int i, int j) {
      const bool inside = i >= 0 && j >= 0 && i < sites.width && j < sites.height;
      return inside ? fine(i, j) : Answer{Scalar(0.0F), Scalar(0.0F)};
    };
    std::array<Answer, 3> rows;
    for (int j = 0; j < 3; ++j) {
      const Answer before = value(2 * x - 1, 2 * y + j - 1);
      const Answer at = value(2 * x, 2 * y + j - 1);
      const Answer after = value(2 * x + 1, 2 * y + j - 1);
      rows[static_cast<std::size_t>(j)] = {Arithmetic::restricted(before.x, at.x, after.x),
                                           Arithmetic::restricted(before.y, at.y, after.y)};
    }
    return {Arithmetic::restricted(rows[0].x, rows[1].x, rows[2].x),
            Arithmetic::restricted(rows[0].y, rows[1].y, rows[2].y)};
  }
  /// Of a field that is not 0 before. Prescribed components are those of the image.
  [[nodiscard]] Answer correct(int level, ElasticField field, int x, int y) const {
    const std::size_t at = grid(level).index(x, y);
    const RingedField& values = fields_.at(level, field);
    return corrected(level, at, Scalar(values.x[at]), Scalar(values.y[at]), x, y);
  }
  [[nodiscard]] Answer interpolate(int level, int x, int y) const {
    return corrected(level, grid(level).index(x, y), Scalar(0.0F), Scalar(0.0F), x, y);
  }
  [[nodiscard]] Answer solve_coarsest(int x, int y) const {
    const int level = static_cast<int>(hierarchy_.levels.size()) - 1;
    const Extent sites = grid(level).sites;
    const std::size_t size = 2 * sites.sites();
    const std::size_t row = 2 * sites.index(x, y);
    const std::vector<float>& inverse = hierarchy_.coarsest_inverse;
    Answer sum{Scalar(0.0F), Scalar(0.0F)};
    for (int j = 0; j < sites.height; ++j) {
      for (int i = 0; i < sites.width; ++i) {
        const std::size_t column = 2 * sites.index(i, j);
        const Answer one = load(level, i, j);
        sum.x = Arithmetic::with_term(sum.x, Scalar(inverse[column * size + row]), one.x);
        sum.x = Arithmetic::with_term(sum.x, Scalar(inverse[(column + 1) * size + row]), one.y);
        sum.y = Arithmetic::with_term(sum.y, Scalar(inverse[column * size + row + 1]), one.x);
        sum.y = Arithmetic::with_term(sum.y, Scalar(inverse[(column + 1) * size + row + 1]), one.y);
      }
    }
    return sum;
  }
  [[nodiscard]] Answer advance(ElasticField value, float factor, ElasticField direction, int x, int y) const {
    const std::size_t at = grid(0).index(x, y);
    const RingedField& from = fields_.at(0, value);
    const RingedField& along = fields_.at(0, direction);
    return {Arithmetic::advanced(Scalar(from.x[at]), Scalar(factor), Scalar(along.x[at])),
            Arithmetic::advanced(Scalar(from.y[at]), Scalar(factor), Scalar(along.y[at]))};
  }
  [[nodiscard]] Scalar dot(ElasticField first, ElasticField second) const {
    Extent extent = grid(0).sites;
    std::vector<Scalar> sums(extent.sites());
    const RingedField& a = fields_.at(0, first);
    const RingedField& b = fields_.at(0, second);
    for (int y = 0; y < extent.height; ++y) {
      for (int x = 0; x < extent.width; ++x) {
        const std::size_t at = grid(0).index(x, y);
        sums[extent.index(x, y)] =
            Arithmetic::site_product(Scalar(a.x[at]), Scalar(b.x[at]), Scalar(a.y[at]), Scalar(b.y[at]));
      }
    }
    while (extent.sites() > 1) {
      const auto value = [&](int x, int y) {
        return x < extent.width && y < extent.height ? sums[extent.index(x, y)] : Scalar(0.0F);
      };
      const Extent squares{(extent.width + 1) / 2, (extent.height + 1) / 2};
      std::vector<Scalar> next(squares.sites());
      for (int y = 0; y < squares.height; ++y) {
        for (int x = 0; x < squares.width; ++x) {
          next[squares.index(x, y)] =
              Arithmetic::square_sum(value(2 * x, 2 * y), value(2 * x + 1, 2 * y), value(2 * x, 2 * y + 1),
                                     value(2 * x + 1, 2 * y + 1));
        }
      }
      sums = std::move(next);
      extent = squares;
    }
    return sums.front();
  }

private:
  [[nodiscard]] const ElasticLevel& level_at(int level) const {
    return hierarchy_.levels.at(static_cast<std::size_t>(level));
  }
  [[nodiscard]] const RingedGrid& grid(int level) const { return level_at(level).grid; }

  [[nodiscard]] Answer load(int level, int x, int y) const {
    const std::size_t at = grid(level).index(x, y);
    const RingedField& load = fields_.at(level, ElasticField::load);
    return {Scalar(load.x[at]), Scalar(load.y[at])};
  }

  /// What cell (x, y) does to its corner, 0 ... 3 in reading order. Cells of the ring do nothing.
  [[nodiscard]] Force force_of_cell(int level, ElasticField field, int x, int y, int corner) const {
    const ElasticLevel& here = level_at(level);
    const RingedField& values = fields_.at(level, field);
    const std::size_t at = here.grid.index(x, y);
    const auto corners = [&](const std::vector<float>& of) {
      return Corners{Scalar(of[at]), Scalar(of[at + 1]), Scalar(of[at + here.grid.pitch]),
                     Scalar(of[at + here.grid.pitch + 1])};
    };
    const Corners dx = corners(values.x);
    const Corners dy = corners(values.y);
    const auto [first, last] = here.masked.row(y);
    for (std::size_t i = first; i < last; ++i) {
      if (here.masked.cells[i].x == x) {
        return force_of_masked(here.masked.cells[i], dx, dy, corner);
      }
    }
    const ElasticInFloat::CellMoments cell = here.cell(at);
    const Moments moments{Scalar(cell.m),   Scalar(cell.mr),  Scalar(cell.ms),
                          Scalar(cell.mrr), Scalar(cell.mss), Scalar(cell.mrs)};
    const Tension tension = Arithmetic::cell_tension(moments, dx, dy, ratio_);
    return corner == 0   ? Arithmetic::force_on_top_left(tension)
           : corner == 1 ? Arithmetic::force_on_top_right(tension)
           : corner == 2 ? Arithmetic::force_on_bottom_left(tension)
                         : Arithmetic::force_on_bottom_right(tension);
  }

  [[nodiscard]] static Force force_of_masked(const MaskedCell& cell, const Corners& dx, const Corners& dy,
                                             int corner) {
    const std::array values{dx.top_left,    dy.top_left,    dx.top_right,    dy.top_right,
                            dx.bottom_left, dy.bottom_left, dx.bottom_right, dy.bottom_right};
    const std::size_t row = 2 * static_cast<std::size_t>(corner);
    Force force{Scalar(0.0F), Scalar(0.0F)};
    for (std::size_t column = 0; column < 8; ++column) {
      force.x = Arithmetic::masked_force(force.x, Scalar(cell.stiffness[8 * column + row]), values[column]);
      force.y =
          Arithmetic::masked_force(force.y, Scalar(cell.stiffness[8 * column + row + 1]), values[column]);
    }
    return force;
  }

  [[nodiscard]] Force force_on(int level, ElasticField field, int x, int y) const {
    return Arithmetic::sum_of_cells(
        force_of_cell(level, field, x - 1, y - 1, 3), force_of_cell(level, field, x, y - 1, 2),
        force_of_cell(level, field, x - 1, y, 1), force_of_cell(level, field, x, y, 0));
  }

  /// With the load, where the field is a correction.
  [[nodiscard]] Answer residual(int level, ElasticField field, int x, int y) const {
    const Force force = force_on(level, field, x, y);
    if (field != ElasticField::correction) {
      return {force.x, force.y};
    }
    const Answer pull = load(level, x, y);
    const Force left = Arithmetic::residual_of({pull.x, pull.y}, force);
    return {left.x, left.y};
  }

  [[nodiscard]] Answer moved(int level, std::size_t at, const Answer& residual, const Scalar& x,
                             const Scalar& y) const {
    const auto& response = level_at(level).response;
    const Scalar across(response[1][at]);
    return {Arithmetic::relaxed(x, Scalar(response[0][at]), residual.x, across, residual.y),
            Arithmetic::relaxed(y, Scalar(response[2][at]), residual.y, across, residual.x)};
  }

  template <typename Pair>
  [[nodiscard]] Answer on_free(int level, std::size_t at, const Pair& force) const {
    const auto& response = level_at(level).response;
    return level > 0 ? Answer{force.x, force.y} // on coarse levels nothing pulls at prescribed components
                     : Answer{Arithmetic::free_part(force.x, Scalar(response[0][at])),
                              Arithmetic::free_part(force.y, Scalar(response[2][at]))};
  }

  [[nodiscard]] Answer corrected(int level, std::size_t at, const Scalar& before_x, const Scalar& before_y,
                                 int x, int y) const {
    const RingedField& coarse = fields_.at(level + 1, ElasticField::correction);
    const RingedGrid& around = grid(level + 1);
    const std::array corners{around.index(x / 2, y / 2), around.index(x / 2 + x % 2, y / 2),
                             around.index(x / 2, y / 2 + y % 2), around.index(x / 2 + x % 2, y / 2 + y % 2)};
    const auto& response = level_at(level).response;
    const bool is_image = level == 0;
    return {is_image && !(response[0][at] > 0.0F) ? before_x : corrected(before_x, coarse.x, corners, x, y),
            is_image && !(response[2][at] > 0.0F) ? before_y : corrected(before_y, coarse.y, corners, x, y)};
  }

  [[nodiscard]] static Scalar corrected(const Scalar& value, const std::vector<float>& coarse,
                                        const std::array<std::size_t, 4>& around, int x, int y) {
    const auto at = [&](std::size_t corner) { return Scalar(coarse[around.at(corner)]); };
    if (x % 2 == 0 && y % 2 == 0) {
      return Arithmetic::corrected_by_one(value, at(0));
    }
    if (x % 2 == 0 || y % 2 == 0) {
      return Arithmetic::corrected_by_two(value, at(0), at(3));
    }
    return Arithmetic::corrected_by_four(value, at(0), at(1), at(2), at(3));
  }

  const ElasticHierarchy& hierarchy_;
  const ElasticFields& fields_;
  Ratio ratio_;
};

} // namespace hdmbench
