#include "harness/check/faults/faulty_platform.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

namespace hdmbench::faults {

namespace {

class FaultyContext;

/// OpenGL's functions are plain C and are told nothing but their arguments: which context they work on is
/// state of the thread, here as in OpenGL itself. Set while a FaultyContext is current.
thread_local FaultyContext* current_context = nullptr;

void shader_source(GLuint shader, GLsizei count, const GLchar* const* texts, const GLint* lengths);

class FaultyContext final : public gl::Context {
public:
  FaultyContext(std::unique_ptr<gl::Context> sound, DeviceFault fault, std::shared_ptr<PlantingRecord> record)
      : sound_(std::move(sound)), fault_(std::move(fault)), record_(std::move(record)),
        api_([this](const char* name) { return resolve(name); }) {}

  const gl::Api& api() const override { return api_; }
  void abandon() noexcept override {
    api_.abandoned = true;
    sound_->abandon();
  }

  [[nodiscard]] gl::Address driver_function(const char* name) const { return sound_->api().resolve(name); }
  [[nodiscard]] PlantingRecord& record() const { return *record_; }

  /// The text with all edits made that are meant for it.
  [[nodiscard]] std::string edited(std::string text) const {
    for (const Edit& edit : fault_.edits) {
      if (text.find(edit.shader) == std::string::npos) {
        continue;
      }
      const auto at = text.find(edit.find);
      if (at == std::string::npos || text.find(edit.find, at + 1) != std::string::npos) {
        throw NotPlanted(fmt::format("\"{}\" is {} in the shader", edit.find,
                                     at == std::string::npos ? "not" : "more than once"));
      }
      text.replace(at, edit.find.size(), edit.replace);
      ++record_->edits;
    }
    return text;
  }

private:
  [[nodiscard]] gl::Address resolve(std::string_view name) const {
    const auto found = std::ranges::find(fault_.calls, name, &Replacement::function);
    if (found != fault_.calls.end()) {
      return found->by;
    }
    return name == "glShaderSource" ? reinterpret_cast<gl::Address>(&shader_source)
                                    : driver_function(std::string(name).c_str());
  }

  void bind() override {
    current_.emplace(*sound_);
    current_context = this;
  }
  void unbind() noexcept override {
    current_context = nullptr;
    current_.reset();
  }

  std::unique_ptr<gl::Context> sound_;
  DeviceFault fault_;
  std::shared_ptr<PlantingRecord> record_;
  gl::Api api_;
  std::optional<gl::Context::Current> current_;
};

void shader_source(GLuint shader, GLsizei count, const GLchar* const* texts, const GLint* lengths) {
  std::string whole;
  for (GLsizei i = 0; i < count; ++i) {
    whole += lengths == nullptr || lengths[i] < 0
                 ? std::string(texts[i])
                 : std::string(texts[i], static_cast<std::size_t>(lengths[i]));
  }
  const std::string edited = current_context->edited(std::move(whole));
  const GLchar* const text = edited.c_str();
  HDMBENCH_DRIVER(ShaderSource)(shader, 1, &text, nullptr);
}

class FaultyPlatform final : public gl::Platform {
public:
  FaultyPlatform(std::unique_ptr<gl::Platform> sound, DeviceFault fault,
                 std::shared_ptr<PlantingRecord> record)
      : sound_(std::move(sound)), fault_(std::move(fault)), record_(std::move(record)) {}

  std::vector<Device> devices(gl::Version version) const override { return sound_->devices(version); }
  std::unique_ptr<gl::Context> open(std::size_t index, gl::Version version) const override {
    return std::make_unique<FaultyContext>(sound_->open(index, version), fault_, record_);
  }

private:
  std::unique_ptr<gl::Platform> sound_;
  DeviceFault fault_;
  std::shared_ptr<PlantingRecord> record_;
};

} // namespace

std::unique_ptr<gl::Platform> make_faulty_platform(std::unique_ptr<gl::Platform> sound, DeviceFault fault,
                                                   std::shared_ptr<PlantingRecord> record) {
  return std::make_unique<FaultyPlatform>(std::move(sound), std::move(fault), std::move(record));
}

gl::Address driver_function(const char* name) {
  return current_context->driver_function(name);
}

void record_changed_call() {
  ++current_context->record().calls;
}

} // namespace hdmbench::faults
