#pragma once

#include "backends/cpu/elastic_fields.hpp"
#include "backends/cpu/sweeper.hpp"
#include "kernels/data/shared_rows.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

/// What one thread does of a step of the elastic energy, row after row of cells. For elastic_openmp.cpp.
namespace hdmbench::openmp {

/// call(axis) for each. Written out: short loops over an unknown number cost more than their work.
template <typename Call>
void each_axis(std::size_t axes, const Call& call) {
  if (axes > 0) {
    call(std::size_t{0});
    call(std::size_t{1});
  }
  if (axes == 3) {
    call(std::size_t{2});
  }
}

/// The last axis of a grid is what threads share: rows of an image, planes of a volume. A plane of an image
/// is a single row.
struct Planes {
  explicit Planes(const RingedGrid& grid_)
      : grid(&grid_), rows(grid_.axes() == 3 ? grid_.sites.height : 1),
        count(grid_.axes() == 3 ? grid_.sites.depth : grid_.sites.height) {}

  [[nodiscard]] std::size_t index(int row, int plane) const {
    return grid->axes() == 3 ? grid->index(0, row, plane) : grid->index(0, plane);
  }

  const RingedGrid* grid;
  int rows; ///< of a plane
  int count;
};

/// From the first site of a row on.
inline ElasticRow row_of(const RingedGrid& grid, RingedField& field, std::size_t at) {
  ElasticRow row;
  each_axis(grid.axes(), [&](std::size_t axis) { row.of[axis] = field[axis].data() + at; });
  return row;
}
inline ConstElasticRow row_of(const RingedGrid& grid, const RingedField& field, std::size_t at) {
  ConstElasticRow row;
  each_axis(grid.axes(), [&](std::size_t axis) { row.of[axis] = field[axis].data() + at; });
  return row;
}

/// ElasticLevel::response, which is a quarter of what a volume takes where rows do not share memory.
using ResponseRows = std::vector<SharedRows>;

inline Response response_of(const ResponseRows& rows, std::size_t at) {
  Response response;
  for (std::size_t entry = 0; entry < rows.size(); ++entry) {
    response.entry[entry] = rows[entry].row(at);
  }
  return response;
}

/// Returns the response of a component to its own residual.
inline const float* straight_of(const ResponseRows& rows, std::size_t axis, std::size_t at) {
  return rows[symmetric_entry((rows.size() + 1) / 2, axis, axis)].row(at); // three of two axes, six of three
}

/// In which blocks of 16 cells a row of the image of a volume has cells of more than one modulus.
class MixedCells {
public:
  static constexpr int block = 16;

  MixedCells() = default;
  explicit MixedCells(const ElasticLevel& image)
      : rows_(image.grid.sites.height), blocks_(static_cast<std::size_t>(image.grid.sites.width / block + 1)),
        is_mixed_(blocks_ * static_cast<std::size_t>(rows_) *
                  static_cast<std::size_t>(image.grid.sites.depth)) {
    const Extent cells = image.grid.cells();
#pragma omp parallel for if (image.grid.sites.sites() > sites_worth_threads)
    for (int z = 0; z < cells.depth; ++z) {
      for (int y = 0; y < cells.height; ++y) {
        const float* const first = image.moments[0].data() + image.grid.index(0, y, z);
        std::uint8_t* const to = is_mixed_.data() + begin(y, z);
        for (int x = 0; x < cells.width; ++x) {
          bool differs = false;
          for (std::size_t corner = 1; corner < 8; ++corner) {
            differs |= first[x] != first[static_cast<std::size_t>(x) + image.grid.to_corner(corner)];
          }
          to[x / block] |= static_cast<std::uint8_t>(differs);
        }
      }
    }
  }

