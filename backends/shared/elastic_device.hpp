#pragma once

#include "backends/shared/elastic_session.hpp"
#include "kernels/shaders/elastic_steps.h"

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

/// What sessions of the elastic energy on devices have in common: which kernels a step takes, on which
/// arrays, and how these lie.
namespace hdmbench {

/// Where the numbers of sites and cells lie in arrays of a device. A level lies row by row, with one 0 before
/// each row and two after it, a row of zeros above and two below: whatever a kernel reads around a site is
/// there. Cell (x, y) lies where site (x, y) does, its top left corner.
struct ElasticLayout {
  struct Part {
    Extent sites{};
    std::int64_t first = 0; ///< of site (0, 0)
    std::int64_t pitch = 0; ///< from a row to the next
  };

  ElasticLayout() = default;
  /// All levels, one after the other; dot products by blocks of so many sites a side.
  ElasticLayout(const ElasticHierarchy& hierarchy, int block);

  /// Of a level that lies alone, in an array of padded(sites).
  [[nodiscard]] static Part alone(Extent sites);
  [[nodiscard]] static Extent padded(Extent sites) { return {sites.width + 3, sites.height + 3}; }

  std::vector<Part> levels;
  Part sums;                  ///< of dot products: the first of their arrays, which lies alone, without zeros
  std::int64_t size = 0;      ///< of an array for all levels
  std::int64_t sums_size = 0; ///< of one for sums
};

/// `values`, in their RingedGrid, into every `stride`-th float of `to`. The zeros around are there already.
void lay_out(const RingedGrid& grid, const std::vector<float>& values, const ElasticLayout::Part& part,
             float* to, std::size_t stride);

/// What does not change of levels, as GLSL has it: texels of arrays in this layout.
struct ElasticTexels {
  /// All 0.
  explicit ElasticTexels(std::size_t size);
  /// Levels in their order.
  void add(const ElasticLevel& level, const ElasticLayout::Part& part);

  std::vector<float> moments; ///< 4: m, mr, ms, mrr of a cell
  std::vector<float>
      more; ///< 4: mss, mrs; of a masked cell 1 + the number of its matrix, else 0; one to spare
  std::vector<float> response; ///< 4: xx, xy, yy of a site, one to spare
  std::size_t matrices = 0;    ///< of the levels added
};

/// Matrices of masked cells as GLSL has them, sixteen texels of four; filled up to rows of
/// elastic_matrices_across. For each corner four texels: force x and y by the displacement x of a corner, the
/// same two by its y.
[[nodiscard]] std::vector<float> elastic_matrices(const ElasticHierarchy& hierarchy);
constexpr std::size_t elastic_matrices_across = 64;
constexpr std::size_t elastic_matrix_texels = 16;

/// The sites beside masked cells, texels of two floats: x and y of each, level by level. Before them, for
/// each level, where its sites begin and how many they are.
struct ElasticTouched {
  ElasticTouched() = default;
  explicit ElasticTouched(const ElasticHierarchy& hierarchy);

  [[nodiscard]] std::int32_t first(int level) const { return number(level, 0); }
  [[nodiscard]] std::int32_t count(int level) const { return number(level, 1); }

  std::vector<float> texels;

private:
  [[nodiscard]] std::int32_t number(int level, std::size_t component) const {
    return static_cast<std::int32_t>(texels.at(2 * static_cast<std::size_t>(level) + component));
  }
};

/// An array of a device: x and y of the sites of a level.
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

/// How a kernel finds masked cells, of relax and residual.
enum class ElasticMasks {
  none,    ///< there are none, or what it says of the sites beside them is replaced
  anyhow,  ///< by itself
  by_list, ///< it is for the sites beside them only
};

/// What a kernel is compiled for.
struct ElasticKernel {
  ElasticStep step = ElasticStep::relax;
  bool has_load = false; ///< relax, residual: s is there, else `second` is `from`
  bool is_image = false; ///< residual, interpolate, correct, restrict_sites: components may be prescribed
  ElasticMasks masks = ElasticMasks::none;

