#pragma once

#include "harness/check/faults/faulty_platform.hpp"

#include <vector>

namespace hdmbench::faults {

/// The two ways to OpenGL.
enum class Pipeline { fragment, compute };

/// Those that this build has a backend for.
[[nodiscard]] std::vector<Pipeline> pipelines();

/// `fault` on the backend of a pipeline that this build has: the fragment shader through EGL, or through
/// OSMesa where EGL has no device; the compute shader.
[[nodiscard]] Planted plant(Pipeline pipeline, const DeviceFault& fault);

/// Mistakes in the text of the sweep's shaders: kernels/specification/*.inc and the shaders that
/// include them.
[[nodiscard]] std::vector<DeviceFault> text_faults(Pipeline pipeline);

/// Mistakes in the text of the shaders between the sweeps: those that sample and project a level, those that
/// find out which tiles sleep.
[[nodiscard]] std::vector<DeviceFault> text_faults_between_sweeps(Pipeline pipeline);

/// Mistakes in the text of the shaders of the elastic energy.
[[nodiscard]] std::vector<DeviceFault> text_faults_of_elastic(Pipeline pipeline);

/// Mistakes in the calls: sizes, formats, uniforms, bindings.
[[nodiscard]] std::vector<DeviceFault> call_faults(Pipeline pipeline);

/// The same sums in another order, fused, without `precise`; guard bands that nobody touches.
[[nodiscard]] std::vector<DeviceFault> device_controls(Pipeline pipeline);

/// What makes buffers longer and looks whether the end is still as it was: a damaged guard turns the next
/// field that is read into NaN.
[[nodiscard]] std::vector<Replacement> guard_bands();

} // namespace hdmbench::faults
