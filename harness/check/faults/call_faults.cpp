#include "backends/device/bindings.hpp"
#include "harness/check/faults/device_faults.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

namespace hdmbench::faults {

namespace {

/// A call in place of the driver's; a lambda without captures as the function that OpenGL has there.
template <typename Function>
Replacement replacement(const char* name, Function function) {
  return {name, reinterpret_cast<gl::Address>(+function)};
}

template <GLint format>
void texture_of_format(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height,
                       GLint border, GLenum layout, GLenum type, const void* pixels) {
  record_changed_call();
  (void)internal;
  HDMBENCH_DRIVER(TexImage2D)(target, level, format, width, height, border, layout, type, pixels);
}

/// Binds the image that is being drawn into, or stored to, as the one that is read.
void read_what_is_drawn_into() {
  GLint type = 0;
  HDMBENCH_DRIVER(GetFramebufferAttachmentParameterivEXT)
  (GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE_EXT, &type);
  if (type == GL_TEXTURE) { // and not the renderbuffer of the count
    GLint name = 0;
    HDMBENCH_DRIVER(GetFramebufferAttachmentParameterivEXT)
    (GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME_EXT, &name);
    HDMBENCH_DRIVER(ActiveTexture)(GL_TEXTURE0);
    HDMBENCH_DRIVER(BindTexture)(GL_TEXTURE_RECTANGLE_ARB, static_cast<GLuint>(name));
    record_changed_call();
  }
}

void read_what_is_stored_to() {
  GLint name = 0;
  HDMBENCH_DRIVER(GetIntegeri_v)(GL_IMAGE_BINDING_NAME, 0, &name);
  HDMBENCH_DRIVER(ActiveTexture)(GL_TEXTURE0 + binding::displacement);
  HDMBENCH_DRIVER(BindTexture)(GL_TEXTURE_BUFFER, static_cast<GLuint>(name));
  record_changed_call();
}

std::vector<DeviceFault> fragment_faults() {
  return {
      {.name = "penalty-uniform",
       .what = "half the penalty K in the uniform",
       .calls = {replacement("glUniform1f",
                             [](GLint location, GLfloat value) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Uniform1f)(location, 0.5F * value);
                             })}},
      {.name = "steps-uniform",
       .what = "one candidate fewer in the uniform, the last one 0",
       .method = "annealing",
       .calls = {replacement("glUniform1fv",
                             [](GLint location, GLsizei count, const GLfloat* values) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Uniform1fv)(location, count - 1, values);
                             })}},
      {.name = "colour-uniform",
       .what = "the colour stuck at 0",
       .method = "coloured",
       .calls = {replacement("glUniform4f",
                             [](GLint location, GLfloat, GLfloat strength, GLfloat number, GLfloat seed) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Uniform4f)(location, 0.0F, strength, number, seed);
                             })}},
      {.name = "sweep-number-uniform",
       .what = "the sweep's number stuck at 0",
       .method = "annealing",
       .calls = {replacement("glUniform4f",
                             [](GLint location, GLfloat colour, GLfloat strength, GLfloat, GLfloat seed) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Uniform4f)(location, colour, strength, 0.0F, seed);
                             })}},
      {.name = "half-float-textures",
       .what = "textures of 16-bit floats",
       .calls = {replacement("glTexImage2D", texture_of_format<GL_RGBA16F_ARB>)}},
      {.name = "eight-bit-textures",
       .what = "textures of 8 bits, clamped to 0 ... 1",
       .calls = {replacement("glTexImage2D", texture_of_format<GL_RGBA8>)}},
      {.name = "viewport-narrow",
       .what = "a viewport one column too narrow",
       .calls = {replacement("glViewport",
                             [](GLint x, GLint y, GLsizei width, GLsizei height) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Viewport)(x, y, width - 1, height);
                             })}},
      {.name = "viewport-low",
       .what = "a viewport one row too low",
       .calls = {replacement("glViewport",
                             [](GLint x, GLint y, GLsizei width, GLsizei height) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Viewport)(x, y, width, height - 1);
                             })}},
      {.name = "half-the-quad",
       .what = "one of the two triangles is drawn",
       .calls = {replacement("glDrawArrays",
                             [](GLenum mode, GLint first, GLsizei count) {
                               record_changed_call();
                               HDMBENCH_DRIVER(DrawArrays)(mode, first, count - 1);
                             })}},
      {.name = "upload-one-row-down",
       .what = "the displacement uploaded one row too low",
       .calls = {replacement("glTexSubImage2D",
                             [](GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height,
                                GLenum layout, GLenum type, const void* pixels) {
                               const GLint down = height > 1 ? 1 : 0;
                               record_changed_call();
                               HDMBENCH_DRIVER(TexSubImage2D)
                               (target, level, x, y + down, width, height - down, layout, type, pixels);
                             })}},
      {.name = "read-back-one-row-down",
       .what = "the result read one row too low",
       .calls = {replacement(
           "glReadPixels",
           [](GLint x, GLint y, GLsizei width, GLsizei height, GLenum layout, GLenum type, void* pixels) {
             const GLint down = height > 1 ? 1 : 0;
             record_changed_call();
             HDMBENCH_DRIVER(ReadPixels)
             (x, y + down, width, height - down, layout, type, pixels);
           })}},
      {.name = "dimension-uniform",
       .what = "the image's width one too small in the uniform",
       .calls = {replacement("glUniform2f",
                             [](GLint location, GLfloat width, GLfloat height) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Uniform2f)(location, width - 1.0F, height);
                             })}},
      {.name = "feedback",
       .what = "the texture drawn into is the one that is read",
       .calls = {replacement("glDrawArrays",
                             [](GLenum mode, GLint first, GLsizei count) {
                               read_what_is_drawn_into();
                               HDMBENCH_DRIVER(DrawArrays)(mode, first, count);
                             })}},
      {.name = "query-stuck",
       .what = "the occlusion query always gives 0",
       .calls = {replacement("glGetQueryObjectuiv",
                             [](GLuint, GLenum, GLuint* result) {
                               record_changed_call();
                               *result = 0;
                             })}},
  };
}

