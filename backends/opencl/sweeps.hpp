#pragma once

#include "backends/opencl/fields.hpp"
#include "backends/opencl/programs.hpp"
#include "backends/shared/input_texels.hpp"

#include <array>
#include <cstddef>

namespace hdmbench::opencl {

/// The two displacements of a session, x and y each: sweeps read one and write the other.
struct Displacements {
  [[nodiscard]] const Buffer& field() const { return buffers[newest]; }
  /// One sweep before, or what is to be written.
  [[nodiscard]] const Buffer& other() const { return buffers[1 - newest]; }
  void swap() { newest = 1 - newest; }

  std::array<Buffer, 2> buffers;
  std::size_t newest = 0;
};

/// The sweeps of one level: its tiles, their flags, the energy's inputs, and the kernel for its rule. All
/// calls throw DeviceError.
class Sweeps {
public:
  /// Of a level that samples `full`, which may be the level itself; with the `strengths` of its own.
  /// `first_input` is where its inputs begin. Compiles what is missing in `kernels`, which must outlive this,
  /// as `queue`.
  Sweeps(const Queue& queue, Kernels& kernels, const Shape& shape, const Level& full, Extent extent,
         Alignment alignment, std::vector<float> strengths, Work work, const InputTexels& inputs,
         std::size_t first_input);

  [[nodiscard]] Extent extent() const { return level_.extent; }
  [[nodiscard]] const Layout& layout() const { return layout_; }
  /// All tiles are to be visited in the next sweep.
  void wake_all() { every_ = true; }
  /// Sweeps first ... first + count - 1, not waited for: a fraction of a second's work or two at most, fewer
  /// sweeps where that is less. Returns how many.
  int run(int first, int count, const Fields& fields, Displacements& displacements);

private:
  void sweep(int first, int together, Displacements& displacements);
  /// Whether one group may do several sweeps: what it is told must be the same in all of them.
  [[nodiscard]] bool by_one_group() const;

  const Queue* queue_;
  const Kernel* kernel_;
  std::size_t lanes_;
  Level level_; ///< without its fields
  Layout layout_;
  Extent tiles_; ///< how many
  bool active_;
  Buffer inputs_;
  Buffer classes_;    ///< of the tiles; one byte where all are general
  Buffer flags_;      ///< of the tiles, as sweep.cl has them
  cl_uint stamp_ = 0; ///< of the sweep before
  bool every_ = true; ///< the next sweep visits every tile
};

} // namespace hdmbench::opencl
