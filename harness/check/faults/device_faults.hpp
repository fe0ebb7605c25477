#pragma once

#include "backends/gl/context.hpp"
#include "harness/check/faults/trial.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench::faults {

/// The two ways to OpenGL.
enum class Pipeline { fragment, compute };

/// A piece of a shader's text and what goes to the driver in its place.
struct Edit {
  std::string find{};
  std::string replace{};
  /// Which shaders are meant: those that contain this. Preset: those of one sweep.
  std::string shader = "const int rule = RULE;";
};

/// A function that the driver is thought to have in place of its own.
struct Replacement {
  const char* function = ""; ///< "glViewport"
  gl::Address by = nullptr;
};

/// A mistake between a real backend and its driver, or a control (trial.hpp).
struct DeviceFault {
  std::string name{};
  std::string what{};         ///< one line for people
  std::string method = "icm"; ///< that it concerns
  Part part = Part::sweep;
  Expected expected = Expected::disagree;
  std::vector<Edit> edits{};
  std::vector<Replacement> calls{};
};

/// Those that this build has a backend for.
[[nodiscard]] std::vector<Pipeline> pipelines();

/// `fault` on the backend of a pipeline that this build has: the fragment shader through EGL, or through
/// OSMesa where EGL has no device; the compute shader. Its contexts hand every shader's text, edited, and
/// some calls, changed, to the driver. A shader that is meant and does not contain an edit's text exactly
/// once: NotPlanted.
[[nodiscard]] Planted plant(Pipeline pipeline, const DeviceFault& fault);

/// Mistakes and controls in the texts of the shaders, by a table: mutations.txt says how it is read.
/// Throws std::invalid_argument with the line that is none.
[[nodiscard]] std::vector<DeviceFault> text_faults(Pipeline pipeline, std::string_view table);
/// Of the table that is built in.
[[nodiscard]] std::vector<DeviceFault> text_faults(Pipeline pipeline);

/// Mistakes in the calls: sizes, formats, uniforms, bindings; and controls.
[[nodiscard]] std::vector<DeviceFault> call_faults(Pipeline pipeline);

} // namespace hdmbench::faults
