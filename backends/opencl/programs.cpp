#include "backends/opencl/programs.hpp"

#include "backends/shared/energy_programs.hpp"

#include <fmt/format.h>
#include <shaders/count_opencl.hpp>
#include <shaders/language_opencl.hpp>
#include <shaders/site.hpp>
#include <shaders/sweep_opencl.hpp>
#include <shaders/update.hpp>

#include <algorithm>
#include <string_view>

namespace hdmbench::opencl {

namespace {

/// Numbers without a suffix are floats; -w because some drivers print warnings whether asked or not.
constexpr const char* options = "-cl-std=CL1.2 -cl-single-precision-constant -w";

} // namespace

Shape shape_for(const FoundDevice& device) {
  if (device.is_cpu) {
    return {.tile = {128, 16}, .lanes = 1};
  }
  return {.tile = {64, 16}, .lanes = static_cast<int>(std::min<std::size_t>(64, device.largest_group))};
}

std::string assemble(const SweepKind& kind, const Shape& shape) {
  const ShaderConstants& constants = kind.constants;
  std::string text =
      fmt::format("#define HDM_INPUTS {}\n#define RULE {}\n#define COLOURS {}\n#define STEP_COUNT {}\n"
                  "#define TILE_WIDTH {}\n#define TILE_HEIGHT {}\n#define LANES {}\n#define ACTIVE {}\n"
                  "#define GENERAL {}\n",
                  constants.energy->inputs, constants.rule, constants.colours, constants.step_count,
                  shape.tile.width, shape.tile.height, shape.lanes, kind.active, kind.general ? 1 : 0);
  for (const std::string_view part :
       {sources::language_opencl, sources::site, programs_of(*constants.energy).text, sources::update,
        sources::sweep_opencl}) {
    text += part;
  }
  return text;
}

Kernels::Kernels(const Queue& queue)
    : queue_(&queue), shape_(shape_for(queue.device())),
      count_(queue.make_kernel(std::string(sources::count_opencl), options, "count_changes")) {}

const Kernel& Kernels::sweep(const SweepKind& kind) {
  auto found = sweeps_.find(kind);
  if (found == sweeps_.end()) {
    found = sweeps_.emplace(kind, queue_->make_kernel(assemble(kind, shape_), options, "sweep")).first;
  }
  return found->second;
}

} // namespace hdmbench::opencl
