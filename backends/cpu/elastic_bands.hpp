#pragma once

#include "backends/cpu/elastic_fields.hpp"
#include "backends/cpu/elastic_rows.hpp"
#include "backends/cpu/sweeper.hpp"
#include "kernels/data/elastic/hierarchy.hpp"

#include <vector>

namespace hdmbench::openmp {

/// From the first site of a row on.
[[nodiscard]] inline ElasticRow row_of(const RingedGrid& grid, RingedField& field, int y) {
  return {field.x.data() + grid.index(0, y), field.y.data() + grid.index(0, y)};
}
[[nodiscard]] inline ConstElasticRow row_of(const RingedGrid& grid, const RingedField& field, int y) {
  return {field.x.data() + grid.index(0, y), field.y.data() + grid.index(0, y)};
}

/// What one thread does on its band of rows: one row of cells after the other, each computed once, from which
/// the sites above and below take their forces.
class ElasticBand {
public:
  ElasticBand(const ElasticRows& rows, const ElasticHierarchy& hierarchy);

  /// Copies the rows of other bands that touch `band`, before anybody overwrites them.
  void keep_neighbours(const RingedGrid& grid, const RingedField& values, Band band);
  /// Those rows are read in place.
  void forget_neighbours() { kept_ = false; }

  /// use(y, residual) for every row of the band, from the north on; it may overwrite row y of `values`.
  /// `load` may be null.
  template <typename Use>
  void residuals(const ElasticLevel& level, const RingedField& values, const RingedField* load, Band band,
                 const Use& use) {
    const int width = level.grid.sites.width;
    if (band.first >= band.last) {
      return;
    }
    cells(level, values, band.first - 1, band);
    for (int y = band.first; y < band.last; ++y) {
      cells(level, values, y, band);
      const ElasticRow result = line(residual_line);
      rows_->residual(width, load == nullptr ? ConstElasticRow{} : row_of(level.grid, *load, y),
                      on_below(y - 1), line(above_line), result);
      use(y, ConstElasticRow(result));
    }
  }

  [[nodiscard]] static Response response(const ElasticLevel& level, int y) {
    const std::size_t at = level.grid.index(0, y);
    return {level.response[0].data() + at, level.response[1].data() + at, level.response[2].data() + at};
  }

  /// The fine rows from which a band of coarse rows is restricted.
  [[nodiscard]] static Band fine_rows(const ElasticLevel& fine, Band coarse);
  /// Restriction takes the fine rows one by one and writes a coarse row when it has its three.
  void begin_restriction();
  void restrict_row(const ElasticLevel& fine, bool is_image, int y, ConstElasticRow residual, Band band,
                    const RingedGrid& coarse, RingedField& load);
  /// The last coarse row of the image, where it lies on the last fine one or beyond.
  void end_restriction(const ElasticLevel& fine, Band band, const RingedGrid& coarse, RingedField& load);

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

  [[nodiscard]] ConstElasticRow values_of(const ElasticLevel& level, const RingedField& values, int y,
                                          Band band);
  /// Row y of cells: forces into above_line and on_below(y).
  void cells(const ElasticLevel& level, const RingedField& values, int y, Band band);
  void masked_cells(const ElasticLevel& level, int y, ConstElasticRow above, ConstElasticRow below);
  void write_coarse(int y, const RingedGrid& coarse, RingedField& load);
  void clear(ElasticRow row);

  const ElasticRows* rows_;
  ElasticInFloat::PoissonRatio ratio_;
  std::size_t pitch_;
  std::vector<float> lines_;
  std::vector<float> tension_;
  bool kept_ = false;
};

} // namespace hdmbench::openmp
