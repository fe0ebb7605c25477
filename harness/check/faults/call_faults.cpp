#include "harness/check/faults/device_faults.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <type_traits>

namespace hdmbench::faults {

namespace {

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
  DeviceFault no_barriers =
      in_call("no-barriers",
              "no glMemoryBarrier at all: a device that finishes one dispatch before the next shows nothing",
              HDMBENCH_CALL(MemoryBarrier, (auto /*driver*/, auto /*bits*/){}));
  no_barriers.expected = Expected::either;
  return {
      no_barriers,
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

std::vector<DeviceFault> call_faults(Pipeline pipeline) {
  std::vector<DeviceFault> all = controls(pipeline);
  const auto own = pipeline == Pipeline::fragment ? fragment_faults() : compute_faults();
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

} // namespace hdmbench::faults