/// Words that sweeps are told (kernels/shaders/sweep.comp), one of them changed.
template <std::size_t word, auto change>
void sweep_words(GLint location, GLsizei count, const GLint* values) {
  std::array<GLint, 13> words{};
  if (static_cast<std::size_t>(count) != words.size()) { // another program's
    return HDMBENCH_DRIVER(Uniform1iv)(location, count, values);
  }
  std::copy_n(values, words.size(), words.begin());
  words[word] = change(words[word]);
  record_changed_call();
  HDMBENCH_DRIVER(Uniform1iv)(location, count, words.data());
}

template <std::size_t word, auto change>
DeviceFault in_words(std::string_view name, std::string_view what, std::string_view method) {
  return {.name = std::string(name),
          .what = std::string(what),
          .method = std::string(method),
          .calls = {{"glUniform1iv", reinterpret_cast<gl::Address>(&sweep_words<word, change>)}}};
}

std::vector<DeviceFault> compute_faults() {
  constexpr auto none = [](GLint) { return 0; };
  return {
      in_words<0, [](GLint bits) { return std::bit_cast<GLint>(0.5F * std::bit_cast<float>(bits)); }>(
          "penalty-uniform", "half the penalty K in the uniform", "icm"),
      in_words<1, [](GLint width) { return width - 1; }>(
          "dimension-uniform", "the image's width one too small in the uniform", "icm"),
      in_words<3, none>("colour-uniform", "the colour stuck at 0", "coloured"),
      in_words<5, none>("sweep-number-uniform", "the sweep's number stuck at 0", "annealing"),
      {.name = "steps-uniform",
       .what = "one candidate fewer in the uniform, the last one 0",
       .method = "annealing",
       .calls = {replacement("glUniform1fv",
                             [](GLint location, GLsizei count, const GLfloat* values) {
                               record_changed_call();
                               HDMBENCH_DRIVER(Uniform1fv)(location, count - 1, values);
                             })}},
      {.name = "dispatch-short",
       .what = "one group too few",
       .calls = {replacement("glDispatchCompute",
                             [](GLuint x, GLuint y, GLuint z) {
                               record_changed_call();
                               HDMBENCH_DRIVER(DispatchCompute)(x - 1, y, z);
                             })}},
      {.name = "upload-one-site-late",
       .what = "the displacement uploaded one site too late",
       .calls = {replacement("glBufferSubData",
                             [](GLenum target, GLintptr offset, GLsizeiptr size, const void* data) {
                               constexpr GLsizeiptr site = 2 * sizeof(GLfloat);
                               const GLintptr late = size > site ? site : 0;
                               record_changed_call();
                               HDMBENCH_DRIVER(BufferSubData)(target, offset + late, size - late, data);
                             })}},
      {.name = "feedback",
       .what = "the buffer stored to is the one that is read",
       .calls = {replacement("glDispatchCompute",
                             [](GLuint x, GLuint y, GLuint z) {
                               read_what_is_stored_to();
                               HDMBENCH_DRIVER(DispatchCompute)(x, y, z);
                             })}},
      {.name = "no-barriers",
       .what = "no glMemoryBarrier at all: a device that finishes one dispatch before the next shows nothing",
       .expected = Expected::either,
       .calls = {replacement("glMemoryBarrier", [](GLbitfield) { record_changed_call(); })}},
  };
}

