#pragma once

#include "backends/gl/context.hpp"
#include "harness/check/faults/planted.hpp"

#include <memory>
#include <string>
#include <vector>

namespace hdmbench::faults {

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

/// A mistake between a real backend and its driver, or a control (planted.hpp).
struct DeviceFault {
  std::string name{};
  std::string what{};         ///< one line for people
  std::string method = "icm"; ///< that it concerns
  Part part = Part::sweep;
  Expected expected = Expected::disagree;
  std::vector<Edit> edits{};
  std::vector<Replacement> calls{};
  std::size_t variant = 0; ///< as in Planted
};

/// What has become of a DeviceFault: edits made and calls changed, in all contexts of a platform.
struct PlantingRecord {
  int edits = 0;
  int calls = 0;
};

/// A platform whose contexts hand every shader's text, edited, and some calls, changed, to the driver of
/// `sound`. A shader that is meant and does not contain an edit's text exactly once: glShaderSource throws
/// NotPlanted.
[[nodiscard]] std::unique_ptr<gl::Platform> make_faulty_platform(std::unique_ptr<gl::Platform> sound,
                                                                 DeviceFault fault,
                                                                 std::shared_ptr<PlantingRecord> record);

/// For replacements: the driver's own function in the context that is current in this thread.
[[nodiscard]] gl::Address driver_function(const char* name);
/// For replacements: this call has been changed.
void record_changed_call();

/// The same with its type: HDMBENCH_DRIVER(Viewport)(0, 0, 1, 1).
#define HDMBENCH_DRIVER(name)                                                                                \
  (reinterpret_cast<decltype(&::gl##name)>(::hdmbench::faults::driver_function("gl" #name)))

} // namespace hdmbench::faults
