#include "backends/cpu/cpu.hpp"

#include "backends/cpu/elastic_fields.hpp"
#include "backends/cpu/sweeper.hpp"

#include <omp.h>

#include <algorithm>
#include <vector>

namespace hdmbench {

namespace {

using openmp::Band;
using openmp::band_of;
using openmp::ConstElasticRow;
using openmp::ElasticRow;
using openmp::ElasticRows;
using openmp::Response;

/// From the first site of a row on.
ElasticRow row_of(const RingedGrid& grid, RingedField& field, int y) {
  return {field.x.data() + grid.index(0, y), field.y.data() + grid.index(0, y)};
}
ConstElasticRow row_of(const RingedGrid& grid, const RingedField& field, int y) {
  return {field.x.data() + grid.index(0, y), field.y.data() + grid.index(0, y)};
}

Response response_of(const ElasticLevel& level, int y) {
  const std::size_t at = level.grid.index(0, y);
  return {level.response[0].data() + at, level.response[1].data() + at, level.response[2].data() + at};
}

/// What one thread does on its band of rows: one row of cells after the other, each computed once, from which
/// the sites above and below take their forces.
class ElasticBand {
public:
  ElasticBand(const ElasticRows& rows, const ElasticHierarchy& hierarchy)
      : rows_(&rows), ratio_(hierarchy.ratio),
        pitch_(hierarchy.levels.front().grid.pitch + 2 * RingedGrid::margin), lines_(2 * line_count * pitch_),
        tension_(5 * pitch_) {}

  /// Copies the rows of other bands that touch `band`, before anybody overwrites them: residuals() reads
  /// these.
  void keep_neighbours(const RingedGrid& grid, const RingedField& values, Band band) {
    const auto keep = [&](int y, Line to) {
      const ElasticRow kept = line(to);
      const ConstElasticRow from = row_of(grid, values, y);
      // With the ring on both sides.
      std::copy_n(from.x - 1, grid.sites.width + 2, kept.x - 1);
      std::copy_n(from.y - 1, grid.sites.width + 2, kept.y - 1);
    };
    keep(band.first - 1, north_line);
    keep(band.last, south_line);
  }

  /// use(y, residual) for every row of the band, from the north on; where neighbours are `kept` it may
  /// overwrite row y of `values`. `load` may be null.
  template <typename Use>
  void residuals(const ElasticLevel& level, const RingedField& values, const RingedField* load, Band band,
                 bool kept, const Use& use) {
    if (band.first >= band.last) {
      return;
    }
    const auto row_at = [&](int y) {
      return kept && y < band.first   ? ConstElasticRow(line(north_line))
             : kept && y >= band.last ? ConstElasticRow(line(south_line))
                                      : row_of(level.grid, values, y);
    };
    cells(level, band.first - 1, row_at(band.first - 1), row_at(band.first));
    for (int y = band.first; y < band.last; ++y) {
      cells(level, y, row_at(y), row_at(y + 1));
      const ElasticRow result = line(residual_line);
      rows_->residual(level.grid.sites.width,
                      load == nullptr ? ConstElasticRow{} : row_of(level.grid, *load, y), on_below(y - 1),
                      line(above_line), result);
      use(y, ConstElasticRow(result));
    }
  }

  /// The load of coarse rows `band` from fine rows: rows(first and last fine row, use), which has use(y,
  /// residual) called for each of these in turn. A coarse row is written when it has its three.
  template <typename Rows>
  void restrict_rows(const ElasticLevel& fine, bool is_image, Band band, const RingedGrid& coarse,
                     RingedField& load, const Rows& rows) {
    const Extent sites = fine.grid.sites;
    const auto write_coarse = [&](int y) {
      const ElasticRow to = row_of(coarse, load, y);
      const ElasticRow before = restricted(2 * y - 1);
      const ElasticRow at = restricted(2 * y);
      const ElasticRow after = restricted(2 * y + 1);
      rows_->restrict_across(coarse.sites.width, before.x, at.x, after.x, to.x);
      rows_->restrict_across(coarse.sites.width, before.y, at.y, after.y, to.y);
    };
    for (int y = 0; y < 3; ++y) {
      clear(restricted(y));
    }
    const ElasticRow padded = line(padded_line);
    clear(padded); // beyond the width it stays 0
    const Band fine_rows{std::max(2 * band.first - 1, 0), std::min(2 * band.last, sites.height)};
    rows(fine_rows, [&](int y, ConstElasticRow residual) {
      std::copy_n(residual.x, sites.width, padded.x);
      std::copy_n(residual.y, sites.width, padded.y);
      if (is_image) {
        rows_->keep_free(sites.width, response_of(fine, y), padded);
      }
      const ElasticRow to = restricted(y);
      rows_->restrict_along(coarse.sites.width, padded.x, to.x);
      rows_->restrict_along(coarse.sites.width, padded.y, to.y);
      if (y % 2 != 0 && y / 2 >= band.first) { // row 2 Y + 1 completes coarse row Y
        write_coarse(y / 2);
      }
    });
    for (int y = sites.height / 2; y < band.last; ++y) { // those whose row 2 Y + 1 is not there
      clear(restricted(2 * y + 1));
      if (2 * y >= sites.height) {
        clear(restricted(2 * y));
      }
      write_coarse(y);
    }
  }

private:
  enum Line : std::size_t {
    above_line,
    below_line,
    other_below_line,
    residual_line,
    north_line,
    south_line,
    padded_line,
    restricted_line,
    line_count = restricted_line + 3
  };

