#include "backends/cpu/cpu.hpp"

#include "backends/cpu/elastic_band.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

using openmp::Band;
using openmp::band_of;
using openmp::ConstElasticRow;
using openmp::each_axis;
using openmp::ElasticBand;
using openmp::ElasticRow;
using openmp::ElasticRows;
using openmp::MixedCells;
using openmp::Planes;
using openmp::response_of;
using openmp::ResponseRows;
using openmp::row_of;
using openmp::straight_of;

/// Threads share the planes of a level, each its own band; SIMD lanes share the sites of a row. What a site
/// gets does not depend on either.
class ElasticOpenMp final : public ElasticInMemory {
public:
  ElasticOpenMp(int threads, const ElasticRows& rows, std::size_t sites_worth_a_thread)
      : threads_(threads), rows_(rows), sites_worth_a_thread_(sites_worth_a_thread) {}

  void take(const MethodStep& step) override {
    switch (step.kind) {
    case MethodStep::Kind::write:
      return fields_.write(step.level, step.to, *step.values);
    case MethodStep::Kind::relax:
      return relax_field(step.level, step.to);
    case MethodStep::Kind::relax_from_zero:
      return relax_zero(step.level);
    case MethodStep::Kind::forces:
      return make_forces(step.from, step.to);
    case MethodStep::Kind::restrict_residual:
    case MethodStep::Kind::restrict_load:
      return restrict_field(step);
    case MethodStep::Kind::interpolate:
    case MethodStep::Kind::correct:
      return correct_field(step);
    case MethodStep::Kind::solve_coarsest:
      return solve();
    case MethodStep::Kind::advance:
      return advance_field(step);
    }
  }

  float dot(ElasticField first, ElasticField second) const override {
    Extent squares = product_squares(first, second);
    while (squares.sites() > 1) {
      squares = add_squares(squares);
    }
    return sums_.front();
  }
  ScalarField dot_squares(ElasticField first, ElasticField second, int height) const override {
    if (height == 0) {
      return ElasticSession::dot_squares(first, second, height);
    }
    ScalarField result;
    result.extent = product_squares(first, second);
    for (int done = 1; done < height; ++done) {
      result.extent = add_squares(result.extent);
    }
    result.values.assign(sums_.begin(), sums_.begin() + static_cast<std::ptrdiff_t>(result.extent.sites()));
    return result;
  }

private:
  void do_load(ElasticHierarchy& hierarchy) override {
    ElasticInMemory::do_load(hierarchy);
    responses_.assign(hierarchy.levels.size(), {});
    for (std::size_t level = 0; level < responses_.size(); ++level) {
      const RingedGrid& grid = hierarchy.levels[level].grid;
      std::vector<std::vector<float>>& entries = hierarchy.levels[level].response;
      responses_[level].resize(entries.size());
      on_all_threads(entries.size(), grid.sites.sites() > sites_worth_threads, [&](std::size_t entry) {
        responses_[level][entry] =
            SharedRows(entries[entry], grid.pitch, grid.plane / grid.pitch, RingedGrid::margin);
        responses_[level][entry].shrink();
      });
    }
    mixed_ = axes() == 3 ? MixedCells(hierarchy.levels.front()) : MixedCells();
    bands_.assign(static_cast<std::size_t>(threads_), ElasticBand(rows_, hierarchy, mixed_));
    sums_.resize(halves(grid(0).sites).sites());
  }

  void relax_field(int level, ElasticField field) {
    const ElasticLevel& here = level_at(level);
    RingedField& values = fields_.at(level, field);
    const Planes planes(here.grid);
    in_bands(planes.count, here.grid.sites, [&](Band band, ElasticBand& work) {
      // In place: a row is overwritten when all rows of cells beside it are done. Where bands meet, the
      // other band's plane is kept as it was.
      work.keep_neighbours(here.grid, values, band);
#pragma omp barrier
      work.residuals(
          here, values, load_of(level, field), band, true, [&](int row, int plane, ConstElasticRow residual) {
            const std::size_t at = planes.index(row, plane);
            const ElasticRow to = row_of(here.grid, values, at);
            rows_.relax(axes(), here.grid.sites.width, to, residual, response_of(responses(level), at), to);
          });
    });
  }

  void relax_zero(int level) {
    const ElasticLevel& here = level_at(level);
    const RingedField& load = fields_.at(level, ElasticField::load);
    RingedField& correction = fields_.at(level, ElasticField::correction);
    for_each_row(here.grid, [&](int y, int z) {
      const std::size_t at = here.grid.index(0, y, z);
      rows_.relax(axes(), here.grid.sites.width, {}, row_of(here.grid, load, at),
                  response_of(responses(level), at), row_of(here.grid, correction, at));
    });
  }

