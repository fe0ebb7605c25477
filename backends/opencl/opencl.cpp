#include "backends/opencl/opencl.hpp"

#include "backends/opencl/device.hpp"
#include "backends/session/device_backend.hpp"
#include "backends/shared/energy_programs.hpp"
#include "kernels/shaders/elastic_steps.h"

#include <fmt/format.h>
#include <shaders/ceilings_opencl.hpp>
#include <shaders/count_opencl.hpp>
#include <shaders/elastic_cell.hpp>
#include <shaders/elastic_opencl.hpp>
#include <shaders/elastic_site.hpp>
#include <shaders/elastic_steps.hpp>
#include <shaders/language_opencl.hpp>
#include <shaders/probe.hpp>
#include <shaders/probe_opencl.hpp>
#include <shaders/projection.hpp>
#include <shaders/resample_opencl.hpp>
#include <shaders/site.hpp>
#include <shaders/sweep_opencl.hpp>
#include <shaders/update.hpp>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace hdmbench::opencl {

namespace {

/// What all kernels are built with. Numbers without a suffix are floats; nothing is flushed or fused; -w
/// because some drivers print warnings, whether asked or not.
constexpr const char* build_options = "-cl-std=CL1.2 -cl-single-precision-constant -w";

/// What is a kernel's in the texts: its name, its arguments by backends/device/bindings.hpp, and its texts.
struct Source {
  const char* name = "";
  std::vector<std::size_t> arguments;
  std::vector<std::string_view> texts;
};

Source source_of(const ProgramKind& kind) {
  using namespace binding;
  switch (kind.kernel) {
  case Kernel::sweep:
    return {"sweep",
            {displacement, improved, material, observation, inverse_curvature, inputs, tiles, lengths},
            {sources::language_opencl, sources::site, programs_of(*kind.energy).text, sources::update,
             sources::sweep_opencl}};
  case Kernel::count:
    return {"count_changes", {displacement, improved, counter}, {sources::count_opencl}};
  case Kernel::sample:
    return {"sample_level",
            {material, observation, sampled_material, sampled_observation, entries},
            {sources::language_opencl, sources::projection, sources::resample_opencl}};
  case Kernel::project:
    return {"project",
            {displacement, improved, entries},
            {sources::language_opencl, sources::projection, sources::resample_opencl}};
  case Kernel::elastic:
    return {"elastic_step",
            {ELASTIC_FROM, ELASTIC_SECOND, ELASTIC_STORED, ELASTIC_MOMENTS, ELASTIC_RESPONSE, ELASTIC_TOUCHED,
             ELASTIC_MORE, ELASTIC_MATRICES, ELASTIC_INVERSE},
            {sources::language_opencl, sources::elastic_steps, sources::elastic_cell, sources::elastic_site,
             sources::elastic_opencl}};
  case Kernel::probe:
    return {"probe", {source, target}, {sources::language_opencl, sources::probe, sources::probe_opencl}};
  case Kernel::copy:
    return {"copy", {source, target}, {sources::ceilings_opencl}};
  case Kernel::multiply_add:
    return {"multiply_add", {source, target}, {sources::ceilings_opencl}};
  case Kernel::coarse_levels:
  case Kernel::elastic_coarse:
    break; // of devices with shared memory
  }
  return {};
}

class ClArray final : public Array {
public:
  ClArray(ComputeDevice& device, const Queue& queue, std::size_t count, Kind kind)
      : Array(device, count, kind), buffer(queue.make_buffer(bytes())) {}

  Buffer buffer;
};

const Buffer& of(const Array& array) {
  return static_cast<const ClArray&>(array).buffer;
}

class ClProgram final : public Program {
public:
  ClProgram(const Queue& queue, const ProgramKind& kind, std::size_t usual_lanes)
      : ClProgram(queue, kind, usual_lanes, source_of(kind)) {}

  std::vector<std::size_t> arguments;
  std::size_t lanes; ///< work items of a group
  BuiltKernel kernel;

private:
  ClProgram(const Queue& queue, const ProgramKind& kind, std::size_t usual_lanes, const Source& source)
      : arguments(source.arguments), lanes(usual_lanes),
        kernel(queue.make_kernel(text(kind, source, lanes), build_options, source.name)) {}

