#pragma once

#include "backends/shared/elastic_session.hpp"
#include "kernels/shaders/elastic_steps.h"

#include <array>
#include <compare>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

/// What a step of the elastic energy is on a device: kernels on arrays, and how these lie.
namespace hdmbench {

/// Where the numbers of sites and cells lie in arrays of a device. A level lies row by row, with one 0 before
/// each row and two after it, a row of zeros above and two below, and in a volume such a plane before and two
/// behind: whatever a kernel reads around a site is there. A cell lies where its first corner does.
struct ElasticLayout {
  struct Part {
    Extent sites{};
    std::int64_t first = 0; ///< of site (0, 0, 0)
    std::int64_t pitch = 0; ///< from a row to the next
    std::int64_t layer = 0; ///< from a plane of the volume to the next
  };

  ElasticLayout() = default;
  /// All levels, one after the other; dot products by blocks of so many sites along each axis.
  ElasticLayout(const ElasticHierarchy& hierarchy, int block);

  /// Returns the place of a level that lies alone, in an array of padded(sites).
  [[nodiscard]] static Part alone(Extent sites);
  [[nodiscard]] static Extent padded(Extent sites) {
    return {sites.width + 3, sites.height + 3, sites.axes() == 3 ? sites.depth + 3 : 1};
  }

  [[nodiscard]] static Extent blocks_of(Extent sites, int block);

  /// Sites before those whose cells have moments: in a volume all of the finest level.
  [[nodiscard]] std::int64_t moments_from() const {
    const Extent sites = levels.front().sites;
    return sites.axes() == 3 ? static_cast<std::int64_t>(padded(sites).sites()) : 0;
  }

  std::vector<Part> levels;
  Part sums;                  ///< of dot products: the first of their arrays, which lies alone, without zeros
  std::int64_t size = 0;      ///< of an array for all levels
  std::int64_t sums_size = 0; ///< of one for sums
};

/// `values`, in their RingedGrid, into every `stride`-th float of `to`. The zeros around are there already.
void lay_out(const RingedGrid& grid, const std::vector<float>& values, const ElasticLayout::Part& part,
             float* to, std::size_t stride);

/// Matrices of masked cells as GLSL 1.20 has them, in a texture of this width. For each corner: its force by
/// the displacements of all, component by component. In an image two of these columns are a texel, in a
/// volume one, and something to spare; 64 cells or 16 are a row.
[[nodiscard]] std::vector<float> elastic_matrices(const ElasticHierarchy& hierarchy);
[[nodiscard]] constexpr int elastic_matrices_width(std::size_t axes) {
  return axes == 3 ? 16 * 192 : 64 * 16;
}

/// For each level where its list begins and how many sites are in it, then the lists: of a site beside masked
/// cells x, y and z as elastic_sites.h counts them, 0, and the numbers of the matrices of its cells in
/// reading order, -1 where there is none. Matrices are numbered through all levels.
[[nodiscard]] std::vector<std::int32_t> touched_sites(const ElasticHierarchy& hierarchy);

/// An array of a device: the components of the sites of a level.
struct ElasticArray {
  int level = 0;
  int slot = 0; ///< three on every level, three more on the image, and on the image two for sums

