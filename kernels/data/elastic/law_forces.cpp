#include "kernels/data/elastic/law_forces.hpp"

#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/specification/laws/laws.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <vector>

namespace hdmbench {

namespace {

using LawsInFloat = Laws<float>;

/// What every cell has in common.
struct Constants {
  float mu = 0.0F;   ///< Lame's constants for a modulus of 1, in the unit of sessions
  float lame = 0.0F;
  LawsInFloat::Sides sides{};
};

Constants constants_of(const Level& level, double poisson) {
  const bool is_volume = level.extent.axes() == 3;
  // For Young's modulus 1; and the energy is by coefficients of slopes, eight times those of unit cells.
  const double unit = force_unit(level, poisson) / 32.0;
  const double lame =
      is_volume ? poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)) : poisson / (1.0 - poisson * poisson);
  const auto one_over = [&](std::size_t axis) { return static_cast<float>(1.0 / level.sides[axis]); };
  return {.mu = static_cast<float>(unit / (2.0 * (1.0 + poisson))),
          .lame = static_cast<float>(unit * lame),
          .sides = {one_over(0), one_over(1), one_over(2)}};
}

/// The four rows of sites that a row of cells lies between: y in the lowest bit, then z, which an image has
/// not.
struct Rows {
  std::array<std::array<const float*, 4>, 3> displacement{};
  std::array<const float*, 4> modulus{};
  std::array<const float*, 4> stiffening{};
};

/// What cells do, one array after the other, each as long as a row of them: 24 forces, the volume.
struct Made {
  float* forces = nullptr;
  float* volumes = nullptr;
  std::size_t cells = 0;
};

/// A function of its own, so that the loop over cells becomes one of vectors.
HDM_FUNCTION void make_cell(const Constants& constants, const Rows& rows, const Made& made, std::size_t i) {
  const auto displacement = [&](int axis) HDM_INLINED {
    const auto& of = rows.displacement[static_cast<std::size_t>(axis)];
    return LawsInFloat::CellCorners{of[0][i], of[0][i + 1], of[1][i], of[1][i + 1],
                                    of[2][i], of[2][i + 1], of[3][i], of[3][i + 1]};
  };
  const auto tissue = [&](int corner) HDM_INLINED {
    const auto row = static_cast<std::size_t>(corner) >> 1;
    const std::size_t at = i + (static_cast<std::size_t>(corner) & 1);
    const float modulus = rows.modulus[row][at];
    return LawsInFloat::Tissue{modulus * constants.mu, modulus * constants.lame, rows.stiffening[row][at]};
  };
  made.volumes[i] = LawsInFloat::for_each_force_by_law(
      displacement, tissue, constants.sides, [&](int axis, int corner, float force) HDM_INLINED {
        made.forces[static_cast<std::size_t>(8 * axis + corner) * made.cells + i] = force;
      });
}

HDM_WIDE_VECTORS void make_cells(const Constants& constants, const Rows& rows, const Made& made) {
#pragma omp simd
  for (std::size_t i = 0; i < made.cells; ++i) {
    make_cell(constants, rows, made, i);
  }
}

/// The part of the sites that a thread has: all whose coordinate along the last axis is in [begin, end).
class Part {
public:
  Part(const Level& level, const Constants& constants, const VectorField& displacement, VectorField& force)
      : level_(level), constants_(constants), displacement_(displacement), force_(force),
        cells_(static_cast<std::size_t>(level.extent.width) - 1), forces_(24 * cells_), volumes_(cells_),
        none_(static_cast<std::size_t>(level.extent.width), 0.0F),
        linear_(static_cast<std::size_t>(level.extent.width), -1.0F) {}

