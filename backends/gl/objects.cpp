#include "backends/gl/objects.hpp"

#include "backends/gl/context.hpp"

#include <fmt/format.h>

namespace hdmbench::gl {

namespace {

/// A driver's log for a shader or a program, without the trailing newline.
std::string info_log(GLuint name, const Function<decltype(&::glGetShaderiv)>& get_integer,
                     const Function<decltype(&::glGetShaderInfoLog)>& get_log) {
  GLint length = 0;
  get_integer(name, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  GLsizei written = 0;
  if (length > 0) {
    get_log(name, length, &written, log.data());
  }
  log.resize(static_cast<std::size_t>(written));
  while (!log.empty() && log.back() == '\n') {
    log.pop_back();
  }
  return log;
}

/// A compiled shader, until the program has it.
class Shader {
public:
  Shader(const Api& api, const Program::Stage& stage) : shader_(api, stage.type) {
    const std::size_t after_version = stage.source.find('\n') + 1;
    const bool has_choice = stage.source.find("HDM_NO_PRECISE") != std::string::npos; // precise.glsl
    if (!compiles(api, stage.source) &&
        !(has_choice &&
          compiles(api, std::string(stage.source).insert(after_version, "#define HDM_NO_PRECISE\n")))) {
      throw DeviceError(
          fmt::format("glCompileShader: {}", info_log(name(), api.GetShaderiv, api.GetShaderInfoLog)));
    }
  }

  [[nodiscard]] GLuint name() const { return shader_.name(); }

private:
  bool compiles(const Api& api, const std::string& source) const {
    const GLchar* text = source.c_str();
    api.ShaderSource(name(), 1, &text, nullptr);
    api.CompileShader(name());
    GLint compiled = GL_FALSE;
    api.GetShaderiv(name(), GL_COMPILE_STATUS, &compiled);
    return compiled != GL_FALSE;
  }

  Object<&Api::CreateShader, &Api::DeleteShader> shader_;
};

} // namespace

std::optional<double> Timer::device_seconds() {
  const auto time = [&](const Query& query) {
    GLuint64 nanoseconds = 0;
    api_->GetQueryObjectui64v(query.name(), GL_QUERY_RESULT, &nanoseconds);
    return nanoseconds;
  };
  for (std::size_t i = 0; i + 1 < times_.size(); i += 2) {
    const GLuint64 begin = time(times_[i]);
    busy_.add(1e-9 * static_cast<double>(time(times_[i + 1]) - begin));
  }
  times_.clear();
  if (!busy_.are_counted() && version_of(*api_) >= Version{3, 3}) { // which has timestamps
    GLint bits = 0;
    api_->GetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
    has_clock_ = bits > 0;
  }
  return busy_.take();
}

Program::Program(const Api& api, std::initializer_list<Stage> stages) : api_(&api), program_(api) {
  const GLuint name = program_.name();
  for (const Stage& stage : stages) {
    const Shader shader(api, stage);
    api.AttachShader(name, shader.name());
    if (stage.type == GL_VERTEX_SHADER) {
      api.BindAttribLocation(name, 0, "corner");
    }
  }
  api.LinkProgram(name);
  GLint linked = GL_FALSE;
  api.GetProgramiv(name, GL_LINK_STATUS, &linked);
  if (linked == GL_FALSE) {
    throw DeviceError(
        fmt::format("glLinkProgram: {}", info_log(name, api.GetProgramiv, api.GetProgramInfoLog)));
  }
}

void Program::use() const {
  api_->UseProgram(program_.name());
}

GLint Program::uniform(const char* name) const {
  return api_->GetUniformLocation(program_.name(), name);
}

std::string assemble(std::string_view shader, std::string_view definitions, const Energy& energy,
                     const Law* law) {
  std::string text = with_own_texts(shader, energy, law);
  text.insert(text.find('\n') + 1, fmt::format("#define HDM_INPUTS {}\n{}", energy.inputs, definitions));
  return text;
}

std::string definitions(const ShaderConstants& constants) {
  return fmt::format("#define RULE {}\n#define COLOURS {}\n#define STEP_COUNT {}\n", constants.rule,
                     constants.colours, constants.step_count);
}

std::string steps_definition(const std::array<float, 16>& steps) {
  std::string text;
  for (const float step : steps) {
    text += fmt::format("{}{:#.9g}", text.empty() ? "" : ", ", step);
  }
  return "#define STEPS " + text + "\n";
}

std::string assemble(std::string_view shader, const ShaderConstants& constants) {
  return assemble(shader, definitions(constants), *constants.energy);
}

} // namespace hdmbench::gl
