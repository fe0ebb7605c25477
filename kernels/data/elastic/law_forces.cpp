#include "kernels/data/elastic/law_forces.hpp"

#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/elastic/law.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <vector>

namespace hdmbench {

/// The part of the sites that a thread has: all whose coordinate along the last axis is in [begin, end).
class LawForces::Part {
public:
  Part(const LawForces& laws, const VectorField& displacement, VectorField& force)
      : laws_(laws), level_(laws.level_), displacement_(displacement), force_(force),
        cells_(static_cast<std::size_t>(level_.extent.width) - 1), forces_(24 * cells_), volumes_(cells_),
        none_(cells_ + 1, 0.0F), linear_(cells_ + 1, -1.0F) {}

  LeastVolume run(int begin, int end) {
    const Extent extent = level_.extent;
    if (extent.axes() == 2) {
      for (int y = std::max(begin - 1, 0); y < std::min(end, extent.height - 1); ++y) {
        add_row(y, 0, begin, end);
      }
      return least_;
    }
    for (int z = std::max(begin - 1, 0); z < std::min(end, extent.depth - 1); ++z) {
      for (int y = 0; y + 1 < extent.height; ++y) {
        add_row(y, z, begin, end);
      }
    }
    return least_;
  }

private:
  void add_row(int y, int z, int begin, int end) {
    const Cells cells = laws_.rows_[static_cast<std::size_t>(z * level_.extent.height + y)];
    if (cells.begin == cells.end) {
      return;
    }
    const bool is_volume = level_.extent.axes() == 3;
    const CellRows rows = laws_.rows_at(y, z, displacement_, none_.data(), linear_.data());
    const auto make = has_fibres(level_) ? laws_.law_.make_cells_with_fibres : laws_.law_.make_cells;
    make(laws_.constants_, rows, {forces_.data(), volumes_.data(), cells_},
         static_cast<std::size_t>(cells.begin), static_cast<std::size_t>(cells.end));
    for (std::size_t row = 0; row < 4; ++row) {
      const int of_last_axis = is_volume ? z + static_cast<int>(row >> 1) : y + static_cast<int>(row & 1);
      if (of_last_axis >= begin && of_last_axis < end) {
        add_to_sites(cells, row, laws_.corner_row(y, z, row));
      }
    }
    for (int i = cells.begin; i < cells.end; ++i) {
      const auto share = static_cast<double>(volumes_[static_cast<std::size_t>(i)]);
      if (!(share >= least_.share)) {
        least_ = {.share = share, .site = laws_.corner_row(y, z, 0) + static_cast<std::size_t>(i)};
      }
    }
  }

  /// Adds what the cells do to one of their rows of sites.
  void add_to_sites(Cells cells, std::size_t row, std::size_t at) {
    for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
      float* const to = force_[axis].data() + at;
      const float* const left = forces_.data() + (8 * axis + 2 * row) * cells_;
      const float* const right = left + cells_;
#pragma omp simd
      for (int i = cells.begin; i < cells.end; ++i) {
        to[i] += left[i];
      }
#pragma omp simd
      for (int i = cells.begin; i < cells.end; ++i) {
        to[i + 1] += right[i];
      }
    }
  }

  const LawForces& laws_;
  const Level& level_;
  const VectorField& displacement_;
  VectorField& force_;
  std::size_t cells_;
  std::vector<float> forces_;
  std::vector<float> volumes_;
  std::vector<float> none_;   ///< the displacement of an image along z
  std::vector<float> linear_; ///< the parameter of a level without laws
  LeastVolume least_{};
};

const Law& law_of(const Level& level) {
  return level.law != nullptr ? *level.law : laws::neo_hookean::law;
}

LawForces::LawForces(const Level& level, const ElasticModel& model) : level_(level), law_(law_of(level)) {
  const bool is_volume = level.extent.axes() == 3;
  // For Young's modulus 1; and the energy is by coefficients of slopes, eight times those of unit cells.
  const double unit = force_unit(level, model.poisson) / 32.0;
  const double nu = model.poisson;
  const double lame = is_volume ? nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) : nu / (1.0 - nu * nu);
  const bool has_walls = has_laws(level) && level.has_walls;
  constants_ = {.mu = static_cast<float>(unit / (2.0 * (1.0 + nu))),
                .lame = static_cast<float>(unit * lame),
                .half_modulus = static_cast<float>(0.5 * unit),
                .least_modulus = has_walls ? void_modulus(level) : 0.0F};
  std::ranges::transform(level.sides, constants_.one_over_sides.begin(),
                         [](double side) { return static_cast<float>(1.0 / side); });
  const Extent extent = level.extent;
  rows_.resize(static_cast<std::size_t>(extent.rows()));
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    const int y = row % extent.height;
    const int z = row / extent.height;
    if (y + 1 == extent.height || (is_volume && z + 1 == extent.depth)) {
      continue; // no cells begin here
    }
    const auto is_free = [&](int x) {
      for (int corner = 0; corner < (is_volume ? 4 : 2); ++corner) {
        const std::size_t site = extent.index(x, y + (corner & 1), z + (corner >> 1));
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          if (level.confidence[axis][site] < 1.0F) {
            return true;
          }
        }
      }
      return false;
    };
    int first = 0;
    while (first < extent.width && !is_free(first)) {
      ++first;
    }
    int last = extent.width - 1;
    while (last > first && !is_free(last)) {
      --last;
    }
    if (first < extent.width) {
      rows_[static_cast<std::size_t>(row)] = {.begin = std::max(first - 1, 0),
                                              .end = std::min(last + 1, extent.width - 1)};
    }
  }
}

