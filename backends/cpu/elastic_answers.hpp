#pragma once

#include "backends/cpu/elastic_fields.hpp"

#include <array>
#include <cstddef>

namespace hdmbench {

/// What one step of a method makes of one site, from the fields as they stand, for any
/// scalar that specification/elastic compiles with: float is what `scalar` stores, a number that knows its
/// rounding is what certificates ask.
template <typename Scalar>
class ElasticAnswers {
  using Arithmetic = Elastic<Scalar>;
  using Volume = ElasticVolume<Scalar>;

public:
  /// The numbers of a site, as many as there are axes.
  using Answer = std::array<Scalar, 3>;

  /// Both must outlive this object.
  ElasticAnswers(const ElasticHierarchy& hierarchy, const ElasticFields& fields)
      : hierarchy_(hierarchy), fields_(fields), axes_(hierarchy.levels.front().grid.axes()) {}

  /// What a step makes of site (x, y, z) of level made_on().
  [[nodiscard]] Answer of(const MethodStep& step, int x, int y, int z) const {
    const int level = step.level;
    const std::size_t at = grid(level).index(x, y, z);
    switch (step.kind) {
    case MethodStep::Kind::write:
      return of_axes(
          [&](std::size_t axis) { return Scalar((*step.values)[axis][step.values->extent.index(x, y, z)]); });
    case MethodStep::Kind::relax:
      return moved(level, at, residual(level, step.from, x, y, z), value(level, step.from, at));
    case MethodStep::Kind::relax_from_zero:
      return moved(level, at, value(level, ElasticField::load, at), Answer{});
    case MethodStep::Kind::forces:
      return on_free(level, at, force_on(level, step.from, x, y, z));
    case MethodStep::Kind::restrict_residual:
    case MethodStep::Kind::restrict_load:
      return restricted(level, x, y, z, [&](int i, int j, int k) { return handed_down(step, i, j, k); });
    case MethodStep::Kind::interpolate:
      return corrected(level, Answer{}, x, y, z);
    case MethodStep::Kind::correct:
      return corrected(level, value(level, step.from, at), x, y, z);
    case MethodStep::Kind::solve_coarsest:
      return solved(level, x, y, z);
    default: // advance
      return of_axes([&](std::size_t axis) {
        return Arithmetic::advanced(value(level, step.from, at)[axis], Scalar(step.factor),
                                    value(level, step.direction, at)[axis]);
      });
    }
  }
  /// What a site of step.level hands to the coarser one.
  [[nodiscard]] Answer handed_down(const MethodStep& step, int x, int y, int z) const {
    const std::size_t at = grid(step.level).index(x, y, z);
    return on_free(step.level, at,
                   step.kind == MethodStep::Kind::restrict_load ? value(step.level, ElasticField::load, at)
                                                                : residual(step.level, step.from, x, y, z));
  }
  /// Returns what site (x, y, z) of level + 1 gets. fine(x, y, z) is the Answer of a site of `level`; beyond
  /// the image it is 0.
  template <typename Fine>
  [[nodiscard]] Answer restricted(int level, int x, int y, int z, const Fine& fine) const {
    const Extent sites = grid(level).sites;
    const Stride& stride = level_at(level + 1).stride;
    const auto inside = [&](int i, int j, int k) {
      const bool is_inside =
          i >= 0 && j >= 0 && k >= 0 && i < sites.width && j < sites.height && k < sites.depth;
      return is_inside ? fine(i, j, k) : Answer{};
    };
    const auto along = [&](std::size_t side, const auto& of) { // three beside each other, or one
      if (stride[side] == 1) {
        return of(0);
      }
      const std::array<Answer, 3> three{of(-1), of(0), of(1)};
      return of_axes([&](std::size_t axis) {
        return Arithmetic::restricted(three[0][axis], three[1][axis], three[2][axis]);
      });
    };
    const auto plane = [&](int k) {
      return along(1, [&](int j) {
        return along(0, [&](int i) { return inside(stride[0] * x + i, stride[1] * y + j, k); });
      });
    };
    return axes_ == 2 ? plane(0) : along(2, [&](int k) { return plane(stride[2] * z + k); });
  }
  [[nodiscard]] Scalar dot(ElasticField first, ElasticField second) const {
    Extent extent = grid(0).sites;
    std::vector<Scalar> sums;
    for_each_site(extent, [&](int x, int y, int z) {
      const std::size_t at = grid(0).index(x, y, z);
      const Answer a = value(0, first, at);
      const Answer b = value(0, second, at);
      const Scalar product = Arithmetic::site_product(a[0], b[0], a[1], b[1]);
      sums.push_back(axes_ == 2 ? product : Arithmetic::with_term(product, a[2], b[2]));
    });
    while (extent.sites() > 1) {
      const auto sum_of = [&](int x, int y, int z) { // of 2 x 2
        const auto one = [&](int i, int j) {
          const bool is_inside = 2 * x + i < extent.width && 2 * y + j < extent.height && z < extent.depth;
          return is_inside ? sums[extent.index(2 * x + i, 2 * y + j, z)] : Scalar(0.0F);
        };
        return Arithmetic::square_sum(one(0, 0), one(1, 0), one(0, 1), one(1, 1));
      };
      const Extent halves{(extent.width + 1) / 2, (extent.height + 1) / 2, (extent.depth + 1) / 2};
      std::vector<Scalar> next;
      for_each_site(halves, [&](int x, int y, int z) {
        next.push_back(axes_ == 2
                           ? sum_of(x, y, 0)
                           : Arithmetic::corrected_by_one(sum_of(x, y, 2 * z), sum_of(x, y, 2 * z + 1)));
      });
      sums = std::move(next);
      extent = halves;
    }
    return sums.front();
  }

private:
  /// number(axis) for each axis.
  template <typename Number>
  [[nodiscard]] Answer of_axes(const Number& number) const {
    Answer answer{};
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      answer[axis] = number(axis);
    }
    return answer;
  }