  void make_forces(ElasticField of, ElasticField to) {
    const ElasticLevel& here = level_at(0);
    RingedField& result = fields_.at(0, to);
    const RingedField& values = fields_.at(0, of);
    const Planes planes(here.grid);
    in_bands(planes.count, here.grid.sites, [&](Band band, ElasticBand& work) {
      work.residuals(here, values, nullptr, band, false, [&](int row, int plane, ConstElasticRow residual) {
        const std::size_t at = planes.index(row, plane);
        each_axis(here.grid.axes(), [&](std::size_t axis) {
          std::copy_n(residual.of[axis], here.grid.sites.width, result[axis].data() + at);
          rows_.keep_free(here.grid.sites.width, straight_of(responses(0), axis, at),
                          result[axis].data() + at);
        });
      });
    });
  }

  /// The load of the coarser level, from a residual or from the load of this one.
  void restrict_field(const MethodStep& step) {
    const ElasticLevel& here = level_at(step.level);
    const RingedField& values = fields_.at(step.level, step.from);
    const ElasticLevel& coarse = level_at(step.level + 1);
    const Planes planes(here.grid);
    RingedField& load = fields_.at(step.level + 1, ElasticField::load);
    in_bands(Planes(coarse.grid).count, here.grid.sites, [&](Band band, ElasticBand& work) {
      work.restrict_rows(here, prescribed(step.level), band, coarse, load, [&](Band fine, const auto& use) {
        if (step.kind == MethodStep::Kind::restrict_residual) {
          work.residuals(here, values, load_of(step.level, step.from), fine, false, use);
          return;
        }
        for (int plane = fine.first; plane < fine.last; ++plane) {
          for (int row = 0; row < planes.rows; ++row) {
            use(row, plane, row_of(here.grid, values, planes.index(row, plane)));
          }
        }
      });
    });
  }

  void solve() {
    const RingedGrid& sites = grid(coarsest());
    const RingedField& load = fields_.at(coarsest(), ElasticField::load);
    RingedField& correction = fields_.at(coarsest(), ElasticField::correction);
    const std::size_t size = sites.axes() * sites.sites.sites();
    std::vector<float> sums(size);
    const auto for_each_component = [&](const auto& call) {
      std::size_t component = 0;
      for_each_site(sites.sites, [&](int x, int y, int z) {
        each_axis(sites.axes(), [&](std::size_t axis) { call(component++, axis, sites.index(x, y, z)); });
      });
    };
    for_each_component([&](std::size_t component, std::size_t axis, std::size_t at) {
      rows_.add_column(static_cast<int>(size), hierarchy().coarsest_inverse.data() + component * size,
                       load[axis][at], sums.data());
    });
    for_each_component([&](std::size_t component, std::size_t axis, std::size_t at) {
      correction[axis][at] = sums[component];
    });
  }

  void advance_field(const MethodStep& step) {
    RingedField& result = fields_.at(0, step.to);
    const RingedField& from = fields_.at(0, step.from);
    const RingedField& along = fields_.at(0, step.direction);
    for_each_row(grid(0), [&](int y, int z) {
      const std::size_t at = grid(0).index(0, y, z);
      each_axis(grid(0).axes(), [&](std::size_t axis) {
        rows_.advance(grid(0).sites.width, from[axis].data() + at, step.factor, along[axis].data() + at,
                      result[axis].data() + at);
      });
    });
  }

  [[nodiscard]] int axes() const {
    return static_cast<int>(grid(0).axes());
  }
  /// Of the sides.
  [[nodiscard]] static Extent halves(Extent sites) {
    return {(sites.width + 1) / 2, (sites.height + 1) / 2, (sites.depth + 1) / 2};
  }

  /// call(band, scratch) on every thread, for its share of `planes`.
  template <typename Call>
  void in_bands(int planes, Extent work, const Call& call) const {
    const std::size_t most = std::max<std::size_t>(
        1, std::min(work.sites() / sites_worth_a_thread_, static_cast<std::size_t>(planes) / 2));
    const int team = static_cast<int>(std::min(static_cast<std::size_t>(threads_), most));
#pragma omp parallel num_threads(team) if (team > 1)
    {
      const int thread = omp_get_thread_num();
      call(band_of(thread, omp_get_num_threads(), planes), bands_[static_cast<std::size_t>(thread)]);
    }
  }
  /// call(y, z) for every row of a level.
  template <typename Call>
  void for_each_row(const RingedGrid& level, const Call& call) const {
    const int rows = level.sites.height * level.sites.depth;
    in_bands(rows, level.sites, [&](Band band, ElasticBand& /*work*/) {
      int z = band.first / level.sites.height;
      int y = band.first % level.sites.height;
      for (int row = band.first; row < band.last; ++row, ++y) {
        if (y == level.sites.height) {
          y = 0;
          ++z;
        }
        call(y, z);
      }
    });
  }
  [[nodiscard]] const RingedField* load_of(int level, ElasticField field) const {
    return field == ElasticField::correction ? &fields_.at(level, ElasticField::load) : nullptr;
  }
  [[nodiscard]] const ResponseRows& responses(int level) const {
    return responses_[static_cast<std::size_t>(level)];
  }
  /// Null where no component of the level can be prescribed.
  [[nodiscard]] const ResponseRows* prescribed(int level) const {
    return level == 0 || axes() == 3 ? &responses(level) : nullptr;
  }

