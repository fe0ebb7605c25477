// The rows of cells and sites of one law: compiled once for each text (kernels/specification/laws/laws.hpp).

#include "kernels/data/elastic/law.hpp"
#include "kernels/specification/laws/laws.hpp"

namespace hdmbench::laws::HDMBENCH_LAW {

namespace {

using LawsInFloat = Laws<float>;

/// A function of its own, so that the loop over cells becomes one of vectors.
template <bool has_fibres>
HDM_FUNCTION void make_cell(const CellConstants& material, const CellRows& rows, const MadeCells& made,
                            std::size_t i) {
  const auto displacement = [&](int axis) HDM_INLINED {
    const auto& of = rows.displacement[static_cast<std::size_t>(axis)];
    return LawsInFloat::Volume::CellCorners{of[0][i], of[0][i + 1], of[1][i], of[1][i + 1],
                                            of[2][i], of[2][i + 1], of[3][i], of[3][i + 1]};
  };
  const auto value_at = [&](const std::array<const float*, 4>& of, int corner) HDM_INLINED {
    return of[static_cast<std::size_t>(corner) >> 1][i + (static_cast<std::size_t>(corner) & 1)];
  };
  const auto modulus_at = [&](int corner) HDM_INLINED { return value_at(rows.modulus, corner); };
  float softest = modulus_at(0);
  for (int corner = 1; corner < 8; ++corner) {
    const float modulus = modulus_at(corner);
    softest = modulus < softest ? modulus : softest;
  }
  const bool is_void = softest < material.least_modulus;
  const auto tissue = [&](int corner) HDM_INLINED {
    const float modulus = is_void ? softest : modulus_at(corner);
    const float parameter = value_at(rows.parameter, corner);
    return LawsInFloat::Tissue{modulus * material.mu, modulus * material.lame, is_void ? -1.0F : parameter};
  };
  const auto fibre = [&](int corner) HDM_INLINED {
    if constexpr (has_fibres) {
      const float half_modulus = is_void ? 0.0F : modulus_at(corner) * material.half_modulus;
      return LawsInFloat::Fibre{value_at(rows.fibre[0], corner), value_at(rows.fibre[1], corner),
                                value_at(rows.fibre[2], corner), half_modulus,
                                value_at(rows.compression, corner)};
    } else {
      return LawsInFloat::NoFibre{};
    }
  };
  const LawsInFloat::Sides sides{material.one_over_sides[0], material.one_over_sides[1],
                                 material.one_over_sides[2]};
  made.volumes[i] = LawsInFloat::for_each_force_by_law(
      displacement, tissue, fibre, sides, [&](int axis, int corner, float force) HDM_INLINED {
        made.forces[static_cast<std::size_t>(8 * axis + corner) * made.cells + i] = force;
      });
}

template <bool has_fibres>
HDM_WIDE_VECTORS void make_cells(const CellConstants& material, const CellRows& rows, const MadeCells& made,
                                 std::size_t begin, std::size_t end) {
#pragma omp simd
  for (std::size_t i = begin; i < end; ++i) {
    make_cell<has_fibres>(material, rows, made, i);
  }
}

/// Returns the ratio of site x, whose neighbours along the row are at `before` and `after`. A function of its
/// own, so that the loop over sites becomes one of vectors.
HDM_FUNCTION float ratio_at(const CellConstants& material, const RowsAround& around, float z, std::size_t x,
                            std::size_t before, std::size_t after, float factor) {
  const auto along_x = [&](std::size_t axis) HDM_INLINED {
    const float* const row = around.displacement[axis].row;
    return factor * (row[after] - row[before]);
  };
  const auto along = [&](std::size_t axis, std::size_t other) HDM_INLINED {
    const auto& beside = around.displacement[axis].beside;
    return around.factor[other] * (beside[2 * other - 1][x] - beside[2 * other - 2][x]);
  };
  const LawsInFloat::Gradient gradient{along_x(0),  along(0, 1), along(0, 2), along_x(1), along(1, 1),
                                       along(1, 2), along_x(2),  along(2, 1), along(2, 2)};
  const float ratio =
      LawsInFloat::stiffness_under({material.mu, material.lame, around.parameter[x]}, gradient, z);
  const float not_less = ratio > 0.1F ? ratio : 0.1F; // whatever it is, also no number
  return not_less < 10.0F ? not_less : 10.0F;
}

HDM_WIDE_VECTORS void set_ratios(const CellConstants& material, const RowsAround& around, float z,
                                 std::size_t width, float* to) {
  const float factor = around.factor[0];
#pragma omp simd
  for (std::size_t x = 1; x < width - 1; ++x) {
    to[x] = ratio_at(material, around, z, x, x - 1, x + 1, factor);
  }
  to[0] = ratio_at(material, around, z, 0, 0, 1, 2.0F * factor);
  to[width - 1] = ratio_at(material, around, z, width - 1, width - 2, width - 1, 2.0F * factor);
}

} // namespace

extern const Law law;
const Law law{
    .make_cells = make_cells<false>, .make_cells_with_fibres = make_cells<true>, .set_ratios = set_ratios};

} // namespace hdmbench::laws::HDMBENCH_LAW
