#include "harness/check/faults/device_faults.hpp"

#include "backends/gl/compute.hpp"
#include "backends/gl/context.hpp"
#include "backends/gl/fragment.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>
#include <mutations_text.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace hdmbench::faults {

NLOHMANN_JSON_SERIALIZE_ENUM(Part, {{Part::sweep, "sweep"},
                                    {Part::levels, "levels"},
                                    {Part::coarse_levels, "coarse levels"},
                                    {Part::sleep, "sleep"}})
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(CallEdit, function, first, argument, times, plus)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(DeviceFault, name, what, method, axes, part, is_control,
                                                shader, edits, calls, is_guarded)

namespace {

class FaultyContext;

/// OpenGL's functions are plain C and are told nothing but their arguments: which context they work on is
/// state of the thread, here as in OpenGL itself. Set while a FaultyContext is current.
thread_local FaultyContext* current_context = nullptr;

/// The function that stands in place of the driver's own; null: the driver's own.
gl::Address replacement_of(std::string_view name, const DeviceFault& fault);

/// What has become of a DeviceFault: edits made and calls changed, in all contexts of a platform.
struct PlantingRecord {
  std::size_t edits = 0;
  std::size_t calls = 0;
};

class FaultyContext final : public gl::Context {
public:
  FaultyContext(std::unique_ptr<gl::Context> sound, DeviceFault fault, std::shared_ptr<PlantingRecord> record)
      : sound_(std::move(sound)), fault_(std::move(fault)), record_(std::move(record)),
        api_([this](const char* name) {
          const gl::Address replacement = replacement_of(name, fault_);
          return replacement != nullptr ? replacement : driver_function(name);
        }) {}

  const gl::Api& api() const override { return api_; }
  void abandon() noexcept override {
    api_.abandoned = true;
    sound_->abandon();
  }

  [[nodiscard]] gl::Address driver_function(const char* name) const { return sound_->api().resolve(name); }
  [[nodiscard]] const DeviceFault& fault() const { return fault_; }
  [[nodiscard]] PlantingRecord& record() const { return *record_; }

private:
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

class FaultyPlatform final : public gl::Platform {
public:
  FaultyPlatform(DeviceFault fault, std::shared_ptr<PlantingRecord> record)
      : fault_(std::move(fault)), record_(std::move(record)) {}