  /// Two components with room for the ring.
  [[nodiscard]] ElasticRow line(std::size_t number) {
    float* const begin = lines_.data() + 2 * number * pitch_ + RingedGrid::margin;
    return {begin, begin + pitch_};
  }
  /// Where row y of cells puts its forces on the sites below.
  [[nodiscard]] ElasticRow on_below(int y) { return line(y % 2 == 0 ? below_line : other_below_line); }
  [[nodiscard]] ElasticRow restricted(int y) {
    return line(restricted_line + static_cast<std::size_t>((y + 3) % 3));
  }
  void clear(ElasticRow row) const {
    std::fill_n(row.x - 1, pitch_ - 2 * RingedGrid::margin, 0.0F);
    std::fill_n(row.y - 1, pitch_ - 2 * RingedGrid::margin, 0.0F);
  }

  /// Row y of cells: forces into above_line and on_below(y).
  void cells(const ElasticLevel& level, int y, ConstElasticRow above, ConstElasticRow below) {
    const std::size_t at = level.grid.index(-1, y);
    openmp::CellRow row;
    for (std::size_t i = 0; i < 6; ++i) {
      row.moments[i] = level.moments[i].data() + at;
    }
    row.above = {above.x - 1, above.y - 1};
    row.below = {below.x - 1, below.y - 1};
    row.cells = level.grid.sites.width + 1;
    row.nu = ratio_.nu;
    row.shear = ratio_.shear;
    for (std::size_t i = 0; i < 5; ++i) {
      row.tension[i] = tension_.data() + i * pitch_;
    }
    const ElasticRow on_above = line(above_line);
    const ElasticRow on_lower = on_below(y);
    rows_->tensions(row);
    rows_->forces(row, on_above, on_lower);
    const auto [first, last] = level.masked.row(y);
    for (std::size_t i = first; i < last; ++i) {
      const MaskedCell& cell = level.masked.cells[i];
      const auto x = static_cast<std::size_t>(cell.x);
      const float values[8] = {above.x[x], above.y[x], above.x[x + 1], above.y[x + 1],
                               below.x[x], below.y[x], below.x[x + 1], below.y[x + 1]};
      float force[8];
      rows_->masked_forces(cell.stiffness.data(), values, force);
      // Its moments are 0, so that it has added nothing yet; sums of two do not ask for their order.
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const ElasticRow& to = corner < 2 ? on_above : on_lower;
        to.x[x + corner % 2] += force[2 * corner];
        to.y[x + corner % 2] += force[2 * corner + 1];
      }
    }
  }

