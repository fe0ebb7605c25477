#pragma once

#include "backends/gl/context.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// What the compiler of the thesis's card, ATI's Radeon X1300 (RV515), makes of a fragment shader: Mesa's
/// r300 driver on the card of radeon_x1300.cpp, which an executable that uses this must be linked with.
namespace hdmbench::test {

/// What a fragment program takes of the card, or may take at most.
struct Resources {
  int instructions = 0; ///< arithmetic and texture instructions share one store
  int texture_instructions = 0;
  int temporaries = 0; ///< registers of four floats
  int flow_control =
      0; ///< of the instructions, those of branches and loops: fragment programs of 2008 had none
};

struct Compilation {
  std::optional<Resources>
      resources;       ///< none: the driver gave the shader up, and draws something else in silence
  std::string refusal; ///< then why, in the driver's words
};

/// What a compilation was, by all that a driver says while it happens: `messages` of KHR_debug and its
/// standard error. A statistics line beside an error is that of the dummy which the driver takes instead.
/// Throws DeviceError where there is neither, or where the line does not say what it used to.
[[nodiscard]] Compilation judge(std::span<const std::string> messages, const std::string& errors);

/// Why there can be no such compiler on this machine, empty where its driver is installed.
[[nodiscard]] std::string why_missing();

class ShaderCompiler {
public:
  /// Throws DeviceError with EGL's words.
  ShaderCompiler();
  ShaderCompiler(const ShaderCompiler&) = delete; // its context writes to its messages
  ShaderCompiler& operator=(const ShaderCompiler&) = delete;

  /// "ATI RV515", "OpenGL 2.1 Mesa ...".
  [[nodiscard]] const Device& device() const { return device_; }
  [[nodiscard]] const Resources& limits() const { return limits_; }

  /// Compiles, links with quad.vert and draws a quad over float rectangle textures, as the gl-fragment
  /// backend does. Throws DeviceError where the text is wrong GLSL.
  [[nodiscard]] Compilation compile(const std::string& fragment_shader);

private:
  std::vector<std::string> messages_; ///< of KHR_debug
  Device device_;
  std::unique_ptr<gl::Context> context_;
  Resources limits_;
};

} // namespace hdmbench::test
