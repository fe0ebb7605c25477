#include "backends/opencl/programs.hpp"

#include "backends/shared/energy_programs.hpp"
#include "backends/shared/sweep_shapes.hpp"

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

/// PoCL takes 8 sites side by side of its own accord. Rows of 128 sites make more tiles border tiles.
constexpr std::array<Shape, 6> cpu_shapes{{{.tile = {64, 16}, .lanes = 1, .simd_width = 16},
                                           {.tile = {64, 16}, .lanes = 1, .simd_width = 8},
                                           {.tile = {64, 32}, .lanes = 1, .simd_width = 16},
                                           {.tile = {128, 16}, .lanes = 1, .simd_width = 16},
                                           {.tile = {128, 32}, .lanes = 1, .simd_width = 8},
                                           {.tile = {128, 32}, .lanes = 1, .simd_width = 16}}};

constexpr std::array<Shape, 6> gpu_shapes{{{.tile = {64, 16}, .lanes = 64, .simd_width = 1},
                                           {.tile = {64, 8}, .lanes = 64, .simd_width = 1},
                                           {.tile = {32, 16}, .lanes = 32, .simd_width = 1},
                                           {.tile = {32, 8}, .lanes = 32, .simd_width = 1},
                                           {.tile = {128, 8}, .lanes = 128, .simd_width = 1},
                                           {.tile = {128, 16}, .lanes = 64, .simd_width = 1}}};

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

std::span<const Shape> shapes_for(const FoundDevice& device) {
  if (device.is_cpu) {
    return cpu_shapes;
  }
  const auto fits = [&](const Shape& shape) {
    return static_cast<std::size_t>(shape.lanes) <= device.largest_group;
  };
  return std::ranges::all_of(gpu_shapes, fits) ? std::span<const Shape>(gpu_shapes) : cpu_shapes;
}

std::vector<Shape> all_shapes() {
  std::vector<Shape> all(cpu_shapes.begin(), cpu_shapes.end());
  all.insert(all.end(), gpu_shapes.begin(), gpu_shapes.end());
  return all;
}

Variants shape_variants(const FoundDevice& device) {
  Variants result{.what = std::string(sweep_shapes_what), .measure = measure_shapes};
  for (const Shape& shape : shapes_for(device)) {
    result.names.push_back(fmt::format("{} x {} sites by {}", shape.tile.width, shape.tile.height,
                                       shape.lanes > 1 ? fmt::format("{} work items", shape.lanes)
                                                       : fmt::format("SIMD of {}", shape.simd_width)));
  }
  result.worth_trying = result.names.size();
  return result;
}

std::string assemble(const SweepKind& kind) {
  const Shape& shape = kind.shape;
  const ShaderConstants& constants = kind.constants;
  std::string text = fmt::format(
      "#define HDM_INPUTS {}\n#define RULE {}\n#define COLOURS {}\n#define STEP_COUNT {}\n"
      "#define TILE_WIDTH {}\n#define TILE_HEIGHT {}\n#define LANES {}\n#define ACTIVE {}\n"
      "#define GENERAL {}\n#define SIMD_WIDTH {}\n",
      constants.energy->inputs, constants.rule, constants.colours, constants.step_count, shape.tile.width,
      shape.tile.height, shape.lanes, kind.active, kind.general ? 1 : 0, shape.simd_width);
  return joined(std::move(text),
                {sources::language_opencl, sources::site, programs_of(*constants.energy).text,
                 sources::update, sources::sweep_opencl});
}

const Kernel& Kernels::sweep(const SweepKind& kind) {
  auto found = sweeps_.find(kind);
  if (found == sweeps_.end()) {
    found = sweeps_.emplace(kind, queue_->make_kernel(assemble(kind), build_options, "sweep")).first;
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