  std::vector<Device> devices(gl::Version version) const override { return sound_->devices(version); }
  std::unique_ptr<gl::Context> open(std::size_t index, gl::Version version) const override {
    return std::make_unique<FaultyContext>(sound_->open(index, version), fault_, record_);
  }

private:
  std::unique_ptr<gl::Platform> sound_ = gl::make_egl_platform();
  DeviceFault fault_;
  std::shared_ptr<PlantingRecord> record_;
};

std::string word_for(Pipeline pipeline) {
  return pipeline == Pipeline::fragment ? "fragment" : "compute";
}

/// The driver's own function in the context that is current in this thread.
template <typename Function>
Function driver_function(const char* name) {
  return reinterpret_cast<Function>(current_context->driver_function(name));
}
/// HDMBENCH_DRIVER(Viewport)(0, 0, 1, 1): the driver's own glViewport.
#define HDMBENCH_DRIVER(function) driver_function<decltype(&::gl##function)>("gl" #function)

/// The text with all edits made that are meant for it.
std::string edited(std::string text) {
  const DeviceFault& fault = current_context->fault();
  if (text.find(fault.shader) == std::string::npos) {
    return text;
  }
  for (const auto& [find, replace] : fault.edits) {
    const auto at = text.find(find);
    if (at == std::string::npos || text.find(find, at + 1) != std::string::npos) {
      throw NotPlanted(fmt::format("\"{}\" is {} in the shader", find,
                                   at == std::string::npos ? "not" : "more than once"));
    }
    text.replace(at, find.size(), replace);
    ++current_context->record().edits;
  }
  return text;
}

void edited_shader_source(GLuint shader, GLsizei count, const GLchar* const* texts, const GLint* lengths) {
  std::string whole;
  for (GLsizei i = 0; i < count; ++i) {
    whole += lengths == nullptr || lengths[i] < 0
                 ? std::string(texts[i])
                 : std::string(texts[i], static_cast<std::size_t>(lengths[i]));
  }
  const std::string text = edited(std::move(whole));
  const GLchar* const begin = text.c_str();
  HDMBENCH_DRIVER(ShaderSource)(shader, 1, &begin, nullptr);
}

template <typename Number>
void change(const CallEdit& edit, Number& number) {
  number = static_cast<Number>(edit.times * static_cast<double>(number) + edit.plus);
  ++current_context->record().calls;
}

/// Changes an argument before the driver is called, and what it points to afterwards.
template <typename Argument>
void change_argument(const CallEdit& edit, Argument& argument, bool was_called) {
  if constexpr (std::is_same_v<Argument, GLint*> || std::is_same_v<Argument, GLuint*>) {
    if (was_called) {
      change(edit, *argument);
    }
  } else if constexpr (std::is_arithmetic_v<Argument>) {
    if (!was_called) {
      change(edit, argument);
    }
  }
}

/// In place of a function of the driver: `Name` gives what it is called.
template <typename Function, typename Name>
struct Edited;

template <typename... Arguments, typename Name>
struct Edited<void (*)(Arguments...), Name> {
  static void call(Arguments... arguments) {
    const auto first = static_cast<double>(std::get<0>(std::tie(arguments...)));
    const auto change_all = [&](bool was_called) {
      for (const CallEdit& edit : current_context->fault().calls) {
        if (edit.function == Name{}() && edit.first.value_or(first) == first) {
          int number = 0;
          ((number++ == edit.argument ? change_argument(edit, arguments, was_called) : void()), ...);
        }
      }
    };
    change_all(false);
    driver_function<void (*)(Arguments...)>(Name{}())(arguments...);
    change_all(true);
  }
};

constexpr GLsizeiptr guard_floats = 256; // the largest overrun of a row is a tile less a site
constexpr GLsizeiptr guard_bytes = guard_floats * static_cast<GLsizeiptr>(sizeof(GLfloat));
constexpr GLfloat guard_value = 12345.678F;

/// Makes a buffer of texels longer: its last bytes are its guard.
void guarded_buffer_data(GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
  const auto make = HDMBENCH_DRIVER(BufferData);
  if (target != GL_TEXTURE_BUFFER) {
    make(target, size, data, usage);
    return;
  }
  make(target, size + guard_bytes, nullptr, usage);
  const auto write = HDMBENCH_DRIVER(BufferSubData);
  if (data != nullptr) {
    write(target, 0, size, data);
  }
  const std::vector<GLfloat> guard(guard_floats, guard_value);
  write(target, size, guard_bytes, guard.data());
  ++current_context->record().calls;
}

/// Reads NaN where the guard is not as it was.
void guarded_get_buffer_sub_data(GLenum target, GLintptr offset, GLsizeiptr size, void* data) {
  const auto read = HDMBENCH_DRIVER(GetBufferSubData);
  read(target, offset, size, data);
  if (target != GL_TEXTURE_BUFFER) {
    return;
  }
  std::vector<GLfloat> guard(guard_floats);
  read(target, offset + size, guard_bytes, guard.data());
  if (std::ranges::any_of(guard, [](GLfloat value) { return value != guard_value; })) {
    std::fill_n(static_cast<GLfloat*>(data), static_cast<std::size_t>(size) / sizeof(GLfloat),
                std::numeric_limits<GLfloat>::quiet_NaN());
  }
}

struct Replacement {
  std::string_view name;
  gl::Address by;
};

/// The functions whose calls can be changed.
#define HDMBENCH_EDITED(function)                                                                            \
  Replacement {                                                                                              \
    "gl" #function, reinterpret_cast<gl::Address>(                                                           \
                        &Edited<decltype(&::gl##function), decltype([] { return "gl" #function; })>::call)   \
  }
const std::array editable{HDMBENCH_EDITED(DispatchCompute),   HDMBENCH_EDITED(GetIntegerv),
                          HDMBENCH_EDITED(GetQueryObjectuiv), HDMBENCH_EDITED(TexImage2D),
                          HDMBENCH_EDITED(TexSubImage2D),     HDMBENCH_EDITED(Uniform1f),
                          HDMBENCH_EDITED(Viewport)};

gl::Address replacement_of(std::string_view name, const DeviceFault& fault) {
  if (name == "glShaderSource") {
    return reinterpret_cast<gl::Address>(&edited_shader_source);
  }
  if (fault.is_guarded && name == "glBufferData") {
    return reinterpret_cast<gl::Address>(&guarded_buffer_data);
  }
  if (fault.is_guarded && name == "glGetBufferSubData") {
    return reinterpret_cast<gl::Address>(&guarded_get_buffer_sub_data);
  }
  const auto found = std::ranges::find(editable, name, &Replacement::name);
  const bool is_meant = std::ranges::find(fault.calls, name, &CallEdit::function) != fault.calls.end();
  return is_meant && found != editable.end() ? found->by : nullptr;
}

} // namespace

std::vector<DeviceFault> device_faults(Pipeline pipeline) {
  const auto groups = nlohmann::json::parse(sources::mutations_text, nullptr, true, true); // with comments
  std::vector<DeviceFault> faults;
  for (const nlohmann::json& group : groups) {
    const auto pipelines = group["pipelines"].get<std::vector<std::string>>();
    if (std::ranges::find(pipelines, word_for(pipeline)) != pipelines.end()) {
      for (const nlohmann::json& fault : group["faults"]) {
        nlohmann::json whole = group; // what it says of all
        whole.update(fault);
        faults.push_back(whole.get<DeviceFault>());
      }
    }
  }
  return faults;
}

Planted plant(Pipeline pipeline, const DeviceFault& fault) {
  const auto record = std::make_shared<PlantingRecord>();
  return {.name = fault.name,
          .what = fault.what,
          .backend = "gl-" + word_for(pipeline),
          .layer = fault.edits.empty() ? Layer::driver : Layer::shader,
          .expected = fault.is_control ? Expected::let_through : Expected::disagree,
          .method = fault.method,
          .axes = fault.axes,
          .part = fault.part,
          .make =
              [pipeline, fault, record] {
                *record = {};
                auto platform = std::make_unique<FaultyPlatform>(fault, record);
                return pipeline == Pipeline::compute
                           ? gl::make_compute(std::move(platform))
                           : gl::make_fragment("gl-fragment", "", std::move(platform));
              },
          .require_planted =
              [record, edits = fault.edits.size(), has_calls = !fault.calls.empty() || fault.is_guarded] {
                if (record->edits < edits) {
                  throw NotPlanted("no shader that was meant has gone to the driver");
                }
                if (has_calls && record->calls == 0) {
                  throw NotPlanted("the call has never been made");
                }
              }};
}

} // namespace hdmbench::faults
