#include "backends/cpu/cpu.hpp"

#include "backends/cpu/elastic_bands.hpp"
#include "backends/cpu/sweeper.hpp"

#include <omp.h>

#include <algorithm>

namespace hdmbench {

namespace {

using openmp::Band;
using openmp::band_of;
using openmp::ConstElasticRow;
using openmp::ElasticBand;
using openmp::ElasticRow;
using openmp::ElasticRows;
using openmp::row_of;

/// Threads share the rows of a level, each its own band; SIMD lanes share the sites of a row. What a site
/// gets does not depend on either.
class ElasticOpenMp final : public ElasticInMemory {
public:
  ElasticOpenMp(int threads, const ElasticRows& rows, std::size_t sites_worth_a_thread)
      : threads_(threads), rows_(rows), sites_worth_a_thread_(sites_worth_a_thread) {}

  void load(const ElasticHierarchy& hierarchy) override {
    ElasticInMemory::load(hierarchy);
    bands_.assign(static_cast<std::size_t>(threads_), ElasticBand(rows_, hierarchy));
    const Extent image = grid(0).sites;
    sums_.resize(std::max<std::size_t>(1, image.sites() / 2 + 2 * static_cast<std::size_t>(image.width + 2)));
  }

  void relax(int level, ElasticField field) override {
    const ElasticLevel& here = level_at(level);
    const RingedGrid& grid = here.grid;
    RingedField& values = fields_.at(level, field);
    in_bands(grid.sites.height, grid.sites, [&](Band band, ElasticBand& work) {
      // In place: a row is overwritten when both rows of cells beside it are done. Where bands meet, the
      // other band's row is kept as it was.
      work.keep_neighbours(grid, values, band);
#pragma omp barrier
      work.residuals(here, values, load_of(level, field), band, [&](int y, ConstElasticRow residual) {
        const ElasticRow to = row_of(grid, values, y);
        rows_.relax(grid.sites.width, to, residual, work.response(here, y), to);
      });
    });
  }

  void relax_from_zero(int level) override {
    const ElasticLevel& here = level_at(level);
    const RingedGrid& grid = here.grid;
    const RingedField& load = fields_.at(level, ElasticField::load);
    RingedField& correction = fields_.at(level, ElasticField::correction);
    in_bands(grid.sites.height, grid.sites, [&](Band band, ElasticBand& work) {
      for (int y = band.first; y < band.last; ++y) {
        rows_.relax(grid.sites.width, {}, row_of(grid, load, y), work.response(here, y),
                    row_of(grid, correction, y));
      }
    });
  }

  void forces(ElasticField of, ElasticField to) override {
    const ElasticLevel& here = level_at(0);
    const RingedGrid& grid = here.grid;
    RingedField& result = fields_.at(0, to);
    const RingedField& values = fields_.at(0, of);
    in_bands(grid.sites.height, grid.sites, [&](Band band, ElasticBand& work) {
      work.forget_neighbours();
      work.residuals(here, values, nullptr, band, [&](int y, ConstElasticRow residual) {
        const ElasticRow row = row_of(grid, result, y);
        std::copy_n(residual.x, grid.sites.width, row.x);
        std::copy_n(residual.y, grid.sites.width, row.y);
        rows_.keep_free(grid.sites.width, work.response(here, y), row);
      });
    });
  }

  void restrict_residual(int level, ElasticField of) override {
    const ElasticLevel& here = level_at(level);
    const RingedField& values = fields_.at(level, of);
    RingedField& load = fields_.at(level + 1, ElasticField::load);
    const RingedGrid& coarse = level_at(level + 1).grid;
    in_bands(coarse.sites.height, here.grid.sites, [&](Band band, ElasticBand& work) {
      work.forget_neighbours();
      const Band fine = work.fine_rows(here, band);
      work.begin_restriction();
      work.residuals(here, values, load_of(level, of), fine, [&](int y, ConstElasticRow residual) {
        work.restrict_row(here, level == 0, y, residual, band, coarse, load);
      });
      work.end_restriction(here, band, coarse, load);
    });
  }

  void restrict_load(int level) override {
    const ElasticLevel& here = level_at(level);
    const RingedField& from = fields_.at(level, ElasticField::load);
    RingedField& load = fields_.at(level + 1, ElasticField::load);
    const RingedGrid& coarse = level_at(level + 1).grid;
    in_bands(coarse.sites.height, here.grid.sites, [&](Band band, ElasticBand& work) {
      const Band fine = work.fine_rows(here, band);
      work.begin_restriction();
      for (int y = fine.first; y < fine.last; ++y) {
        work.restrict_row(here, level == 0, y, row_of(here.grid, from, y), band, coarse, load);
      }
      work.end_restriction(here, band, coarse, load);
    });
  }

  void interpolate(int level) override {
    correct(level, ElasticField::correction, true);
  }
  void correct(int level, ElasticField field) override {
    correct(level, field, false);
  }

