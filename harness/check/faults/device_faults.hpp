#pragma once

#include "harness/check/faults/trial.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench::faults {

/// The two ways to OpenGL through EGL.
enum class Pipeline { fragment, compute };

/// A number in a call of the driver that becomes `times` it plus `plus`: an argument, or, where that is a
/// pointer, what the driver has written there.
struct CallEdit {
  std::string function{};        ///< "glViewport"; one of a list in device_faults.cpp
  std::optional<double> first{}; ///< only calls whose first argument is this
  int argument = 0;              ///< from 0
  double times = 1.0;
  double plus = 0.0;
};

/// A mistake between a real backend and its driver, or a control (trial.hpp).
struct DeviceFault {
  std::string name{};
  std::string what{};         ///< one line for people
  std::string method = "icm"; ///< that it concerns
  std::size_t axes = 2;       ///< of the scenes
  Part part = Part::sweep;
  bool is_control = false; ///< no mistake: verify has to let it through
  /// Which shaders are edited: those that contain this. Preset: those of one sweep.
  std::string shader = "const int rule = RULE;";
  /// Pieces of their text, and what goes to the driver in their place.
  std::vector<std::pair<std::string, std::string>> edits{};
  std::vector<CallEdit> calls{};
  /// Buffers of texels are longer, and a field that is read is NaN where something was written behind one.
  bool is_guarded = false;
};

/// `fault` on the backend of a pipeline. Its contexts hand every shader's text, edited, and some calls,
/// changed, to the driver. A shader that is meant and does not contain an edit's text exactly once:
/// NotPlanted; so is a call that is never made, or that is not on the list of those that can be changed.
[[nodiscard]] Planted plant(Pipeline pipeline, const DeviceFault& fault);

/// The mistakes and controls of a table, which is mutations.json and says how it is read.
[[nodiscard]] std::vector<DeviceFault> device_faults(Pipeline pipeline);

} // namespace hdmbench::faults
