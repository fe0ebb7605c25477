#include "test/r300/shader_compiler.hpp"

#include "backends/gl/objects.hpp"
#include "test/captured_stream.hpp"

#include <fmt/format.h>
#include <shaders/quad_vertex.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string_view>

namespace hdmbench::test {

namespace {

constexpr gl::Version required{2, 1};
constexpr std::string_view card_name = "RV515";

void APIENTRY record(GLenum, GLenum, GLuint, GLenum, GLsizei, const GLchar* message, const void* messages) {
  static_cast<std::vector<std::string>*>(const_cast<void*>(messages))->emplace_back(message);
}

template <typename Pointer>
Pointer resolve(const gl::Api& api, const char* name) {
  const auto function = reinterpret_cast<Pointer>(api.resolve(name));
  if (function == nullptr) {
    throw DeviceError(fmt::format("the OpenGL driver has no {}", name));
  }
  return function;
}

/// A quad over one float rectangle texture per sampler, drawn to another.
void draw(const gl::Api& api, const gl::Program& program) {
  constexpr GLsizei size = 4;
  const std::array<const char*, 3> samplers{"image", "observation", "confidence"};
  std::vector<gl::Texture> textures;
  for (std::size_t i = 0; i <= samplers.size(); ++i) {
    textures.emplace_back(api);
    api.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    api.BindTexture(GL_TEXTURE_RECTANGLE_ARB, textures[i].name());
    api.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    api.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    api.TexImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, GL_RGBA32F_ARB, size, size, 0, GL_RGBA, GL_FLOAT, nullptr);
  }
  const gl::Framebuffer framebuffer(api);
  api.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffer.name());
  api.FramebufferTexture2DEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_TEXTURE_RECTANGLE_ARB,
                              textures.back().name(), 0);
  const gl::Buffer quad(api);
  static constexpr std::array<GLfloat, 8> corners{-1, -1, 1, -1, -1, 1, 1, 1};
  api.BindBuffer(GL_ARRAY_BUFFER, quad.name());
  api.BufferData(GL_ARRAY_BUFFER, sizeof(corners), corners.data(), GL_STATIC_DRAW);
  api.EnableVertexAttribArray(0);
  api.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
  program.use();
  for (std::size_t i = 0; i < samplers.size(); ++i) {
    api.Uniform1i(program.uniform(samplers[i]), static_cast<GLint>(i));
  }
  api.Viewport(0, 0, size, size);
  api.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  api.Finish();
}

} // namespace

Compilation judge(std::span<const std::string> messages, const std::string& errors) {
  constexpr std::string_view mark = "Compiler Error:\n";
  if (const auto error = errors.find(mark); error != std::string::npos) {
    const auto begin = error + mark.size();
    std::string line = errors.substr(begin, errors.find('\n', begin) - begin);
    if (const auto place = line.find("(): ");
        place != std::string::npos) { // "../src/FILE.c::FUNCTION(): WHAT"
      line.erase(0, place + 4);
    }
    return {std::nullopt, line};
  }
  for (auto message = messages.rbegin(); message != messages.rend(); ++message) {
    if (message->starts_with("FS shader: ")) {
      static const std::regex words(
          "FS shader: (\\d+) inst,.* (\\d+) flowcontrol,.* (\\d+) tex,.* (\\d+) temps,");
      std::smatch found;
      if (!std::regex_search(*message, found, words)) {
        throw DeviceError(fmt::format("the driver's statistics are in other words: {}", *message));
      }
      const auto number = [&](std::size_t i) { return std::stoi(found[i]); };
      return {Resources{number(1), number(3), number(4), number(2)}, {}};
    }
  }
  throw DeviceError("the driver reported neither the statistics of the fragment shader nor an error");
}

std::string why_missing() {
  const char* const path = std::getenv("LIBGL_DRIVERS_PATH");
  const std::filesystem::path driver =
      std::filesystem::path(path == nullptr ? HDMBENCH_DRIVERS : path) / "r300_dri.so";
  return std::filesystem::exists(driver)
             ? ""
             : fmt::format("there is no {}, Mesa's driver of the card", driver.string());
}

ShaderCompiler::ShaderCompiler() {
  const auto egl = gl::make_egl_platform();
  const std::vector<Device> devices = egl->devices(required);
  const auto card = std::ranges::find_if(
      devices, [](const Device& one) { return one.name.find(card_name) != std::string::npos; });
  if (card == devices.end()) {
    throw DeviceError(
        fmt::format("EGL does not see the {} of radeon_x1300.cpp; run with EGL_LOG_LEVEL=debug", card_name));
  }
  device_ = *card;
  context_ = egl->open(static_cast<std::size_t>(card - devices.begin()), required);
  const gl::Context::Current current(*context_);
  const auto enable = resolve<void (*)(GLenum)>(context_->api(), "glEnable");
  enable(GL_DEBUG_OUTPUT);
  enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  resolve<PFNGLDEBUGMESSAGECALLBACKPROC>(context_->api(), "glDebugMessageCallback")(record, &messages_);
  const auto get_limit = resolve<PFNGLGETPROGRAMIVARBPROC>(context_->api(), "glGetProgramivARB");
  const auto limit = [&](GLenum name) {
    GLint value = 0;
    get_limit(GL_FRAGMENT_PROGRAM_ARB, name, &value);
    return value;
  };
  limits_ = {limit(GL_MAX_PROGRAM_NATIVE_INSTRUCTIONS_ARB), limit(GL_MAX_PROGRAM_NATIVE_TEX_INSTRUCTIONS_ARB),
             limit(GL_MAX_PROGRAM_NATIVE_TEMPORARIES_ARB), 0};
}

Compilation ShaderCompiler::compile(const std::string& fragment_shader) {
  const gl::Context::Current current(*context_);
  const gl::Api& api = context_->api();
  messages_.clear();
  CapturedStream errors(stderr);
  const gl::Program program(
      api, {{GL_VERTEX_SHADER, std::string(sources::quad_vertex)}, {GL_FRAGMENT_SHADER, fragment_shader}});
  draw(api, program);
  return judge(messages_, errors.take());
}

} // namespace hdmbench::test