  /// call(first, last) for runs of cells of row (y, z), of which there are so many.
  template <typename Call>
  void for_each_run(int y, int z, int cells, const Call& call) const {
    const std::uint8_t* const mixed = is_mixed_.data() + begin(y, z);
    const int blocks = (cells + block - 1) / block;
    for (int first = 0; first < blocks;) {
      int last = first;
      while (last < blocks && mixed[last] != 0) {
        ++last;
      }
      if (last > first) {
        call(first * block, std::min(last * block, cells));
      }
      first = last + 1;
    }
  }

private:
  [[nodiscard]] std::size_t begin(int y, int z) const {
    return blocks_ *
           (static_cast<std::size_t>(z) * static_cast<std::size_t>(rows_) + static_cast<std::size_t>(y));
  }

  int rows_ = 0;
  std::size_t blocks_ = 0;
  std::vector<std::uint8_t> is_mixed_;
};

/// What one thread does on its band of planes: one row of cells after the other, each computed once, from
/// which the sites at its corners take their forces.
class ElasticBand {
public:
  ElasticBand(const ElasticRows& rows, const ElasticHierarchy& hierarchy, const MixedCells& mixed)
      : rows_(&rows), mixed_(&mixed), axes_(hierarchy.levels.front().grid.axes()),
        pitch_(hierarchy.levels.front().grid.pitch + 2 * RingedGrid::margin),
        lines_(axes_ * line_count * pitch_), made_((axes_ == 3 ? 24 : 5) * pitch_),
        plane_(static_cast<std::size_t>(Planes(hierarchy.levels.front().grid).rows) * pitch_) {}

  /// Copies the planes of other bands that touch `band`, before anybody overwrites them: residuals() reads
  /// these.
  void keep_neighbours(const RingedGrid& grid, const RingedField& values, Band band) {
    const Planes planes(grid);
    const auto keep = [&](int plane, PlaneBuffer to) {
      if (axes_ == 3 && (plane < 0 || plane >= planes.count)) {
        return; // no cell is there
      }
      for (int row = 0; row < planes.rows; ++row) {
        const ElasticRow kept = line_of(to, row);
        const ConstElasticRow from = row_of(grid, values, planes.index(row, plane));
        each_axis(axes_, [&](std::size_t axis) { // with the ring on both sides
          std::copy_n(from.of[axis] - 1, grid.sites.width + 2, kept.of[axis] - 1);
        });
      }
    };
    keep(band.first - 1, before_plane);
    keep(band.last, behind_plane);
  }

  /// use(row, plane, residual) for every row of the band's planes, in their order; where neighbours are
  /// `kept` it may overwrite that row of `values`. `load` may be null.
  template <typename Use>
  void residuals(const ElasticLevel& level, const RingedField& values, const RingedField* load, Band band,
                 bool kept, const Use& use) {
    if (band.first >= band.last) {
      return;
    }
    const Planes planes(level.grid);
    const auto row_at = [&](int row, int plane) {
      return kept && plane < band.first   ? ConstElasticRow(line_of(before_plane, row))
             : kept && plane >= band.last ? ConstElasticRow(line_of(behind_plane, row))
                                          : row_of(level.grid, values, planes.index(row, plane));
    };
    const int width = level.grid.sites.width;
    const ElasticRow near = line(near_line);
    const ElasticRow result = line(residual_line);
    for (int plane = band.first - 1; plane < band.last; ++plane) {
      if (axes_ == 3) {
        clear(line(south_));
        clear(line(far_south_));
      }
      for (int row = 0; row < planes.rows; ++row) {
        const ElasticRow carried = axes_ == 2 ? line(carried_) : line_of(carried_plane, row);
        const bool has_cells = cells(level, row, plane, row_at);
        if (plane >= band.first) {
          const ConstElasticRow pull =
              load == nullptr ? ConstElasticRow{} : row_of(level.grid, *load, planes.index(row, plane));
          each_axis(axes_, [&](std::size_t axis) {
            rows_->residual(width, pull.of[axis], carried.of[axis], near.of[axis], result.of[axis]);
          });
          use(row, plane, ConstElasticRow(result));
        }
        carry(has_cells, width, carried);
      }
    }
  }