LeastVolume LawForces::operator()(const VectorField& displacement, VectorField& force) const {
  const Extent extent = level_.extent;
  const int sites = extent.axes() == 3 ? extent.depth : extent.height; // along the last axis
  const int parts = extent.sites() > sites_worth_threads ? std::clamp(omp_get_max_threads(), 1, sites) : 1;
  std::vector<LeastVolume> least(static_cast<std::size_t>(parts));
  resize(force, extent);
#pragma omp parallel for schedule(static, 1) if (parts > 1)
  for (int part = 0; part < parts; ++part) {
    const int begin = static_cast<int>(std::int64_t{sites} * part / parts);
    const int end = static_cast<int>(std::int64_t{sites} * (part + 1) / parts);
    const std::size_t layer = extent.sites() / static_cast<std::size_t>(sites);
    const std::size_t first = layer * static_cast<std::size_t>(begin);
    const std::size_t last = layer * static_cast<std::size_t>(end);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      std::fill(force[axis].data() + first, force[axis].data() + last, 0.0F);
    }
    least[static_cast<std::size_t>(part)] = Part(*this, displacement, force).run(begin, end);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      for (std::size_t site = first; site < last; ++site) {
        force[axis][site] = level_.confidence[axis][site] >= 1.0F ? 0.0F : force[axis][site];
      }
    }
  }
  return *std::ranges::min_element(least, {}, &LeastVolume::share);
}

std::size_t LawForces::corner_row(int y, int z, std::size_t row) const {
  const bool is_volume = level_.extent.axes() == 3;
  return level_.extent.index(0, y + static_cast<int>(row & 1),
                             is_volume ? z + static_cast<int>(row >> 1) : 0);
}

CellRows LawForces::rows_at(int y, int z, const VectorField& displacement, const float* none,
                            const float* linear) const {
  CellRows rows;
  for (std::size_t row = 0; row < 4; ++row) {
    const std::size_t at = corner_row(y, z, row);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rows.displacement[axis][row] = axis < level_.extent.axes() ? displacement[axis].data() + at : none;
    }
    rows.modulus[row] = level_.modulus.values.data() + at;
    rows.parameter[row] = has_laws(level_) ? level_.law_parameter.values.data() + at : linear;
    if (has_fibres(level_)) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rows.fibre[axis][row] = axis < level_.extent.axes() ? level_.fibre[axis].data() + at : none;
      }
      rows.compression[row] = level_.fibre_compression.values.data() + at;
    }
  }
  return rows;
}

ScalarField LawForces::stiffness_ratio(const VectorField& displacement) const {
  const Extent extent = level_.extent;
  const auto width = static_cast<std::size_t>(extent.width);
  const std::vector<float> none(width, 0.0F);
  const std::vector<float> linear(width, -1.0F);
  const float z = extent.axes() == 3 ? 1.0F : 0.0F;
  ScalarField of_cells(extent, 0.0F); // where none is, as in void
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    const Cells cells = rows_[static_cast<std::size_t>(row)];
    if (cells.begin < cells.end) {
      law_.set_ratios(
          constants_,
          rows_at(row % extent.height, row / extent.height, displacement, none.data(), linear.data()), z,
          static_cast<std::size_t>(cells.begin), static_cast<std::size_t>(cells.end),
          of_cells.values.data() + extent.index(0, row));
    }
  }
  ScalarField ratio(extent);
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    const int y = row % extent.height;
    const int first_y = std::max(y - 1, 0);
    const int first_z = std::max(row / extent.height - 1, 0);
    for (int x = 0; x < extent.width; ++x) {
      float stiffest = 0.0F;
      for (int k = first_z; k <= row / extent.height; ++k) {
        for (int j = first_y; j <= y; ++j) {
          for (int i = std::max(x - 1, 0); i <= x; ++i) {
            stiffest = std::max(stiffest, of_cells.values[extent.index(i, j, k)]);
          }
        }
      }
      const std::size_t site = extent.index(x, row);
      const bool is_linear = !has_laws(level_) || level_.law_parameter.values[site] < 0.0F;
      ratio.values[site] = is_linear || stiffest == 0.0F ? 1.0F : stiffest;
    }
  }
  return ratio;
}

} // namespace hdmbench
