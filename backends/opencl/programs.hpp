#pragma once

#include "backends/opencl/device.hpp"
#include "backends/shared/shader_constants.hpp"
#include "backends/shared/tiles.hpp"

#include <array>
#include <compare>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench::opencl {

/// What all kernels are built with. Numbers without a suffix are floats; nothing is flushed or fused; -w
/// because some drivers print warnings, whether asked or not.
inline constexpr const char* build_options = "-cl-std=CL1.2 -cl-single-precision-constant -w";

/// How a group sweeps a tile (kernels/shaders/sweep.cl).
struct Shape {
  Extent tile;    ///< sites
  int lanes;      ///< work items
  int simd_width; ///< of the loop along a row where there is one item: a hint to the compiler

  auto operator<=>(const Shape&) const = default;
};

/// By SessionOptions::shape; the first is taken where nothing is measured. A CPU has one item a group, whose
/// loop along a row is made SIMD; other devices have one for each column.
[[nodiscard]] std::span<const Shape> shapes_for(const FoundDevice& device);
/// For any device.
[[nodiscard]] std::vector<Shape> all_shapes();
/// For Backend::do_shapes().
[[nodiscard]] Variants shape_variants(const FoundDevice& device);

/// What sweep.cl is compiled for.
struct SweepKind {
  ShaderConstants constants{};
  Shape shape{};
  bool active = false;  ///< visits only tiles that can see a change
  bool general = false; ///< all tiles are of the general class

  auto operator<=>(const SweepKind&) const = default;
};

/// Classes beside the general one that sweep.cl has in a kernel that is not general.
inline constexpr std::size_t classes_with_code = class_set({0, 1, 2, 3});

/// Parameters of sweep.cl.
struct SweepParameters {
  std::array<cl_float, 16> steps{};
  cl_float penalty = 0;
  cl_float colour = 0;
  cl_float strength = 0;
  cl_float number = 0;
  cl_float seed = 0;
  cl_int width = 0;
  cl_int height = 0;
  cl_uint origin = 0;
  cl_uint plane = 0;
  cl_int tiles_across = 0;
  cl_int tile_count = 0;
  cl_int sweeps = 1;
  cl_int every = 1;
  cl_uint stamp = 0;
};

/// Of resample.cl.
struct ResamplingParameters {
  cl_int width = 0;
  cl_uint origin = 0;
  cl_uint plane = 0;
  cl_int from_width = 0;
  cl_uint from_origin = 0;
  cl_uint from_plane = 0;
  cl_int first_column = 0;
  cl_int first_row = 0;
};

/// sweep.cl as the device's compiler wants it.
[[nodiscard]] std::string assemble(const SweepKind& kind);

/// The kernels of a session, compiled when they are first asked for.
class Kernels {
public:
  /// `queue` must outlive this.
  explicit Kernels(const Queue& queue) : queue_(&queue) {}

  [[nodiscard]] const Kernel& sweep(const SweepKind& kind);
  [[nodiscard]] const Kernel& count();  ///< of kernels/shaders/count.cl
  [[nodiscard]] const Kernel& sample(); ///< of kernels/shaders/resample.cl, as the next
  [[nodiscard]] const Kernel& project();

private:
  const Kernel& made(std::optional<Kernel>& kernel, const std::string& text, const char* name) const;

  const Queue* queue_;
  std::optional<Kernel> count_;
  std::optional<Kernel> sample_;
  std::optional<Kernel> project_;
  std::map<SweepKind, Kernel> sweeps_;
};

} // namespace hdmbench::opencl