  bool operator==(const ElasticArray&) const = default;
};
constexpr int elastic_slots_on_levels = 3;
constexpr int elastic_slots = 6;
constexpr int elastic_sums = elastic_slots; ///< this and the next one: numbers, as x

/// A kernel for all sites of `to`. f is `from`, s `second`.
enum class ElasticStep {
  relax = ELASTIC_RELAX,                     ///< f after a damped Jacobi sweep; s: its load
  relax_from_zero = ELASTIC_RELAX_FROM_ZERO, ///< the same of 0; f: its load
  residual = ELASTIC_RESIDUAL,               ///< of f, where it may move; s: its load
  restrict_sites = ELASTIC_RESTRICT,         ///< f of the finer level; with `frees` where it may move
  interpolate = ELASTIC_INTERPOLATE,         ///< s of the coarser level, where it may move
  correct = ELASTIC_CORRECT,                 ///< f and that
  solve = ELASTIC_SOLVE,                     ///< the coarsest level's correction; f: its load
  advance = ELASTIC_ADVANCE,                 ///< f + factor * s
  products = ELASTIC_PRODUCTS,               ///< sums of blocks of f * s
  squares = ELASTIC_SQUARES                  ///< sums of blocks of sums
};

/// What a kernel is compiled for.
struct ElasticKernel {
  ElasticStep step = ElasticStep::relax;
  bool has_load = false; ///< relax, residual: s is there, else `second` is `from`
  /// residual, interpolate, correct, restrict_sites: components may be prescribed. Relax and residual in a
  /// volume: cells are those of eight moduli.
  bool is_image = false;
  bool has_masked = false; ///< relax, residual: the level has masked cells
  bool has_boxes = false;  ///< relax, residual: cells are no squares or cubes
  /// restrict_sites, interpolate, correct: the axes along which the coarser level's Stride is 2, x in the
  /// lowest bit; of an image the third is set.
  int halved = 7;

  auto operator<=>(const ElasticKernel&) const = default;
};

/// The parameters of one dispatch, in the order in which kernels read them. Arrays that never change within a
/// level are laid out like `from`.
struct ElasticParameters {
  /// Sites, and where they lie in an array, as ElasticLayout::Part.
  struct Place {
    std::int32_t width = 0;
    std::int32_t height = 0;
    std::int32_t depth = 0;
    std::int32_t first = 0;
    std::int32_t pitch = 0;
    std::int32_t layer = 0;
  };
  std::array<float, 3> law{};    ///< the members of Law (kernels/specification/elastic)
  std::int32_t plane = 0;        ///< floats from the plane of a component to the next
  std::int32_t moments_from = 0; ///< sites before the first level with moments, in a volume the second
  float factor = 0.0F;
  std::int32_t listed_first = 0; ///< of the level in touched_sites()
  std::int32_t listed = 0;
  Place to; ///< what is computed
  Place from;
  Place second;
  float bend = 1.0F; ///< of a volume ElasticLevel::bend of the finest level
};

/// Where sites lie in an array that has a part like this.
[[nodiscard]] inline ElasticParameters::Place place_of(const ElasticLayout::Part& part, Extent sites) {
  return {.width = sites.width,
          .height = sites.height,
          .depth = sites.depth,
          .first = static_cast<std::int32_t>(part.first),
          .pitch = static_cast<std::int32_t>(part.pitch),
          .layer = static_cast<std::int32_t>(part.layer)};
}

struct ElasticCall {
  ElasticKernel kernel;
  ElasticArray from;
  ElasticArray second;
  ElasticArray to; ///< neither of the others
  ElasticParameters parameters;
};

/// Steps on the coarsest levels in one go, by one work group. Their arrays begin with those of the level
/// `finest`.
struct ElasticTogether {
  std::array<float, 3> law{}; ///< this and what follows as ElasticParameters
  std::int32_t plane = 0;
  std::int32_t moments_from = 0;
  std::int32_t base = 0; ///< where they begin in those of all levels
  std::int32_t size = 0;
  std::int32_t finest = 0;
  std::int32_t width = 0; ///< of the finest
  std::int32_t height = 0;
  std::int32_t depth = 0;
  std::int32_t steps = 0;
  /// From the lowest bit: 4 of the step, 2 for each of from, second and to, the rest the level of `from`
  /// counted from the finest.
  std::array<std::int32_t, ELASTIC_TOGETHER_STEPS> codes{};
};

/// ElasticTogether only where a device has a coarse_size().
using ElasticWork = std::variant<ElasticCall, ElasticTogether>;

} // namespace hdmbench
