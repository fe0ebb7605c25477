#pragma once

#include "backends/device/device.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What the backends that are programmed by kernels would compile on a GPU.
struct GpuProgram {
  ProgramKind kind;
  std::string kernel; ///< for people: "relax load image", "steps 5 candidates 1 colours class 7"
  std::string text;   ///< of kernels/shaders: "elastic.cl"
};

/// How arrays of sites lie, which says which texts are taken.
enum class GpuTexts {
  opencl, ///< *.cl: planes
  vulkan  ///< *.comp: texels
};

/// All programs that the sessions of both energies ask a GPU for, on images and on volumes, by every method
/// and every kind of work. Nothing is listed here: the sessions are run on a device that computes nothing and
/// keeps what it is asked to compile. Loops that measure and probe a device are not among them.
[[nodiscard]] std::vector<GpuProgram> gpu_programs(GpuTexts texts);

} // namespace hdmbench