  auto operator<=>(const ElasticKernel&) const = default;
};

/// As kernels have them; first and pitch as ElasticLayout::Part. What does not change of a level lies as
/// `from`.
struct ElasticParameters {
  std::int32_t width = 0; ///< of `to`: what is computed
  std::int32_t height = 0;
  std::int32_t first = 0;
  std::int32_t pitch = 0;
  std::int32_t from_first = 0;
  std::int32_t from_pitch = 0;
  std::int32_t from_width = 0;
  std::int32_t from_height = 0;
  std::int32_t second_first = 0;
  std::int32_t second_pitch = 0;
  std::int32_t listed_first = 0; ///< ElasticTouched of the level
  std::int32_t listed = 0;
  float nu = 0.0F;
  float shear = 0.0F;
  float factor = 0.0F;
};

struct ElasticCall {
  ElasticKernel kernel;
  ElasticArray from;
  ElasticArray second;
  ElasticArray to; ///< neither of the others
  ElasticParameters parameters;
};

/// Steps on the coarsest levels in one go, as elastic_coarse.comp has them. Their arrays begin with those of
/// the level `finest`.
struct ElasticCoarse {
  std::int32_t base = 0; ///< where they begin in those of all levels
  std::int32_t size = 0;
  std::int32_t finest = 0;
  std::int32_t width = 0; ///< of the finest
  std::int32_t height = 0;
  std::int32_t steps = 0;
  float nu = 0.0F;
  float shear = 0.0F;
  /// From the lowest bit: 4 of the step, 2 for each of from, second and to, the rest the level of `from`
  /// counted from the finest.
  std::array<std::int32_t, ELASTIC_COARSE_STEPS> codes{};
};

/// ElasticCoarse only where a device has a coarse_size().
using ElasticWork = std::variant<ElasticCall, ElasticCoarse>;

/// How the sites of a level are shared out in elastic.comp.
struct ElasticShape {
  int lanes; ///< invocations of a group
  int rows;  ///< sites of an invocation, one below the other
};

/// A rasterizer on the CPU has one thread a group and pays for each of them; a GPU wants many.
[[nodiscard]] constexpr ElasticShape elastic_shape(bool is_software) {
  return is_software ? ElasticShape{.lanes = 16, .rows = 16} : ElasticShape{.lanes = 64, .rows = 4};
}
[[nodiscard]] constexpr ElasticShape elastic_coarse_shape(bool is_software) {
  return is_software ? ElasticShape{.lanes = 8, .rows = 10} : ElasticShape{.lanes = 256, .rows = 1};
}
/// Whether elastic_coarse.comp has its fields in shared memory.
[[nodiscard]] constexpr bool elastic_in_shared(bool is_software) {
  return !is_software;
}
[[nodiscard]] constexpr std::int64_t elastic_coarse_size(bool is_software) {
  return elastic_in_shared(is_software) ? ELASTIC_SHARED_SITES : ELASTIC_COARSE_SITES;
}

/// A device with its arrays. Throws DeviceError.
class ElasticDevice {
public:
  ElasticDevice() = default;
  ElasticDevice(const ElasticDevice&) = delete;
  ElasticDevice& operator=(const ElasticDevice&) = delete;
  virtual ~ElasticDevice() = default;

  /// Sites a side of the blocks that one kernel sums up: 8 are three levels of the tree of 2 x 2 squares.
  [[nodiscard]] virtual int block() const { return 8; }

  /// Whether it has kernels for sites by list: then it gets such calls, else ElasticMasks::anyhow.
  [[nodiscard]] virtual bool has_lists() const { return false; }
  /// How long the arrays of levels may be that an ElasticCoarse has; 0: it takes none.
  [[nodiscard]] virtual std::int64_t coarse_size() const { return 0; }

  /// Makes the arrays, all 0, and uploads what does not change. Throws TooLarge.
  virtual void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) = 0;
  virtual void write(ElasticArray to, const VectorField& values) = 0;
  /// After everything that was run.
  virtual void read(ElasticArray from, VectorField& values) = 0;
  [[nodiscard]] virtual float read_sum(ElasticArray from) = 0;
  /// In their order. Need not wait until it is done.
  virtual void run(std::span<const ElasticWork> work) = 0;
};

/// A session that computes there. `name`: of the backend, for errors.
[[nodiscard]] std::unique_ptr<ElasticSession> make_elastic_session(std::string name,
                                                                   std::unique_ptr<ElasticDevice> device);

/// Work groups of elastic.comp for a call.
[[nodiscard]] Extent elastic_groups(const ElasticCall& call, const ElasticShape& shape);

/// "#define STEP 3" and so on, a line each: what kernels that are compiled at run time want to know.
[[nodiscard]] std::string elastic_definitions(const ElasticKernel& kernel);

} // namespace hdmbench
