// The rows of cells and sites of one law: compiled once for each text (kernels/specification/laws/laws.hpp).

#include "kernels/data/elastic/law.hpp"
#include "kernels/specification/laws/laws.hpp"

#include <law_text.hpp>

namespace hdmbench::laws::HDMBENCH_LAW {

namespace {

#ifdef HDMBENCH_WITH_VULKAN
#include <shaders/laws_images.hpp>
#include <shaders/laws_volumes.hpp>
#else
constexpr std::span<const std::uint32_t> laws_images;
constexpr std::span<const std::uint32_t> laws_volumes;
#endif

using LawsInFloat = Laws<float>;

HDM_FUNCTION LawsInFloat::Volume::CellCorners displacement_of(const CellRows& rows, std::size_t axis,
                                                              std::size_t i) {
  const auto& of = rows.displacement[axis];
  return {of[0][i], of[0][i + 1], of[1][i], of[1][i + 1], of[2][i], of[2][i + 1], of[3][i], of[3][i + 1]};
}

HDM_FUNCTION float value_at(const std::array<const float*, 4>& of, int corner, std::size_t i) {
  return of[static_cast<std::size_t>(corner) >> 1][i + (static_cast<std::size_t>(corner) & 1)];
}

HDM_FUNCTION float softest_of(const CellRows& rows, std::size_t i) {
  float softest = value_at(rows.modulus, 0, i);
  for (int corner = 1; corner < 8; ++corner) {
    softest = LawsInFloat::lesser(softest, value_at(rows.modulus, corner, i));
  }
  return softest;
}

/// A function of its own, so that the loop over cells becomes one of vectors.
template <bool has_fibres>
HDM_FUNCTION void make_cell(const CellConstants& material, const CellRows& rows, const MadeCells& made,
                            std::size_t i) {
  const auto displacement = [&](int axis) HDM_INLINED {
    return displacement_of(rows, static_cast<std::size_t>(axis), i);
  };
  const float softest = softest_of(rows, i);
  const LawsInFloat::Material of{material.mu, material.lame, material.half_modulus, material.least_modulus};
  const auto tissue = [&](int corner) HDM_INLINED {
    return LawsInFloat::tissue_of(of, value_at(rows.modulus, corner, i), value_at(rows.parameter, corner, i),
                                  softest);
  };
  const auto fibre = [&](int corner) HDM_INLINED {
    if constexpr (has_fibres) {
      return LawsInFloat::fibre_of(of, value_at(rows.modulus, corner, i), value_at(rows.fibre[0], corner, i),
                                   value_at(rows.fibre[1], corner, i), value_at(rows.fibre[2], corner, i),
                                   value_at(rows.compression, corner, i), softest);
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

/// A function of its own, so that the loop over cells becomes one of vectors.
HDM_FUNCTION float ratio_at(const CellConstants& material, const CellRows& rows, float z, std::size_t i) {
  LawsInFloat::Volume::Coefficients u[3]; // a slope is a quarter of one
  for (std::size_t axis = 0; axis < 3; ++axis) {
    u[axis] = LawsInFloat::Volume::coefficients_of(displacement_of(rows, axis, i));
  }
  const float x = 0.25F * material.one_over_sides[0];
  const float y = 0.25F * material.one_over_sides[1];
  const float deep = 0.25F * material.one_over_sides[2];
  float parameter = value_at(rows.parameter, 0, i);
  for (int corner = 1; corner < 8; ++corner) {
    const float other = value_at(rows.parameter, corner, i);
    parameter = other > parameter ? other : parameter;
  }
  const float ratio = LawsInFloat::stiffness_under({material.mu, material.lame, parameter},
                                                   {x * u[0].c100, y * u[0].c010, deep * u[0].c001,
                                                    x * u[1].c100, y * u[1].c010, deep * u[1].c001,
                                                    x * u[2].c100, y * u[2].c010, deep * u[2].c001},
                                                   z);
  const float not_less = ratio > 0.1F ? ratio : 0.1F; // whatever it is, also no number
  const float bounded = not_less < 10.0F ? not_less : 10.0F;
  return softest_of(rows, i) < material.least_modulus ? 0.0F : bounded;
}

HDM_WIDE_VECTORS void set_ratios(const CellConstants& material, const CellRows& rows, float z,
                                 std::size_t begin, std::size_t end, float* to) {
#pragma omp simd
  for (std::size_t i = begin; i < end; ++i) {
    to[i] = ratio_at(material, rows, z, i);
  }
}

} // namespace

extern const Law law;
const Law law{.make_cells = make_cells<false>,
              .make_cells_with_fibres = make_cells<true>,
              .set_ratios = set_ratios,
              .text = sources::law,
              .vulkan_of_images = laws_images,
              .vulkan_of_volumes = laws_volumes};

} // namespace hdmbench::laws::HDMBENCH_LAW