// The guard bands. All state that they need is OpenGL's own: a buffer's guard is its last bytes.

constexpr GLsizeiptr guard_floats = 256; // the largest overrun of a row is a tile less a site
constexpr GLsizeiptr guard_bytes = guard_floats * static_cast<GLsizeiptr>(sizeof(GLfloat));
constexpr GLfloat guard_value = 12345.678F;

bool is_guarded(GLenum target) {
  return target == GL_TEXTURE_BUFFER; // and not the counter
}

void allocate_with_guard(GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
  if (!is_guarded(target)) {
    return HDMBENCH_DRIVER(BufferData)(target, size, data, usage);
  }
  record_changed_call();
  HDMBENCH_DRIVER(BufferData)(target, size + guard_bytes, nullptr, usage);
  if (data != nullptr) {
    HDMBENCH_DRIVER(BufferSubData)(target, 0, size, data);
  }
  const std::vector<GLfloat> guard(guard_floats, guard_value);
  HDMBENCH_DRIVER(BufferSubData)(target, size, guard_bytes, guard.data());
}

void read_if_guard_is_whole(GLenum target, GLintptr offset, GLsizeiptr size, void* data) {
  HDMBENCH_DRIVER(GetBufferSubData)(target, offset, size, data);
  if (!is_guarded(target)) {
    return;
  }
  std::vector<GLfloat> guard(guard_floats);
  HDMBENCH_DRIVER(GetBufferSubData)(target, offset + size, guard_bytes, guard.data());
  if (std::ranges::any_of(guard, [](GLfloat value) { return value != guard_value; })) {
    auto* const values = static_cast<GLfloat*>(data);
    std::fill_n(values, static_cast<std::size_t>(size) / sizeof(GLfloat),
                std::numeric_limits<GLfloat>::quiet_NaN());
  }
}

} // namespace

std::vector<Replacement> guard_bands() {
  return {replacement("glBufferData", allocate_with_guard),
          replacement("glGetBufferSubData", read_if_guard_is_whole)};
}

std::vector<DeviceFault> call_faults(Pipeline pipeline) {
  return pipeline == Pipeline::fragment ? fragment_faults() : compute_faults();
}

} // namespace hdmbench::faults
