#include "kernels/data/elastic/cell_moments.hpp"

#include "kernels/data/elastic/moments_row.hpp"
#include "kernels/data/sites_worth_threads.hpp"

namespace hdmbench {

namespace {

using InFloat = ElasticInFloat;

// Bodies of loops are functions of their own: locals declared inside an `omp simd` loop would become arrays
// in memory.

HDM_FUNCTION void set_image_cell(const MomentsRow<float>& row, const float* top, const float* bottom, int x) {
  row.set(x, InFloat::image_cell({top[x], top[x + 1], bottom[x], bottom[x + 1]}));
}

HDM_FUNCTION void set_parent(const MomentsRow<float>& row, const MomentsRow<const float>& top,
                             const MomentsRow<const float>& bottom, int x) {
  InFloat::CellMoments sum{0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
  sum = InFloat::with_child(sum, top.cell(2 * x), -1.0F, -1.0F);
  sum = InFloat::with_child(sum, top.cell(2 * x + 1), 1.0F, -1.0F);
  sum = InFloat::with_child(sum, bottom.cell(2 * x), -1.0F, 1.0F);
  sum = InFloat::with_child(sum, bottom.cell(2 * x + 1), 1.0F, 1.0F);
  row.set(x, sum);
}

} // namespace

void set_image_moments(ElasticLevel& image, const Level& full) {
  const Extent cells = image.grid.cells();
#pragma omp parallel for if (full.extent.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    const MomentsRow<float> row(image, y);
    const float* const top = full.modulus.values.data() + full.extent.index(0, y);
    const float* const bottom = top + full.extent.width;
#pragma omp simd
    for (int x = 0; x < cells.width; ++x) {
      set_image_cell(row, top, bottom, x);
    }
  }
}

void set_parent_moments(ElasticLevel& level, const ElasticLevel& fine) {
  const Extent cells = level.grid.cells();
#pragma omp parallel for if (level.grid.sites.sites() > sites_worth_threads)
  for (int y = 0; y < cells.height; ++y) {
    const MomentsRow<float> row(level, y);
    const MomentsRow<const float> top(fine, 2 * y);
    const MomentsRow<const float> bottom(fine, 2 * y + 1);
#pragma omp simd
    for (int x = 0; x < cells.width; ++x) {
      set_parent(row, top, bottom, x);
    }
  }
}

} // namespace hdmbench