  /// Returns the correction of a site of the coarsest level.
  [[nodiscard]] Answer solved(int level, int x, int y, int z) const {
    const Extent sites = grid(level).sites;
    const std::size_t size = axes_ * sites.sites();
    const std::size_t row = axes_ * sites.index(x, y, z);
    Answer sum{};
    std::size_t column = 0;
    for_each_site(sites, [&](int i, int j, int k) {
      const Answer one = value(level, ElasticField::load, grid(level).index(i, j, k));
      for (std::size_t of = 0; of < axes_; ++of, ++column) {
        for (std::size_t axis = 0; axis < axes_; ++axis) {
          const Scalar entry(hierarchy_.coarsest_inverse[column * size + row + axis]);
          sum[axis] = Arithmetic::with_term(sum[axis], entry, one[of]);
        }
      }
    });
    return sum;
  }
  [[nodiscard]] const ElasticLevel& level_at(int level) const {
    return hierarchy_.levels.at(static_cast<std::size_t>(level));
  }
  [[nodiscard]] const RingedGrid& grid(int level) const { return level_at(level).grid; }
  [[nodiscard]] Answer value(int level, ElasticField field, std::size_t at) const {
    const RingedField& values = fields_.at(level, field);
    return of_axes([&](std::size_t axis) { return Scalar(values[axis][at]); });
  }
  /// Whether components of the level may be prescribed.
  [[nodiscard]] bool has_prescribed(int level) const { return level == 0 || axes_ == 3; }

  /// What cell (x, y, z) does to one of its corners, x in the lowest bit of its number. Cells of the ring do
  /// nothing.
  [[nodiscard]] Answer force_of_cell(int level, ElasticField field, int x, int y, int z,
                                     std::size_t corner) const {
    const ElasticLevel& here = level_at(level);
    const Extent cells = here.grid.cells();
    const RingedField& values = fields_.at(level, field);
    const std::size_t at = here.grid.index(x, y, z);
    if (x < 0 || y < 0 || z < 0 || x >= cells.width || y >= cells.height || z >= cells.depth) {
      return Answer{};
    }
    const auto site = [&](std::size_t axis, std::size_t of) {
      return Scalar(values[axis][at + here.grid.to_corner(of)]);
    };
    const auto [first, last] = here.masked.row(y, z);
    for (std::size_t i = first; i < last; ++i) {
      if (here.masked.x[i] == x) {
        return force_of_masked(here.masked, i, corner, site);
      }
    }
    if (here.ratio.has_boxes()) {
      return axes_ == 2 ? force_by_moments<Elastic<Scalar, true>>(here, at, corner, site)
                        : force_by_moments<ElasticVolume<Scalar, true>>(here, at, corner, site);
    }
    return axes_ == 2 ? force_by_moments<Arithmetic>(here, at, corner, site)
                      : force_by_moments<Volume>(here, at, corner, site);
  }

  template <typename Cells, typename Site>
  [[nodiscard]] Answer force_by_moments(const ElasticLevel& level, std::size_t at, std::size_t corner,
                                        const Site& site) const {
    const auto displacement = [&](std::size_t axis) {
      return Cells::corners_of([&](std::size_t of) { return site(axis, of); });
    };
    Answer answer{};
    Cells::for_each_force(level.template cell<Cells>(at), displacement, level.ratio.template as<Scalar>(),
                          [&](std::size_t axis, std::size_t of, const Scalar& force) {
                            answer[axis] = of == corner ? force : answer[axis];
                          });
    return answer;
  }

  template <typename Site>
  [[nodiscard]] Answer force_of_masked(const MaskedCells& masked, std::size_t cell, std::size_t corner,
                                       const Site& site) const {
    const float* const matrix = masked.matrix(cell);
    Answer force{};
    for (std::size_t column = 0; column < masked.components; ++column) {
      for (std::size_t axis = 0; axis < axes_; ++axis) {
        force[axis] = Arithmetic::masked_force(
            force[axis], Scalar(matrix[masked.components * column + axes_ * corner + axis]),
            site(column % axes_, column / axes_));
      }
    }
    return force;
  }