  void solve_coarsest() override {
    const int level = coarsest();
    const RingedGrid& grid = level_at(level).grid;
    const RingedField& load = fields_.at(level, ElasticField::load);
    RingedField& correction = fields_.at(level, ElasticField::correction);
    const std::size_t size = 2 * grid.sites.sites();
    std::vector<float> sums(size);
    for_each_site(grid, [&](std::size_t site, std::size_t at) {
      const float* const column = hierarchy_->coarsest_inverse.data() + 2 * site * size;
      rows_.add_column(static_cast<int>(size), column, load.x[at], sums.data());
      rows_.add_column(static_cast<int>(size), column + size, load.y[at], sums.data());
    });
    for_each_site(grid, [&](std::size_t site, std::size_t at) {
      correction.x[at] = sums[2 * site];
      correction.y[at] = sums[2 * site + 1];
    });
  }

  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    const RingedGrid& grid = level_at(0).grid;
    RingedField& result = fields_.at(0, to);
    const RingedField& from = fields_.at(0, value);
    const RingedField& along = fields_.at(0, direction);
    in_bands(grid.sites.height, grid.sites, [&](Band band, ElasticBand& /*work*/) {
      for (int y = band.first; y < band.last; ++y) {
        const std::size_t at = grid.index(0, y);
        rows_.advance(grid.sites.width, from.x.data() + at, factor, along.x.data() + at,
                      result.x.data() + at);
        rows_.advance(grid.sites.width, from.y.data() + at, factor, along.y.data() + at,
                      result.y.data() + at);
      }
    });
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
  /// The first level of the tree into sums_.
  [[nodiscard]] Extent product_squares(ElasticField first, ElasticField second) const {
    const RingedGrid& grid = level_at(0).grid;
    const RingedField& a = fields_.at(0, first);
    const RingedField& b = fields_.at(0, second);
    // The ring is 0: what sticks out of an image of odd sides.
    const Extent squares{(grid.sites.width + 1) / 2, (grid.sites.height + 1) / 2};
    in_bands(squares.height, grid.sites, [&](Band band, ElasticBand& /*work*/) {
      for (int y = band.first; y < band.last; ++y) {
        rows_.product_squares(squares.width, row_of(grid, a, 2 * y), row_of(grid, b, 2 * y), grid.pitch,
                              sums_.data() + squares.index(0, y));
      }
    });
    return squares;
  }

  [[nodiscard]] const RingedField* load_of(int level, ElasticField field) const {
    return field == ElasticField::correction ? &fields_.at(level, ElasticField::load) : nullptr;
  }

  /// call(band, scratch) on every thread, for its share of `rows`.
  template <typename Call>
  void in_bands(int rows, Extent work, const Call& call) const {
    const std::size_t most = std::max<std::size_t>(
        1, std::min(work.sites() / sites_worth_a_thread_, static_cast<std::size_t>(rows) / 2));
    const int team = static_cast<int>(std::min(static_cast<std::size_t>(threads_), most));
#pragma omp parallel num_threads(team) if (team > 1)
    {
      const int thread = omp_get_thread_num();
      call(band_of(thread, omp_get_num_threads(), rows), bands_[static_cast<std::size_t>(thread)]);
    }
  }

  /// call(number in reading order, index) for every site.
  template <typename Call>
  static void for_each_site(const RingedGrid& grid, const Call& call) {
    for (int y = 0; y < grid.sites.height; ++y) {
      for (int x = 0; x < grid.sites.width; ++x) {
        call(grid.sites.index(x, y), grid.index(x, y));
      }
    }
  }

  void correct(int level, ElasticField field, bool from_zero) {
    const ElasticLevel& here = level_at(level);
    const RingedGrid& grid = here.grid;
    const RingedGrid& coarse = level_at(level + 1).grid;
    const RingedField& correction = fields_.at(level + 1, ElasticField::correction);
    RingedField& values = fields_.at(level, field);
    in_bands(grid.sites.height, grid.sites, [&](Band band, ElasticBand& work) {
      for (int y = band.first; y < band.last; ++y) {
        const openmp::Response response = work.response(here, y);
        const ConstElasticRow first = row_of(coarse, correction, y / 2);
        const ConstElasticRow second = row_of(coarse, correction, y / 2 + y % 2);
        const ElasticRow row = row_of(grid, values, y);
        if (from_zero) {
          std::fill_n(row.x, grid.sites.width, 0.0F);
          std::fill_n(row.y, grid.sites.width, 0.0F);
        }
        rows_.correct(grid.sites.width, first.x, second.x, level == 0 ? response.xx : nullptr, row.x);
        rows_.correct(grid.sites.width, first.y, second.y, level == 0 ? response.yy : nullptr, row.y);
      }
    });
  }

  /// The next level of the tree, in place of the one before: a row is written after it has been read.
  [[nodiscard]] Extent add_squares(Extent from) const {
    const Extent to{(from.width + 1) / 2, (from.height + 1) / 2};
    const auto width = static_cast<std::size_t>(from.width);
    std::vector<float> above(width + 1);
    std::vector<float> below(width + 1);
    for (int y = 0; y < to.height; ++y) {
      std::copy_n(sums_.data() + from.index(0, 2 * y), width, above.data());
      if (2 * y + 1 < from.height) {
        std::copy_n(sums_.data() + from.index(0, 2 * y + 1), width, below.data());
      } else {
        std::ranges::fill(below, 0.0F);
      }
      rows_.square_sums(to.width, above.data(), below.data(), sums_.data() + to.index(0, y));
    }
    return to;
  }

  int threads_;
  const ElasticRows& rows_;
  std::size_t sites_worth_a_thread_;
  mutable std::vector<ElasticBand> bands_; ///< one a thread
  mutable std::vector<float> sums_;        ///< of dot()
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_openmp(int threads, const ElasticRows& rows,
                                                    std::size_t sites_worth_a_thread) {
  return std::make_unique<ElasticOpenMp>(threads, rows, sites_worth_a_thread);
}

} // namespace hdmbench