  LeastVolume run(int begin, int end) {
    const Extent extent = level_.extent;
    const bool is_volume = extent.axes() == 3;
    const int last = is_volume ? extent.depth - 1 : 1;
    for (int z = is_volume ? std::max(begin - 1, 0) : 0; z < (is_volume ? std::min(end, last) : 1); ++z) {
      const int first_row = is_volume ? 0 : std::max(begin - 1, 0);
      for (int y = first_row; y < (is_volume ? extent.height - 1 : std::min(end, extent.height - 1)); ++y) {
        add_row(y, z, begin, end);
      }
    }
    return least_;
  }

private:
  void add_row(int y, int z, int begin, int end) {
    const Extent extent = level_.extent;
    const bool is_volume = extent.axes() == 3;
    Rows rows;
    std::array<std::size_t, 4> at{};
    for (std::size_t row = 0; row < 4; ++row) {
      const int dz = is_volume ? static_cast<int>(row >> 1) : 0;
      at[row] = extent.index(0, y + static_cast<int>(row & 1), z + dz);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rows.displacement[axis][row] =
            axis < extent.axes() ? displacement_[axis].data() + at[row] : none_.data();
      }
      rows.modulus[row] = level_.modulus.values.data() + at[row];
      rows.stiffening[row] = has_laws(level_) ? level_.stiffening.values.data() + at[row] : linear_.data();
    }
    make_cells(constants_, rows, {forces_.data(), volumes_.data(), cells_});
    for (std::size_t row = 0; row < 4; ++row) {
      const int of_last_axis = is_volume ? z + static_cast<int>(row >> 1) : y + static_cast<int>(row & 1);
      if (of_last_axis >= begin && of_last_axis < end) {
        add_to_sites(row, at[row]);
      }
    }
    note_least(at);
  }

  /// Adds what the cells do to one of their rows of sites.
  void add_to_sites(std::size_t row, std::size_t at) {
    for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
      float* const to = force_[axis].data() + at;
      const float* const left = forces_.data() + (8 * axis + 2 * row) * cells_;
      const float* const right = left + cells_;
#pragma omp simd
      for (std::size_t i = 0; i < cells_; ++i) {
        to[i] += left[i];
      }
#pragma omp simd
      for (std::size_t i = 0; i < cells_; ++i) {
        to[i + 1] += right[i];
      }
    }
  }

  void note_least(const std::array<std::size_t, 4>& at) {
    const auto is_free = [&](std::size_t i) {
      return std::ranges::any_of(at, [&](std::size_t row) {
        float least = 1.0F; // confidence of a component
        for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
          const float* const confidence = level_.confidence[axis].data() + row + i;
          least = std::min({least, confidence[0], confidence[1]});
        }
        return least < 1.0F;
      });
    };
    for (std::size_t i = 0; i < cells_; ++i) {
      if (!(double{volumes_[i]} >= least_.share) && is_free(i)) {
        least_ = {.share = double{volumes_[i]}, .site = at[0] + i};
      }
    }
  }

  const Level& level_;
  Constants constants_;
  const VectorField& displacement_;
  VectorField& force_;
  std::size_t cells_;
  std::vector<float> forces_;
  std::vector<float> volumes_;
  std::vector<float> none_;   ///< the displacement of an image along z
  std::vector<float> linear_; ///< the stiffening of a level without laws
  LeastVolume least_{};
};

} // namespace

LeastVolume law_forces(const Level& level, const ElasticModel& model, const VectorField& displacement,
                       VectorField& force) {
  const Extent extent = level.extent;
  const Constants constants = constants_of(level, model.poisson);
  const int sites = extent.axes() == 3 ? extent.depth : extent.height; // along the last axis
  const int parts = extent.sites() > sites_worth_threads ? std::clamp(omp_get_max_threads(), 1, sites) : 1;
  std::vector<LeastVolume> least(static_cast<std::size_t>(parts));
  if (force.extent != extent) {
    force = VectorField(extent);
  }
#pragma omp parallel for schedule(static, 1) if (parts > 1)
  for (int part = 0; part < parts; ++part) {
    const int begin = static_cast<int>(std::int64_t{sites} * part / parts);
    const int end = static_cast<int>(std::int64_t{sites} * (part + 1) / parts);
    const std::size_t first = extent.axes() == 3 ? extent.index(0, 0, begin) : extent.index(0, begin);
    const std::size_t count = extent.sites() / static_cast<std::size_t>(sites) * static_cast<std::size_t>(end - begin);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      std::fill_n(force[axis].begin() + static_cast<std::ptrdiff_t>(first), count, 0.0F);
    }
    least[static_cast<std::size_t>(part)] = Part(level, constants, displacement, force).run(begin, end);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      for (std::size_t site = first; site < first + count; ++site) {
        force[axis][site] = level.confidence[axis][site] >= 1.0F ? 0.0F : force[axis][site];
      }
    }
  }
  return *std::ranges::min_element(least, {}, &LeastVolume::share);
}

} // namespace hdmbench