  void correct_field(const MethodStep& step) {
    const int level = step.level;
    const bool from_zero = step.kind == MethodStep::Kind::interpolate;
    const ElasticLevel& here = level_at(level);
    const RingedGrid& coarse = grid(level + 1);
    const Stride& stride = level_at(level + 1).stride;
    const ResponseRows* const fixed = prescribed(level);
    const int width = here.grid.sites.width;
    const RingedField& correction = fields_.at(level + 1, ElasticField::correction);
    RingedField& values = fields_.at(level, step.to);
    for_each_row(here.grid, [&](int y, int z) {
      const std::size_t at = here.grid.index(0, y, z);
      each_axis(here.grid.axes(), [&](std::size_t axis) {
        const float* between[4] = {};
        int rows = 0;
        for (int plane = 0; plane <= z % stride[2]; ++plane) {
          for (int row = 0; row <= y % stride[1]; ++row) {
            between[rows++] =
                correction[axis].data() + coarse.index(0, y / stride[1] + row, z / stride[2] + plane);
          }
        }
        float* const to = values[axis].data() + at;
        if (from_zero) {
          std::fill_n(to, width, 0.0F);
        }
        rows_.correct(width, stride[0], rows, between,
                      fixed != nullptr ? straight_of(*fixed, axis, at) : nullptr, to);
      });
    });
  }

  /// The first level of the tree of dot() into sums_.
  [[nodiscard]] Extent product_squares(ElasticField first, ElasticField second) const {
    const RingedGrid& image = grid(0);
    const RingedField& a = fields_.at(0, first);
    const RingedField& b = fields_.at(0, second);
    // The ring is 0: what sticks out of an image of odd sides.
    const Extent squares = halves(image.sites);
    in_bands(squares.height * squares.depth, image.sites, [&](Band band, ElasticBand& /*work*/) {
      for (int row = band.first; row < band.last; ++row) {
        const std::size_t at = image.index(0, 2 * (row % squares.height), 2 * (row / squares.height));
        rows_.product_squares(axes(), squares.width, row_of(image, a, at), row_of(image, b, at), image.pitch,
                              image.plane, sums_.data() + squares.index(0, row));
      }
    });
    return squares;
  }
  /// The next level of the tree, in place of the one before: a row is written after it has been read.
  [[nodiscard]] Extent add_squares(Extent from) const {
    const Extent to = halves(from);
    const auto width = static_cast<std::size_t>(from.width);
    const bool is_volume = axes() == 3;
    std::array<std::vector<float>, 4> rows; // of one plane, then of the next
    for (auto& row : rows) {
      row.resize(width + 1);
    }
    for (int z = 0; z < to.depth; ++z) {
      for (int y = 0; y < to.height; ++y) {
        for (std::size_t number = 0; number < (is_volume ? 4 : 2); ++number) {
          const int from_y = 2 * y + static_cast<int>(number % 2);
          const int from_z = 2 * z + static_cast<int>(number / 2);
          if (from_y < from.height && from_z < from.depth) {
            std::copy_n(sums_.data() + from.index(0, from_y, from_z), width, rows[number].data());
          } else {
            std::ranges::fill(rows[number], 0.0F);
          }
        }
        float* const sums = sums_.data() + to.index(0, y, z);
        rows_.square_sums(to.width, rows[0].data(), rows[1].data(), is_volume ? rows[0].data() : sums);
        if (is_volume) {
          rows_.square_sums(to.width, rows[2].data(), rows[3].data(), rows[2].data());
          rows_.add(to.width, rows[0].data(), rows[2].data(), sums);
        }
      }
    }
    return to;
  }

  int threads_;
  const ElasticRows& rows_;
  std::size_t sites_worth_a_thread_;
  std::vector<ResponseRows> responses_;    ///< by level
  MixedCells mixed_;                       ///< of a volume
  mutable std::vector<ElasticBand> bands_; ///< one a thread
  mutable std::vector<float> sums_;        ///< of dot()
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_openmp(int threads, const ElasticRows& rows,
                                                    std::size_t sites_worth_a_thread) {
  return std::make_unique<ElasticOpenMp>(threads, rows, sites_worth_a_thread);
}

} // namespace hdmbench
