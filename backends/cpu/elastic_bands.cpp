#include "backends/cpu/elastic_bands.hpp"

#include <algorithm>

namespace hdmbench::openmp {

ElasticBand::ElasticBand(const ElasticRows& rows, const ElasticHierarchy& hierarchy)
    : rows_(&rows), ratio_(hierarchy.ratio),
      pitch_(hierarchy.levels.front().grid.pitch + 2 * RingedGrid::margin), lines_(2 * line_count * pitch_),
      tension_(5 * pitch_) {}

void ElasticBand::keep_neighbours(const RingedGrid& grid, const RingedField& values, Band band) {
  const auto keep = [&](int y, Line to) {
    const ElasticRow kept = line(to);
    const ConstElasticRow from = row_of(grid, values, y);
    // With the ring on both sides.
    std::copy_n(from.x - 1, grid.sites.width + 2, kept.x - 1);
    std::copy_n(from.y - 1, grid.sites.width + 2, kept.y - 1);
  };
  keep(band.first - 1, north_line);
  keep(band.last, south_line);
  kept_ = true;
}

ConstElasticRow ElasticBand::values_of(const ElasticLevel& level, const RingedField& values, int y,
                                       Band band) {
  if (kept_ && y < band.first) {
    return line(north_line);
  }
  if (kept_ && y >= band.last) {
    return line(south_line);
  }
  return row_of(level.grid, values, y);
}

void ElasticBand::cells(const ElasticLevel& level, const RingedField& values, int y, Band band) {
  const ConstElasticRow above = values_of(level, values, y, band);
  const ConstElasticRow below = values_of(level, values, y + 1, band);
  const std::size_t at = level.grid.index(-1, y);
  CellRow row;
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
  rows_->tensions(row);
  rows_->forces(row, line(above_line), on_below(y));
  masked_cells(level, y, above, below);
}

void ElasticBand::masked_cells(const ElasticLevel& level, int y, ConstElasticRow above,
                               ConstElasticRow below) {
  const ElasticRow on_above = line(above_line);
  const ElasticRow on_lower = on_below(y);
  const auto [first, last] = level.masked.row(y);
  for (std::size_t i = first; i < last; ++i) {
    const MaskedCell& cell = level.masked.cells[i];
    const auto x = static_cast<std::size_t>(cell.x);
    const float values[8] = {above.x[x], above.y[x], above.x[x + 1], above.y[x + 1],
                             below.x[x], below.y[x], below.x[x + 1], below.y[x + 1]};
    float force[8];
    rows_->masked_forces(cell.stiffness.data(), values, force);
    // Its moments are 0, so that it has added nothing yet; sums of two do not ask for their order.
    on_above.x[x] += force[0];
    on_above.y[x] += force[1];
    on_above.x[x + 1] += force[2];
    on_above.y[x + 1] += force[3];
    on_lower.x[x] += force[4];
    on_lower.y[x] += force[5];
    on_lower.x[x + 1] += force[6];
    on_lower.y[x + 1] += force[7];
  }
}

Band ElasticBand::fine_rows(const ElasticLevel& fine, Band coarse) {
  const int height = fine.grid.sites.height;
  return {std::max(2 * coarse.first - 1, 0), std::min(2 * coarse.last, height)};
}

void ElasticBand::clear(ElasticRow row) {
  std::fill_n(row.x - 1, pitch_ - 2 * RingedGrid::margin, 0.0F);
  std::fill_n(row.y - 1, pitch_ - 2 * RingedGrid::margin, 0.0F);
}

void ElasticBand::begin_restriction() {
  for (int y = 0; y < 3; ++y) {
    clear(restricted(y));
  }
  clear(line(padded_line));
}

void ElasticBand::restrict_row(const ElasticLevel& fine, bool is_image, int y, ConstElasticRow residual,
                               Band band, const RingedGrid& coarse, RingedField& load) {
  const int width = fine.grid.sites.width;
  const ElasticRow padded = line(padded_line); // beyond the width it stays 0
  std::copy_n(residual.x, width, padded.x);
  std::copy_n(residual.y, width, padded.y);
  if (is_image) {
    rows_->keep_free(width, response(fine, y), padded);
  }
  const ElasticRow to = restricted(y);
  rows_->restrict_along(coarse.sites.width, padded.x, to.x);
  rows_->restrict_along(coarse.sites.width, padded.y, to.y);
  if (y % 2 != 0 && y / 2 >= band.first) { // row 2 Y + 1 completes coarse row Y
    write_coarse(y / 2, coarse, load);
  }
}

void ElasticBand::end_restriction(const ElasticLevel& fine, Band band, const RingedGrid& coarse,
                                  RingedField& load) {
  const int height = fine.grid.sites.height;
  for (int y = height / 2; y < band.last; ++y) { // those whose row 2 Y + 1 is not there
    clear(restricted(2 * y + 1));
    if (2 * y >= height) {
      clear(restricted(2 * y));
    }
    write_coarse(y, coarse, load);
  }
}

void ElasticBand::write_coarse(int y, const RingedGrid& coarse, RingedField& load) {
  const ElasticRow to = row_of(coarse, load, y);
  const ElasticRow before = restricted(2 * y - 1);
  const ElasticRow at = restricted(2 * y);
  const ElasticRow after = restricted(2 * y + 1);
  rows_->restrict_across(coarse.sites.width, before.x, at.x, after.x, to.x);
  rows_->restrict_across(coarse.sites.width, before.y, at.y, after.y, to.y);
}

} // namespace hdmbench::openmp
