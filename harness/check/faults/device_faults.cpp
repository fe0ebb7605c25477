#include "harness/check/faults/device_faults.hpp"

#include "backends/gl/fragment.hpp"

#ifdef HDMBENCH_WITH_EGL
#include "backends/gl/compute.hpp"
#endif

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mutations_text.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

namespace hdmbench::faults {

namespace {

class FaultyContext;

/// OpenGL's functions are plain C and are told nothing but their arguments: which context they work on is
/// state of the thread, here as in OpenGL itself. Set while a FaultyContext is current.
thread_local FaultyContext* current_context = nullptr;

void edited_shader_source(GLuint shader, GLsizei count, const GLchar* const* texts, const GLint* lengths);

/// What has become of a DeviceFault: edits made and calls changed, in all contexts of a platform.
struct PlantingRecord {
  int edits = 0;
  int calls = 0;
};

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
    return name == "glShaderSource" ? reinterpret_cast<gl::Address>(&edited_shader_source)
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

void edited_shader_source(GLuint shader, GLsizei count, const GLchar* const* texts, const GLint* lengths) {
  std::string whole;
  for (GLsizei i = 0; i < count; ++i) {
    whole += lengths == nullptr || lengths[i] < 0
                 ? std::string(texts[i])
                 : std::string(texts[i], static_cast<std::size_t>(lengths[i]));
  }
  const std::string edited = current_context->edited(std::move(whole));
  const GLchar* const text = edited.c_str();
  reinterpret_cast<decltype(&::glShaderSource)>(driver_function("glShaderSource"))(shader, 1, &text, nullptr);
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

std::string backend_name(Pipeline pipeline) {
#ifdef HDMBENCH_WITH_EGL
  return pipeline == Pipeline::compute ? "gl-compute" : "gl-fragment";
#else
  (void)pipeline;
  return "gl-fragment-osmesa";
#endif
}

[[maybe_unused]] bool has_device(const gl::Platform& platform) {
  try {
    return !platform.devices({2, 1}).empty();
  } catch (const DeviceError&) {
    return false;
  }
}

/// EGL; OSMesa where only that has a device for the fragment shader, or only that is built.
std::unique_ptr<gl::Platform> make_sound_platform([[maybe_unused]] Pipeline pipeline) {
#ifdef HDMBENCH_WITH_EGL
  auto egl = gl::make_egl_platform();
#ifdef HDMBENCH_WITH_OSMESA
  if (pipeline == Pipeline::fragment && !has_device(*egl)) {
    auto osmesa = gl::make_osmesa_platform();
    return has_device(*osmesa) ? std::move(osmesa) : std::move(egl);
  }
#endif
  return egl;
#else
  return gl::make_osmesa_platform();
#endif
}

std::unique_ptr<Backend> make_backend(Pipeline pipeline, const DeviceFault& fault,
                                      const std::shared_ptr<PlantingRecord>& record) {
  auto platform = std::make_unique<FaultyPlatform>(make_sound_platform(pipeline), fault, record);
#ifdef HDMBENCH_WITH_EGL
  if (pipeline == Pipeline::compute) {
    return gl::make_compute(std::move(platform));
  }
#endif
  return gl::make_fragment(backend_name(pipeline), "", std::move(platform));
}

/// The parts of `text`, which `separator` separates.
std::vector<std::string> split(const std::string& text, std::string_view separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + separator.size();
  }
  return parts;
}

/// \n is a new line and "" nothing.
std::string meant_by(const std::string& part) {
  return part == "\"\"" ? "" : fmt::format("{}", fmt::join(split(part, "\\n"), "\n"));
}

/// What a line in brackets says of the mistakes below it: a fault without a name, whose edit has the text of
/// the shaders that are meant. None where the pipeline is another one.
std::optional<DeviceFault> section_of(const std::vector<std::string>& parts, Pipeline pipeline) {
  const auto has = [&](std::string_view word) { return parts[0].find(word) != std::string::npos; };
  const bool levels = parts.size() == 4 && parts[2] == "levels";
  const bool sleep = parts.size() == 4 && parts[2] == "sleep";
  const bool coarse = parts.size() == 4 && parts[2] == "coarse levels";
  if (parts.size() != 4 || !(levels || sleep || coarse || parts[2] == "sweep")) {
    throw std::invalid_argument(fmt::format("no section of mutations: {}", fmt::join(parts, " | ")));
  }
  if (!has(pipeline == Pipeline::fragment ? "fragment" : "compute")) {
    return std::nullopt;
  }
  return DeviceFault{.method = parts[1],
                     .part = levels  ? Part::levels
                             : sleep ? Part::sleep
                                     : Part::sweep,
                     .variant = coarse ? 1U : 0U,
                     .expected = has("control") ? Expected::let_through : Expected::disagree,
                     .edits = {{.shader = parts[3]}}};
}

} // namespace

std::vector<DeviceFault> text_faults(Pipeline pipeline, std::string_view table) {
  std::vector<DeviceFault> faults;
  std::optional<DeviceFault> section;
  bool has_section = false;
  for (const std::string& line : split(std::string(table), "\n")) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    if (line.front() == '[' && line.back() == ']') {
      section = section_of(split(line.substr(1, line.size() - 2), " | "), pipeline);
      has_section = true;
      continue;
    }
    const std::vector<std::string> parts = split(line, " | ");
    if (!has_section || parts.size() < 4 || parts.size() % 2 != 0) {
      throw std::invalid_argument(fmt::format("no line of a table of mutations: {}", line));
    }
    if (section) {
      DeviceFault& fault = faults.emplace_back(*section);
      fault.name = parts[0];
      fault.what = parts[1];
      fault.edits.clear();
      for (std::size_t i = 2; i < parts.size(); i += 2) {
        fault.edits.push_back({meant_by(parts[i]), meant_by(parts[i + 1]), section->edits.front().shader});
      }
    }
  }
  return faults;
}

std::vector<DeviceFault> text_faults(Pipeline pipeline) {
  return text_faults(pipeline, sources::mutations_text);
}

std::vector<Pipeline> pipelines() {
#ifdef HDMBENCH_WITH_EGL
  return {Pipeline::fragment, Pipeline::compute};
#else
  return {Pipeline::fragment};
#endif
}

Planted plant(Pipeline pipeline, const DeviceFault& fault) {
  const auto record = std::make_shared<PlantingRecord>();
  const auto require_planted = [record, edits = fault.edits.size(), calls = fault.calls.size()] {
    if (record->edits < static_cast<int>(edits)) {
      throw NotPlanted("no shader that was meant has gone to the driver");
    }
    if (calls > 0 && record->calls == 0) {
      throw NotPlanted("the call has never been made");
    }
  };
  return {.name = fault.name,
          .what = fault.what,
          .backend = backend_name(pipeline),
          .layer = fault.edits.empty() ? Layer::driver : Layer::shader,
          .expected = fault.expected,
          .method = fault.method,
          .variant = fault.variant,
          .part = fault.part,
          .make =
              [pipeline, fault, record] {
                *record = {};
                return make_backend(pipeline, fault, record);
              },
          .require_planted = require_planted};
}

gl::Address driver_function(const char* name) {
  return current_context->driver_function(name);
}

void record_changed_call() {
  ++current_context->record().calls;
}

} // namespace hdmbench::faults
