#include "backends/opencl/programs.hpp"

#include "backends/shared/energy_programs.hpp"

#include <fmt/format.h>
#include <shaders/count_opencl.hpp>
#include <shaders/language_opencl.hpp>
#include <shaders/projection.hpp>
#include <shaders/resample_opencl.hpp>
#include <shaders/site.hpp>
#include <shaders/sweep_opencl.hpp>
#include <shaders/update.hpp>

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace hdmbench::opencl {

namespace {

std::string joined(std::string text, std::initializer_list<std::string_view> parts) {
  for (const std::string_view part : parts) {
    text += part;
  }
  return text;
}

std::string resampling_text() {
  return joined("", {sources::language_opencl, sources::projection, sources::resample_opencl});
}

} // namespace

Shape shape_for(const FoundDevice& device) {
  const std::size_t lanes = device.is_cpu ? 1 : std::min<std::size_t>(64, device.largest_group);
  return {.tile = tile_size, .lanes = static_cast<int>(lanes)};
}

std::string assemble(const SweepKind& kind, const Shape& shape) {
  const ShaderConstants& constants = kind.constants;
  std::string text =
      fmt::format("#define HDM_INPUTS {}\n#define RULE {}\n#define COLOURS {}\n#define STEP_COUNT {}\n"
                  "#define TILE_WIDTH {}\n#define TILE_HEIGHT {}\n#define LANES {}\n#define ACTIVE {}\n"
                  "#define GENERAL {}\n",
                  constants.energy->inputs, constants.rule, constants.colours, constants.step_count,
                  shape.tile.width, shape.tile.height, shape.lanes, kind.active, kind.general ? 1 : 0);
  return joined(std::move(text),
                {sources::language_opencl, sources::site, programs_of(*constants.energy).text,
                 sources::update, sources::sweep_opencl});
}

Kernels::Kernels(const Queue& queue, Shape shape) : queue_(&queue), shape_(shape) {}

const Kernel& Kernels::sweep(const SweepKind& kind) {
  auto found = sweeps_.find(kind);
  if (found == sweeps_.end()) {
    found = sweeps_.emplace(kind, queue_->make_kernel(assemble(kind, shape_), build_options, "sweep")).first;
  }
  return found->second;
}

const Kernel& Kernels::count() {
  return made(count_, std::string(sources::count_opencl), "count_changes");
}

const Kernel& Kernels::sample() {
  return made(sample_, resampling_text(), "sample_level");
}

const Kernel& Kernels::project() {
  return made(project_, resampling_text(), "project");
}

const Kernel& Kernels::made(std::optional<Kernel>& kernel, const std::string& text, const char* name) const {
  if (!kernel) {
    kernel = queue_->make_kernel(text, build_options, name);
  }
  return *kernel;
}

} // namespace hdmbench::opencl