  /// Adds up the forces of the cells around: along x, then y, then z.
  [[nodiscard]] Answer force_on(int level, ElasticField field, int x, int y, int z) const {
    const auto slab = [&](int cell_z, std::size_t far) {
      const Answer north_west = force_of_cell(level, field, x - 1, y - 1, cell_z, far + 3);
      const Answer north_east = force_of_cell(level, field, x, y - 1, cell_z, far + 2);
      const Answer south_west = force_of_cell(level, field, x - 1, y, cell_z, far + 1);
      const Answer south_east = force_of_cell(level, field, x, y, cell_z, far);
      return of_axes([&](std::size_t axis) {
        return Arithmetic::square_sum(north_west[axis], north_east[axis], south_west[axis], south_east[axis]);
      });
    };
    return axes_ == 2 ? slab(0, 0) : sum_of(slab(z - 1, 4), slab(z, 0));
  }

  [[nodiscard]] Answer sum_of(const Answer& first, const Answer& second) const {
    return of_axes([&](std::size_t axis) { return Arithmetic::corrected_by_one(first[axis], second[axis]); });
  }

  /// With the load, where the field is a correction.
  [[nodiscard]] Answer residual(int level, ElasticField field, int x, int y, int z) const {
    const Answer force = force_on(level, field, x, y, z);
    return field != ElasticField::correction
               ? force
               : sum_of(value(level, ElasticField::load, grid(level).index(x, y, z)), force);
  }

  [[nodiscard]] Answer moved(int level, std::size_t at, const Answer& residual, const Answer& before) const {
    const auto response = [&](std::size_t row, std::size_t column) {
      return Scalar(level_at(level).response[symmetric_entry(axes_, row, column)][at]);
    };
    return of_axes([&](std::size_t axis) {
      const std::size_t other = axis == 0 ? 1 : 0;
      const std::size_t last = axis == 2 ? 1 : 2;
      return axes_ == 2 ? Arithmetic::relaxed(before[axis], response(axis, axis), residual[axis],
                                              response(axis, other), residual[other])
                        : Volume::relaxed_in_volume(before[axis], response(axis, axis), residual[axis],
                                                    response(axis, other), residual[other],
                                                    response(axis, last), residual[last]);
    });
  }

  [[nodiscard]] bool is_free(int level, std::size_t axis, std::size_t at) const {
    return !has_prescribed(level) || level_at(level).response[symmetric_entry(axes_, axis, axis)][at] > 0.0F;
  }

  /// On coarse levels of an image nothing pulls at prescribed components.
  [[nodiscard]] Answer on_free(int level, std::size_t at, const Answer& force) const {
    Answer result = force;
    for (std::size_t axis = 0; axis < axes_ && has_prescribed(level); ++axis) {
      const Scalar straight(level_at(level).response[symmetric_entry(axes_, axis, axis)][at]);
      result[axis] = Arithmetic::free_part(force[axis], straight);
    }
    return result;
  }

  [[nodiscard]] Answer corrected(int level, const Answer& before, int x, int y, int z) const {
    const RingedGrid& coarse = grid(level + 1);
    const std::size_t at = grid(level).index(x, y, z);
    const Stride& stride = level_at(level + 1).stride;
    const std::size_t first = coarse.index(x / stride[0], y / stride[1], z / stride[2]);
    Answer result = before;
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      const std::vector<float>& values = fields_.at(level + 1, ElasticField::correction)[axis];
      std::array<Scalar, 8> around{};
      std::size_t count = 0;
      for (std::size_t corner = 0; corner < std::size_t{1} << axes_; ++corner) {
        const auto bit = [&](std::size_t along) { return static_cast<int>(corner >> along & 1); };
        if (bit(0) <= x % stride[0] && bit(1) <= y % stride[1] && bit(2) <= z % stride[2]) {
          around[count++] = Scalar(values[first + coarse.to_corner(corner)]);
        }
      }
      if (!is_free(level, axis, at)) {
        continue;
      }
      const Scalar& value = before[axis];
      result[axis] = count == 1   ? Arithmetic::corrected_by_one(value, around[0])
                     : count == 2 ? Arithmetic::corrected_by_two(value, around[0], around[1])
                     : count == 4
                         ? Arithmetic::corrected_by_four(value, around[0], around[1], around[2], around[3])
                         : Volume::corrected_by_eight(value, around[0], around[1], around[2], around[3],
                                                      around[4], around[5], around[6], around[7]);
    }
    return result;
  }

  const ElasticHierarchy& hierarchy_;
  const ElasticFields& fields_;
  std::size_t axes_;
};

} // namespace hdmbench