  /// The load of coarse planes `band` from fine rows: rows(first and last fine plane, use), which has
  /// use(row, plane, residual) called for each of these in turn. A coarse plane is written when it has its
  /// three. `prescribed` is null where no component can be.
  template <typename Rows>
  void restrict_rows(const ElasticLevel& fine, const ResponseRows* prescribed, Band band,
                     const ElasticLevel& coarser, RingedField& load, const Rows& rows) {
    const RingedGrid& coarse = coarser.grid;
    const Planes from(fine.grid);
    const Planes to(coarse);
    const int width = coarse.sites.width;
    const bool halves_rows = axes_ == 3 && coarser.stride[1] == 2;
    const bool halves_planes = coarser.stride[axes_ - 1] == 2;
    const auto restricted_plane = [&](int plane) {
      return static_cast<PlaneBuffer>(restricted_planes + (plane + 3) % 3);
    };
    const auto restricted_row = [&](int row) {
      return line(static_cast<Line>(restricted_lines + (row + 3) % 3));
    };
    const auto across = [&](ConstElasticRow before, ConstElasticRow at, ConstElasticRow after,
                            ElasticRow sum) {
      each_axis(axes_, [&](std::size_t axis) {
        rows_->restrict_across(width, before.of[axis], at.of[axis], after.of[axis], sum.of[axis]);
      });
    };
    const auto clear_plane = [&](int plane) {
      for (int row = 0; row < to.rows; ++row) {
        clear(line_of(restricted_plane(plane), row));
      }
    };
    const auto write_coarse = [&](int plane) {
      for (int row = 0; row < to.rows; ++row) {
        across(line_of(restricted_plane(2 * plane - 1), row), line_of(restricted_plane(2 * plane), row),
               line_of(restricted_plane(2 * plane + 1), row), row_of(coarse, load, to.index(row, plane)));
      }
    };
    // What a plane is along rows and columns: a part of a coarse plane, or all of it.
    const auto in_plane = [&](int row, int plane) {
      return halves_planes ? line_of(restricted_plane(plane), row)
                           : row_of(coarse, load, to.index(row, plane));
    };
    for (int plane = 0; halves_planes && plane < 3; ++plane) {
      clear_plane(plane);
    }
    const ElasticRow padded = line(padded_line);
    clear(padded); // beyond the width it stays 0
    const Band fine_planes =
        halves_planes ? Band{std::max(2 * band.first - 1, 0), std::min(2 * band.last, from.count)} : band;
    rows(fine_planes, [&](int row, int plane, ConstElasticRow residual) {
      const ElasticRow along = halves_rows ? restricted_row(row) : in_plane(row, plane);
      // One after the other: what has just been written is slow to read.
      each_axis(axes_, [&](std::size_t axis) {
        std::copy_n(residual.of[axis], fine.grid.sites.width, padded.of[axis]);
      });
      each_axis(prescribed != nullptr ? axes_ : 0, [&](std::size_t axis) {
        rows_->keep_free(fine.grid.sites.width, straight_of(*prescribed, axis, from.index(row, plane)),
                         padded.of[axis]);
      });
      each_axis(axes_, [&](std::size_t axis) {
        if (coarser.stride[0] == 2) {
          rows_->restrict_along(width, padded.of[axis], along.of[axis]);
        } else {
          std::copy_n(padded.of[axis], width, along.of[axis]);
        }
      });
      const bool ends = row + 1 == from.rows;
      if (halves_rows) {
        const auto complete = [&](int coarse_row) {
          across(restricted_row(2 * coarse_row - 1), restricted_row(2 * coarse_row),
                 restricted_row(2 * coarse_row + 1), in_plane(coarse_row, plane));
        };
        if (row == 0) {
          clear(restricted_row(-1));
        }
        if (row % 2 != 0) {
          complete(row / 2);
        }
        if (ends) { // rows that are not there
          clear(restricted_row(row + 1));
          if (row % 2 != 0) {
            clear(restricted_row(row + 2));
          }
          complete((row + 1) / 2);
        }
      }
      if (halves_planes && plane % 2 != 0 && plane / 2 >= band.first && ends) {
        write_coarse(plane / 2);
      }
    });
    // Those whose plane 2 Z + 1 is not there.
    for (int plane = from.count / 2; halves_planes && plane < band.last; ++plane) {
      clear_plane(2 * plane + 1);
      if (2 * plane >= from.count) {
        clear_plane(2 * plane);
      }
      write_coarse(plane);
    }
  }

private:
  enum Line : std::size_t {
    near_line, ///< what a row of cells, and the one before it, do to the sites between, in their plane
    far_lines, ///< and in the next one: of an image, and what the row of cells before did
    north_line = far_lines + 2, ///< what a row of cells alone does to its first row of sites ...
    far_north_line,
    first_south_lines, ///< ... and to its second one, in both planes, twice: of this row and of the one
                       ///< before
    residual_line = first_south_lines + 4,
    padded_line,
    restricted_lines, ///< three
    line_count = restricted_lines + 3
  };
  enum PlaneBuffer : std::size_t {
    carried_plane, ///< what the plane of cells before did
    before_plane,
    behind_plane,
    restricted_planes, ///< three
    plane_count = restricted_planes + 3
  };

