#include "harness/check/faults/device_faults.hpp"

#include "backends/gl/fragment.hpp"

#ifdef HDMBENCH_WITH_EGL
#include "backends/gl/compute.hpp"
#endif

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mutations_text.hpp>

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <type_traits>
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

/// The driver's own function in the context that is current in this thread.
gl::Address driver_function(const char* name) {
  return current_context->driver_function(name);
}

/// A replacement has changed this call.
void record_changed_call() {
  ++current_context->record().calls;
}

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
                     .part = levels   ? Part::levels
                             : sleep  ? Part::sleep
                             : coarse ? Part::coarse_levels
                                      : Part::sweep,
                     .expected = has("control") ? Expected::let_through : Expected::disagree,
                     .edits = {{.shader = parts[3]}}};
}

/// The function that OpenGL has under a name, replaced by `change`, which gets the driver's own first.
template <typename Function, typename Name, typename Change>
struct Changed;

template <typename Result, typename... Arguments, typename Name, typename Change>
struct Changed<Result (*)(Arguments...), Name, Change> {
  static Result call(Arguments... arguments) {
    const auto driver = reinterpret_cast<Result (*)(Arguments...)>(driver_function(Name{}()));
    if constexpr (std::is_same_v<std::invoke_result_t<Change, decltype(driver), Arguments...>, bool>) {
      if (Change{}(driver, arguments...)) {
        record_changed_call();
      }
    } else {
      record_changed_call();
      Change{}(driver, arguments...);
    }
  }
};

template <typename Function, typename Name, typename Change>
Replacement replacement(Name name, Change /*change*/) {
  return {name(), reinterpret_cast<gl::Address>(&Changed<Function, Name, Change>::call)};
}