  static std::string text(const ProgramKind& kind, const Source& source, std::size_t& lanes) {
    std::string all = fmt::format("#define HDM_INPUTS {}\n", kind.energy->inputs);
    for (const ProgramKind::Constant& constant : kind.constants) {
      all += fmt::format("#define {} {}\n", constant.name, constant.value);
      if (constant.name == "LANES") {
        lanes = static_cast<std::size_t>(constant.value);
      }
    }
    for (const std::string_view part : source.texts) {
      all += part;
    }
    return all;
  }
};

class ClDevice final : public ComputeDevice {
public:
  ClDevice(Queue queue, std::vector<SweepShape> shapes)
      : queue_(std::move(queue)), shapes_(std::move(shapes)) {
    const FoundDevice& device = queue_.device();
    constexpr std::size_t indexable = std::size_t{1} << 35; // four planes of 2^31 floats
    limits_ = {.elements = indexable,
               .array_bytes = std::min(device.largest_buffer, indexable),
               .memory = device.memory,
               .groups_x = indexable,
               .groups_y = indexable,
               .group = static_cast<int>(std::min<std::size_t>(device.largest_group, 1024)),
               .shared_bytes = 0,
               .has_planes = true};
    const auto fits = [&](const SweepShape& shape) { return shape.invocations() <= limits_.group; };
    if (shapes_.empty()) {
      const bool is_cpu = device.is_cpu || !std::ranges::all_of(sweep_shapes_of_rows, fits);
      const auto& all = is_cpu ? sweep_shapes_of_simd : sweep_shapes_of_rows;
      shapes_.assign(all.begin(), all.end());
    }
  }

  const Device& description() const override { return queue_.device().description; }
  const DeviceLimits& limits() const override { return limits_; }
  std::span<const SweepShape> shapes() const override { return shapes_; }

  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    queue_.write(of(to), first, values);
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    queue_.read(of(from), first, values);
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return std::make_unique<ClProgram>(queue_, kind, static_cast<std::size_t>(shapes_.front().invocations()));
  }
  void run(std::span<const Commands::value_type> commands) override {
    for (const auto& command : commands) {
      std::visit([&](const auto& one) { run(one); }, command);
    }
  }
  void finish() override { queue_.finish(); }

private:
  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return std::make_unique<ClArray>(*this, queue_, count, kind);
  }

  void run(const Dispatch& dispatch) const {
    const auto& program = static_cast<const ClProgram&>(*dispatch.program);
    cl_uint index = 0;
    for (const std::size_t number : program.arguments) {
      program.kernel.set(index++, of(*dispatch.arrays.at(number)));
    }
    if (dispatch.word_count > 0) {
      std::array<std::int32_t, 48> told{};
      std::copy_n(dispatch.words.begin(), dispatch.word_count, told.begin());
      std::size_t bytes = dispatch.word_count * sizeof(std::int32_t);
      if (dispatch.step_count > 0) {
        std::memcpy(&told.at(dispatch.word_count), dispatch.steps.data(), sizeof dispatch.steps);
        bytes += sizeof dispatch.steps;
      }
      program.kernel.set_bytes(index, bytes, told.data());
    }
    queue_.run(program.kernel, dispatch.groups.sites(), program.lanes);
  }
  void run(const Fill& fill) const { queue_.clear(of(*fill.array), fill.first, fill.bytes); }

  Queue queue_;
  DeviceLimits limits_;
  std::vector<SweepShape> shapes_;
};

class OpenClApi final : public ComputeApi {
public:
  [[nodiscard]] std::vector<Device> devices() const override {
    std::vector<Device> all;
    for (const FoundDevice& found : find_devices(Api())) {
      all.push_back(found.description);
    }
    return all;
  }

  [[nodiscard]] std::unique_ptr<ComputeDevice> open(std::size_t index) const override {
    auto api = std::make_shared<const Api>();
    std::vector<FoundDevice> found = find_devices(*api);
    if (index >= found.size()) {
      throw DeviceError(fmt::format("OpenCL device {} has gone, {} are left", index, found.size()));
    }
    return opencl::open(std::move(api), std::move(found[index]), {});
  }
};

} // namespace

std::unique_ptr<ComputeDevice> open(std::shared_ptr<const Api> api, FoundDevice device,
                                    std::vector<SweepShape> shapes) {
  return std::make_unique<ClDevice>(Queue(std::move(api), std::move(device)), std::move(shapes));
}

} // namespace hdmbench::opencl

namespace hdmbench {

std::unique_ptr<Backend> make_opencl() {
  return make_device_backend({.name = "opencl",
                              .description = "OpenCL C 1.2 kernel, compiled at run time, buffers of planes",
                              .language = "OpenCL C 1.2"},
                             std::make_unique<opencl::OpenClApi>());
}

} // namespace hdmbench