  /// All components, with room for the ring.
  [[nodiscard, gnu::always_inline]] ElasticRow line(Line number) { return row_in(lines_, number, pitch_, 0); }
  /// Row `row` of a plane, which takes memory from its first use on.
  [[nodiscard]] ElasticRow line_of(PlaneBuffer number, int row) {
    std::vector<float>& buffer = planes_.at(number);
    buffer.resize(axes_ * plane_);
    return row_in(buffer, 0, plane_, static_cast<std::size_t>(row) * pitch_);
  }
  [[nodiscard, gnu::always_inline]] ElasticRow row_in(std::vector<float>& buffer, std::size_t number,
                                                      std::size_t size, std::size_t offset) const {
    ElasticRow row;
    each_axis(axes_, [&](std::size_t axis) {
      row.of[axis] = buffer.data() + (axes_ * number + axis) * size + offset + RingedGrid::margin;
    });
    return row;
  }
  void clear(ElasticRow row) const {
    each_axis(axes_, [&](std::size_t axis) {
      std::fill_n(row.of[axis] - 1, pitch_ - 2 * RingedGrid::margin, 0.0F);
    });
  }

  /// The row of cells from row `row` of the sites of `plane` on: what it does goes to near_line, what it does
  /// to the next plane is kept for carry(). row_at(row, plane) has the displacements. Returns whether there
  /// are any cells.
  template <typename RowAt>
  bool cells(const ElasticLevel& level, int row, int plane, const RowAt& row_at) {
    const auto below = [&](int along_rows, int along_planes) {
      return row_at(row + along_rows, plane + along_planes);
    };
    if (axes_ == 2) {
      compute_cells<2>(level, plane, 0, {below(0, 0), below(0, 1)}, {line(near_line), line(far_)});
      return true;
    }
    const Extent cells = level.grid.cells();
    const bool is_there = row < cells.height && plane >= 0 && plane < cells.depth;
    if (is_there) {
      compute_cells<3>(level, row, plane, {below(0, 0), below(1, 0), below(0, 1), below(1, 1)},
                       {line(north_line), line(next_south_), line(far_north_line), line(next_far_south_)});
    }
    add(line(south_), is_there ? line(north_line) : ElasticRow{}, level.grid.sites.width, line(near_line));
    return is_there;
  }
  /// What the last cells() did to the next plane.
  void carry(bool has_cells, int width, ElasticRow carried) {
    if (axes_ == 2) {
      std::swap(carried_, far_);
      return;
    }
    add(line(far_south_), has_cells ? line(far_north_line) : ElasticRow{}, width, carried);
    if (has_cells) {
      std::swap(south_, next_south_);
      std::swap(far_south_, next_far_south_);
    }
  }
  /// sum = first + second, which may be null: 0.
  void add(ConstElasticRow first, ConstElasticRow second, int width, ElasticRow sum) const {
    each_axis(axes_, [&](std::size_t axis) {
      if (second.of[axis] == nullptr) {
        std::copy_n(first.of[axis], width, sum.of[axis]);
      } else {
        rows_->add(width, first.of[axis], second.of[axis], sum.of[axis]);
      }
    });
  }