/// HDMBENCH_CALL(Viewport, (auto driver, auto x, ...) { driver(x + 1, ...); }): a lambda without captures in
/// place of glViewport. One that returns bool says whether it has changed this call.
#define HDMBENCH_CALL(function, ...)                                                                         \
  replacement<decltype(&::gl##function)>([] { return "gl" #function; }, [] __VA_ARGS__)

/// The driver's own glViewport: HDMBENCH_DRIVER(Viewport)(0, 0, 1, 1).
#define HDMBENCH_DRIVER(function) reinterpret_cast<decltype(&::gl##function)>(driver_function("gl" #function))

DeviceFault in_call(std::string_view name, std::string_view what, const Replacement& call) {
  return {.name = std::string(name), .what = std::string(what), .calls = {call}};
}

/// Binds the image that is being drawn into as the one that is read. Whether there is one.
bool read_what_is_drawn_into() {
  GLint type = 0;
  HDMBENCH_DRIVER(GetFramebufferAttachmentParameterivEXT)
  (GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE_EXT, &type);
  if (type != GL_TEXTURE) { // but the renderbuffer of the count
    return false;
  }
  GLint name = 0;
  HDMBENCH_DRIVER(GetFramebufferAttachmentParameterivEXT)
  (GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME_EXT, &name);
  HDMBENCH_DRIVER(ActiveTexture)(GL_TEXTURE0);
  HDMBENCH_DRIVER(BindTexture)(GL_TEXTURE_RECTANGLE_ARB, static_cast<GLuint>(name));
  return true;
}

std::vector<DeviceFault> fragment_faults() {
  return {
      in_call("penalty-uniform", "half the penalty K in the uniform",
              HDMBENCH_CALL(
                  Uniform1f, (auto driver, auto at, auto value) { driver(at, 0.5F * value); })),
      in_call("half-float-textures", "textures of 16-bit floats",
              HDMBENCH_CALL(
                  TexImage2D, (auto driver, auto target, auto level, auto /*format*/,
                               auto... others) { driver(target, level, GL_RGBA16F_ARB, others...); })),
      in_call("viewport-narrow", "a viewport one column too narrow",
              HDMBENCH_CALL(
                  Viewport, (auto driver, auto x, auto y, auto width,
                             auto height) { driver(x, y, width - 1, height); })),
      in_call("upload-one-row-down", "the displacement uploaded one row too low",
              HDMBENCH_CALL(
                  TexSubImage2D,
                  (auto driver, auto target, auto level, auto x, auto y, auto width, auto height,
                   auto... others) {
                    const GLint down = height > 1 ? 1 : 0;
                    driver(target, level, x, y + down, width, height - down, others...);
                  })),
      in_call("feedback", "the texture drawn into is the one that is read",
              HDMBENCH_CALL(
                  DrawArrays,
                  (auto driver, auto... arguments) {
                    const bool bound = read_what_is_drawn_into();
                    driver(arguments...);
                    return bound;
                  })),
      in_call("query-stuck", "the occlusion query always gives 0",
              HDMBENCH_CALL(
                  GetQueryObjectuiv, (auto /*driver*/, auto, auto, auto result) { *result = 0; })),
  };
}

std::vector<DeviceFault> compute_faults() {
  return {
      in_call("dispatch-short", "one group too few",
              HDMBENCH_CALL(
                  DispatchCompute, (auto driver, auto x, auto y, auto z) { driver(x - 1, y, z); })),
      in_call("penalty-uniform", "half the penalty K in the uniform",
              HDMBENCH_CALL(
                  Uniform1iv,
                  (auto driver, auto location, auto count, auto values) {
                    constexpr GLsizei words_of_sweep = 13; // kernels/shaders/sweep.comp: K is the first
                    std::vector<GLint> words(values, values + count);
                    if (count == words_of_sweep) {
                      words[0] = std::bit_cast<GLint>(0.5F * std::bit_cast<float>(words[0]));
                    }
                    driver(location, count, words.data());
                    return count == words_of_sweep;
                  })),
  };
}

constexpr GLsizeiptr guard_floats = 256; // the largest overrun of a row is a tile less a site
constexpr GLsizeiptr guard_bytes = guard_floats * static_cast<GLsizeiptr>(sizeof(GLfloat));
constexpr GLfloat guard_value = 12345.678F;

/// What makes buffers longer and looks whether the end is still as it was: a damaged guard turns the next
/// field that is read into NaN. All state that this needs is OpenGL's own: a buffer's guard is its last
/// bytes. The counter, which is no GL_TEXTURE_BUFFER, has none.
std::vector<Replacement> guard_bands() {
  return {HDMBENCH_CALL(
              BufferData,
              (auto driver, auto target, auto size, auto data, auto usage) {
                if (target != GL_TEXTURE_BUFFER) {
                  driver(target, size, data, usage);
                  return false;
                }
                driver(target, size + guard_bytes, nullptr, usage);
                const auto write = HDMBENCH_DRIVER(BufferSubData);
                if (data != nullptr) {
                  write(target, 0, size, data);
                }
                const std::vector<GLfloat> guard(guard_floats, guard_value);
                write(target, size, guard_bytes, guard.data());
                return true;
              }),
          HDMBENCH_CALL(
              GetBufferSubData, (auto driver, auto target, auto offset, auto size, auto data) {
                driver(target, offset, size, data);
                if (target != GL_TEXTURE_BUFFER) {
                  return false;
                }
                std::vector<GLfloat> guard(guard_floats);
                driver(target, offset + size, guard_bytes, guard.data());
                if (std::ranges::any_of(guard, [](GLfloat value) { return value != guard_value; })) {
                  std::fill_n(static_cast<GLfloat*>(data), static_cast<std::size_t>(size) / sizeof(GLfloat),
                              std::numeric_limits<GLfloat>::quiet_NaN());
                }
                return false;
              })};
}

/// No mistakes, and the one that only a guard shows.
std::vector<DeviceFault> controls(Pipeline pipeline) {
  std::vector<DeviceFault> list{{.name = "unedited",
                                 .what = "the shaders as they are, by the way that mistakes take",
                                 .method = "",
                                 .expected = Expected::let_through}};
  if (pipeline == Pipeline::fragment) {
    list.push_back(in_call("of-the-thesis",
                           "a device of the thesis's time: texels of one site also for candidates",
                           HDMBENCH_CALL(
                               GetIntegerv, (auto driver, auto name, auto value) {
                                 driver(name, value);
                                 const bool is_vertex_fetch = name == GL_MAX_VERTEX_TEXTURE_IMAGE_UNITS;
                                 *value = is_vertex_fetch ? 0 : *value;
                                 return is_vertex_fetch;
                               })));
  } else {
    list.push_back({.name = "guarded", .what = "guard bands behind the buffers, and no mistake"});
    list.back().calls = guard_bands();
  }
  list.back().expected = Expected::let_through;
  if (pipeline == Pipeline::compute) {
    list.push_back(
        {.name = "overrun",
         .what = "the end of a row is not checked: what no other row overwrites ends in the guard",
         .edits = {{.find = "bool inside = !border || x < size.x;", .replace = "bool inside = true;"},
                   {.find = "rows = border && left >= size.x ? 0 : rows;", .replace = ""}},
         .calls = guard_bands()});
  }
  return list;
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
          .part = fault.part,
          .make =
              [pipeline, fault, record] {
                *record = {};
                return make_backend(pipeline, fault, record);
              },
          .require_planted = require_planted};
}

std::vector<DeviceFault> call_faults(Pipeline pipeline) {
  std::vector<DeviceFault> all = controls(pipeline);
  const auto own = pipeline == Pipeline::fragment ? fragment_faults() : compute_faults();
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

} // namespace hdmbench::faults