  const ElasticRows* rows_;
  ElasticInFloat::PoissonRatio ratio_;
  std::size_t pitch_;
  std::vector<float> lines_;
  std::vector<float> tension_;
};

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
    RingedField& values = fields_.at(level, field);
    in_bands(here.grid.sites.height, here.grid.sites, [&](Band band, ElasticBand& work) {
      // In place: a row is overwritten when both rows of cells beside it are done. Where bands meet, the
      // other band's row is kept as it was.
      work.keep_neighbours(here.grid, values, band);
#pragma omp barrier
      work.residuals(here, values, load_of(level, field), band, true, [&](int y, ConstElasticRow residual) {
        const ElasticRow to = row_of(here.grid, values, y);
        rows_.relax(here.grid.sites.width, to, residual, response_of(here, y), to);
      });
    });
  }

  void relax_from_zero(int level) override {
    const ElasticLevel& here = level_at(level);
    const RingedField& load = fields_.at(level, ElasticField::load);
    RingedField& correction = fields_.at(level, ElasticField::correction);
    for_each_row(here.grid, [&](int y) {
      rows_.relax(here.grid.sites.width, {}, row_of(here.grid, load, y), response_of(here, y),
                  row_of(here.grid, correction, y));
    });
  }

  void forces(ElasticField of, ElasticField to) override {
    const ElasticLevel& here = level_at(0);
    RingedField& result = fields_.at(0, to);
    const RingedField& values = fields_.at(0, of);
    in_bands(here.grid.sites.height, here.grid.sites, [&](Band band, ElasticBand& work) {
      work.residuals(here, values, nullptr, band, false, [&](int y, ConstElasticRow residual) {
        const ElasticRow row = row_of(here.grid, result, y);
        std::copy_n(residual.x, here.grid.sites.width, row.x);
        std::copy_n(residual.y, here.grid.sites.width, row.y);
        rows_.keep_free(here.grid.sites.width, response_of(here, y), row);
      });
    });
  }

  void restrict_residual(int level, ElasticField of) override {
    const RingedField& values = fields_.at(level, of);
    restrict_from(level, [&](ElasticBand& work, Band fine, const auto& use) {
      work.residuals(level_at(level), values, load_of(level, of), fine, false, use);
    });
  }
  void restrict_load(int level) override {
    const RingedField& from = fields_.at(level, ElasticField::load);
    restrict_from(level, [&](ElasticBand& /*work*/, Band fine, const auto& use) {
      for (int y = fine.first; y < fine.last; ++y) {
        use(y, row_of(grid(level), from, y));
      }
    });
  }

  void interpolate(int level) override {
    correct(level, ElasticField::correction, true);
  }
  void correct(int level, ElasticField field) override {
    correct(level, field, false);
  }

  void solve_coarsest() override {
    const RingedGrid& sites = grid(coarsest());
    const RingedField& load = fields_.at(coarsest(), ElasticField::load);
    RingedField& correction = fields_.at(coarsest(), ElasticField::correction);
    const std::size_t size = 2 * sites.sites.sites();
    std::vector<float> sums(size);
    const auto for_each_site = [&](const auto& call) {
      for (int y = 0; y < sites.sites.height; ++y) {
        for (int x = 0; x < sites.sites.width; ++x) {
          call(sites.sites.index(x, y), sites.index(x, y));
        }
      }
    };
    for_each_site([&](std::size_t site, std::size_t at) {
      const float* const column = hierarchy_->coarsest_inverse.data() + 2 * site * size;
      rows_.add_column(static_cast<int>(size), column, load.x[at], sums.data());
      rows_.add_column(static_cast<int>(size), column + size, load.y[at], sums.data());
    });
    for_each_site([&](std::size_t site, std::size_t at) {
      correction.x[at] = sums[2 * site];
      correction.y[at] = sums[2 * site + 1];
    });
  }

  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    RingedField& result = fields_.at(0, to);
    const RingedField& from = fields_.at(0, value);
    const RingedField& along = fields_.at(0, direction);
    for_each_row(grid(0), [&](int y) {
      const std::size_t at = grid(0).index(0, y);
      const int width = grid(0).sites.width;
      rows_.advance(width, from.x.data() + at, factor, along.x.data() + at, result.x.data() + at);
      rows_.advance(width, from.y.data() + at, factor, along.y.data() + at, result.y.data() + at);
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
  /// call(y) for every row of a level.
  template <typename Call>
  void for_each_row(const RingedGrid& level, const Call& call) const {
    in_bands(level.sites.height, level.sites, [&](Band band, ElasticBand& /*work*/) {
      for (int y = band.first; y < band.last; ++y) {
        call(y);
      }
    });
  }
  /// The load of level + 1 from what rows(work, fine rows, use) hands to use(y, row).
  template <typename Rows>
  void restrict_from(int level, const Rows& rows) {
    const RingedGrid& coarse = grid(level + 1);
    RingedField& load = fields_.at(level + 1, ElasticField::load);
    in_bands(coarse.sites.height, grid(level).sites, [&](Band band, ElasticBand& work) {
      work.restrict_rows(level_at(level), level == 0, band, coarse, load,
                         [&](Band fine, const auto& use) { rows(work, fine, use); });
    });
  }

  [[nodiscard]] const RingedField* load_of(int level, ElasticField field) const {
    return field == ElasticField::correction ? &fields_.at(level, ElasticField::load) : nullptr;
  }

  void correct(int level, ElasticField field, bool from_zero) {
    const ElasticLevel& here = level_at(level);
    const int width = here.grid.sites.width;
    const RingedField& correction = fields_.at(level + 1, ElasticField::correction);
    RingedField& values = fields_.at(level, field);
    for_each_row(here.grid, [&](int y) {
      const Response response = response_of(here, y);
      const ConstElasticRow first = row_of(grid(level + 1), correction, y / 2);
      const ConstElasticRow second = row_of(grid(level + 1), correction, y / 2 + y % 2);
      const ElasticRow row = row_of(here.grid, values, y);
      if (from_zero) {
        std::fill_n(row.x, width, 0.0F);
        std::fill_n(row.y, width, 0.0F);
      }
      rows_.correct(width, first.x, second.x, level == 0 ? response.xx : nullptr, row.x);
      rows_.correct(width, first.y, second.y, level == 0 ? response.yy : nullptr, row.y);
    });
  }

  /// The first level of the tree of dot() into sums_.
  [[nodiscard]] Extent product_squares(ElasticField first, ElasticField second) const {
    const RingedGrid& image = grid(0);
    const RingedField& a = fields_.at(0, first);
    const RingedField& b = fields_.at(0, second);
    // The ring is 0: what sticks out of an image of odd sides.
    const Extent squares{(image.sites.width + 1) / 2, (image.sites.height + 1) / 2};
    in_bands(squares.height, image.sites, [&](Band band, ElasticBand& /*work*/) {
      for (int y = band.first; y < band.last; ++y) {
        rows_.product_squares(squares.width, row_of(image, a, 2 * y), row_of(image, b, 2 * y), image.pitch,
                              sums_.data() + squares.index(0, y));
      }
    });
    return squares;
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