  /// The row (y, z) of cells between these rows of sites, and what it does to them.
  template <std::size_t axes>
  void compute_cells(const ElasticLevel& level, int y, int z,
                     const std::array<ConstElasticRow, 2 << (axes - 2)>& sites,
                     const std::array<ElasticRow, 2 << (axes - 2)>& on_rows) {
    const std::size_t at = level.grid.index(0, y, z);
    const auto& rows = rows_->cells<axes>(level.ratio.has_boxes());
    openmp::CellRow<axes> row;
    const bool by_moduli = level.moments.size() == 1;
    for (std::size_t i = 0; i < (by_moduli ? sites.size() : level.moments.size()); ++i) {
      row.moments[i] = by_moduli ? level.moments[0].data() + at + level.grid.to_corner(2 * i)
                                 : level.moments[i].data() + at;
    }
    std::ranges::copy(sites, row.sites);
    row.ratio = level.ratio;
    row.bend = level.bend;
    row.cells = level.grid.sites.width - 1;
    for (std::size_t i = 0; i < std::size(row.made); ++i) {
      row.made[i] = made_.data() + i * pitch_ + RingedGrid::margin;
      row.made[i][-1] = row.made[i][row.cells] = 0.0F;
    }
    if (by_moduli) {
      rows.by_one_modulus(row);
      mixed_->for_each_run(y, z, row.cells, [&](int first, int last) { rows.by_moduli(row, first, last); });
    } else {
      rows.by_moments(row);
    }
    // A masked cell of an image, whose moments are 0, adds to sums of two, which do not ask for their order;
    // one of a volume takes its place among the others.
    if (axes == 2) {
      rows.forces(row, on_rows.data());
    }
    const auto [first, last] = level.masked.row(y, z);
    for (std::size_t i = first; i < last; ++i) {
      float displacement[24];
      float force[24];
      const auto x = static_cast<std::size_t>(level.masked.x[i]);
      for (std::size_t component = 0; component < axes << axes; ++component) {
        const std::size_t corner = component / axes;
        displacement[component] = sites[corner / 2].of[component % axes][x + corner % 2];
      }
      rows.by_matrix(level.masked.matrix(i), displacement, force);
      for (std::size_t component = 0; component < axes << axes; ++component) {
        const std::size_t corner = component / axes;
        if constexpr (axes == 2) {
          on_rows[corner / 2].of[component % axes][x + corner % 2] += force[component];
        } else {
          row.made[8 * (component % axes) + corner][x] = force[component];
        }
      }
    }
    if (axes == 3) {
      rows.forces(row, on_rows.data());
    }
  }

  const ElasticRows* rows_;
  const MixedCells* mixed_;
  std::size_t axes_;
  std::size_t pitch_;
  std::vector<float> lines_;
  std::vector<float> made_; ///< CellRow::made
  std::size_t plane_;       ///< floats of a component's plane
  std::array<std::vector<float>, plane_count> planes_;
  Line far_ = far_lines;
  Line carried_ = static_cast<Line>(far_lines + 1);
  Line south_ = first_south_lines;
  Line next_south_ = static_cast<Line>(first_south_lines + 1);
  Line far_south_ = static_cast<Line>(first_south_lines + 2);
  Line next_far_south_ = static_cast<Line>(first_south_lines + 3);
};

} // namespace hdmbench::openmp
