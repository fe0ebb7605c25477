#include "backends/cpu/cpu.hpp"

#include "backends/cpu/elastic_answers.hpp"
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

  /// use(y, residual) for every row of the band, from the north on, after the residual was written to row y
  /// of `to`; where that is null, to a row of this object. Where neighbours are `kept`, `use` may overwrite
  /// row y of `values`. `load` may be null.
  template <typename Use>
  void residuals(const ElasticLevel& level, const RingedField& values, const RingedField* load, Band band,
                 bool kept, RingedField* to, const Use& use) {
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
      const ElasticRow result = to == nullptr ? line(residual_line) : row_of(level.grid, *to, y);
      rows_->residual(level.grid.sites.width,
                      load == nullptr ? ConstElasticRow{} : row_of(level.grid, *load, y), on_below(y - 1),
                      line(above_line), result);
      use(y, result);
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
    line_count
  };

  /// Two components with room for the ring.
  [[nodiscard]] ElasticRow line(std::size_t number) {
    float* const begin = lines_.data() + 2 * number * pitch_ + RingedGrid::margin;
    return {begin, begin + pitch_};
  }
  /// Where row y of cells puts its forces on the sites below.
  [[nodiscard]] ElasticRow on_below(int y) { return line(y % 2 == 0 ? below_line : other_below_line); }

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
    residuals_.assign(hierarchy.levels.size(), {});
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
      work.residuals(here, values, load_of(level, field), band, true, nullptr,
                     [&](int y, const ElasticRow& residual) {
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
    free_residual(0, fields_.at(0, of), nullptr, fields_.at(0, to));
  }

  void restrict_residual(int level, ElasticField of) override {
    free_residual(level, fields_.at(level, of), load_of(level, of), residual_field(level));
    restrict_from(level, residual_field(level));
  }
  void restrict_load(int level) override {
    if (level > 0) {
      restrict_from(level, fields_.at(level, ElasticField::load));
      return;
    }
    RingedField& free = residual_field(0);
    free = fields_.at(0, ElasticField::load);
    for_each_row(grid(0), [&](int y) { keep_free(0, y, row_of(grid(0), free, y)); });
    restrict_from(0, free);
  }

  void interpolate(int level) override {
    correct(level, ElasticField::correction, true);
  }
  void correct(int level, ElasticField field) override {
    correct(level, field, false);
  }

  void solve_coarsest() override {
    // So few sites that lanes bring nothing.
    const ElasticAnswers<float> answers(*hierarchy_, fields_);
    const RingedGrid& coarse = grid(coarsest());
    RingedField& correction = fields_.at(coarsest(), ElasticField::correction);
    for (int y = 0; y < coarse.sites.height; ++y) {
      for (int x = 0; x < coarse.sites.width; ++x) {
        const auto solved = answers.solve_coarsest(x, y);
        correction.x[coarse.index(x, y)] = solved.x;
        correction.y[coarse.index(x, y)] = solved.y;
      }
    }
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
  /// What a level has to hand to the coarser one; made when it is first wanted.
  [[nodiscard]] RingedField& residual_field(int level) {
    RingedField& field = residuals_[static_cast<std::size_t>(level)];
    field.require(grid(level));
    return field;
  }
  /// 0 where a component of the image may not move.
  void keep_free(int level, int y, const ElasticRow& row) const {
    if (level == 0) {
      rows_.keep_free(grid(0).sites.width, response_of(level_at(0), y), row);
    }
  }
  void free_residual(int level, const RingedField& values, const RingedField* load, RingedField& to) const {
    const ElasticLevel& here = level_at(level);
    in_bands(here.grid.sites.height, here.grid.sites, [&](Band band, ElasticBand& work) {
      work.residuals(here, values, load, band, false, &to,
                     [&](int y, const ElasticRow& residual) { keep_free(level, y, residual); });
    });
  }
  /// The load of level + 1.
  void restrict_from(int level, const RingedField& fine) {
    const RingedGrid& coarse = grid(level + 1);
    RingedField& load = fields_.at(level + 1, ElasticField::load);
    for_each_row(coarse, [&](int y) {
      // Beyond the last row there is one of the ring.
      const ConstElasticRow before = row_of(grid(level), fine, 2 * y - 1);
      const ConstElasticRow at = row_of(grid(level), fine, 2 * y);
      const ConstElasticRow after = row_of(grid(level), fine, std::min(2 * y + 1, grid(level).sites.height));
      const ElasticRow to = row_of(coarse, load, y);
      rows_.restrict_rows(coarse.sites.width, before.x, at.x, after.x, to.x);
      rows_.restrict_rows(coarse.sites.width, before.y, at.y, after.y, to.y);
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
  std::vector<RingedField> residuals_;     ///< by level
  mutable std::vector<ElasticBand> bands_; ///< one a thread
  mutable std::vector<float> sums_;        ///< of dot()
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_openmp(int threads, const ElasticRows& rows,
                                                    std::size_t sites_worth_a_thread) {
  return std::make_unique<ElasticOpenMp>(threads, rows, sites_worth_a_thread);
}

} // namespace hdmbench
