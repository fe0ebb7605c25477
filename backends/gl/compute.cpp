#include "backends/gl/compute.hpp"

#include "backends/gl/objects.hpp"
#include "backends/session/device_backend.hpp"

#include <fmt/format.h>
#include <shaders/coarse_levels_compute.hpp>
#include <shaders/elastic_compute.hpp>
#include <shaders/laws_compute.hpp>
#include <shaders/levels_compute.hpp>
#include <shaders/loops_compute.hpp>
#include <shaders/sweep_compute.hpp>

#include <array>
#include <limits>
#include <optional>
#include <utility>

namespace hdmbench::gl {

namespace {

constexpr Version required{4, 3};

/// Locations of what a program is told, as kernels/shaders/fields.glsl has them.
constexpr GLint words_location = 0;
constexpr GLint steps_location = 32;

GLenum format_of(Kind kind) {
  return kind == Kind::pairs ? GL_RG32F : GL_RGBA32F;
}

/// In the order of Kernel.
constexpr std::array texts{sources::sweep_compute,   sources::levels_compute, sources::coarse_levels_compute,
                           sources::elastic_compute, sources::laws_compute,   sources::loops_compute};

/// What a context has bound, by backends/device/device.hpp.
using Bound = std::array<const Array*, binding::count>;

/// A buffer, which shaders fetch and store to as a texture of one row where it has texels.
class GlArray final : public Array {
public:
  GlArray(ComputeDevice& device, const Api& api, Bound& bound, std::size_t count, Kind kind)
      : Array(device, count, kind), gl_(api), bound_(bound), buffer_(api) {
    gl_.BindBuffer(target(), buffer_.name());
    gl_.BufferData(target(), static_cast<GLsizeiptr>(bytes()), nullptr, GL_DYNAMIC_COPY);
    if (kind != Kind::words) {
      texture_.emplace(api);
      gl_.BindTexture(GL_TEXTURE_BUFFER, texture_->name());
      gl_.TexBuffer(GL_TEXTURE_BUFFER, format_of(kind), buffer_.name());
      bound_ = {}; // this texture has taken a unit
    }
  }
  ~GlArray() override { std::ranges::replace(bound_, static_cast<const Array*>(this), nullptr); }

  [[nodiscard]] GLenum target() const {
    return kind() == Kind::words ? GL_SHADER_STORAGE_BUFFER : GL_TEXTURE_BUFFER;
  }
  void bind_buffer(GLenum to) const { gl_.BindBuffer(to, buffer_.name()); }
  void bind(std::size_t number) const {
    const auto unit = static_cast<GLuint>(number);
    if (number < binding::first_words) {
      gl_.BindImageTexture(unit, texture_->name(), 0, GL_FALSE, 0, GL_READ_WRITE, format_of(kind()));
    } else if (number < binding::first_fetched) {
      gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, unit, buffer_.name());
    } else {
      gl_.ActiveTexture(GL_TEXTURE0 + unit);
      gl_.BindTexture(GL_TEXTURE_BUFFER, texture_->name());
    }
  }

private:
  const Api& gl_;
  Bound& bound_;
  Buffer buffer_;
  std::optional<Texture> texture_;
};

class GlProgram final : public hdmbench::Program {
public:
  GlProgram(const Api& api, const ProgramKind& kind)
      : program(api, {{GL_COMPUTE_SHADER, compute_text(kind)}}) {}

  gl::Program program;
};

class GlDevice final : public ComputeDevice {
public:
  explicit GlDevice(std::unique_ptr<Context> context)
      : context_(std::move(context)), gl_(context_->api()), description_(describe(*context_, required)) {
    const Context::Current current(*context_);
    GLint texels = 0;
    gl_.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();
    // What core OpenGL 4.3 guarantees of work groups.
    limits_ = {.elements = static_cast<std::size_t>(texels),
               .array_bytes = unlimited,
               .memory = unlimited,
               .groups_x = 65535,
               .groups_y = 65535,
               .group = 1024,
               .shared_bytes = 32 * 1024,
               .compiles_steps = true};
  }

  const Device& description() const override { return description_; }
  const DeviceLimits& limits() const override { return limits_; }

  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    const GlArray& array = of(to);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    array.bind_buffer(array.target());
    gl_.BufferSubData(array.target(), static_cast<GLintptr>(first), static_cast<GLsizeiptr>(values.size()),
                      values.data());
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    const GlArray& array = of(from);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    array.bind_buffer(array.target());
    if (description_.is_software) {
      gl_.GetBufferSubData(array.target(), static_cast<GLintptr>(first),
                           static_cast<GLsizeiptr>(values.size()), values.data());
      return;
    }
    // A copy is read: NVIDIA's driver moves a buffer that the host reads into the host's memory, for good.
    const Buffer copied(gl_);
    gl_.BindBuffer(GL_COPY_WRITE_BUFFER, copied.name());
    gl_.BufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(std::min(values.size(), staging_bytes)),
                   nullptr, GL_STREAM_READ);
    for (std::size_t done = 0; done < values.size(); done += staging_bytes) {
      const auto bytes = static_cast<GLsizeiptr>(std::min(values.size() - done, staging_bytes));
      gl_.CopyBufferSubData(array.target(), GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(first + done), 0,
                            bytes);
      gl_.GetBufferSubData(GL_COPY_WRITE_BUFFER, 0, bytes, values.data() + done);
    }
  }
  std::unique_ptr<hdmbench::Program> compile(const ProgramKind& kind) override {
    return std::make_unique<GlProgram>(gl_, kind);
  }
  ProgramText text_of(const ProgramKind& kind) const override {
    return {.bytes = compute_text(kind), .ending = "comp"};
  }
  void run(std::span<const Commands::value_type> commands) override {
    timer_([&] {
      for (const auto& command : commands) {
        std::visit(
            [&](const auto& one) {
              if (!one.beside) {
                gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                                  GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
              }
              run(one);
            },
            command);
      }
    });
  }
  void finish() override { gl_.Finish(); }
  std::optional<double> device_seconds() override { return timer_.device_seconds(); }
  void settle() noexcept override {
    gl_.quietly(gl_.Finish);
    timer_.forget();
  }
  void abandon() noexcept override { context_->abandon(); }

private:
  static const GlArray& of(const Array& array) { return static_cast<const GlArray&>(array); }

  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return std::make_unique<GlArray>(*this, gl_, bound_, count, kind);
  }
  void enter() override { current_.emplace(*context_); }
  void leave() noexcept override { current_.reset(); }

  void run(const Dispatch& dispatch) {
    static_cast<const GlProgram&>(*dispatch.program).program.use();
    if (dispatch.word_count > 0) {
      gl_.Uniform1iv(words_location, static_cast<GLsizei>(dispatch.word_count), dispatch.words.data());
    }
    if (dispatch.step_count > 0) {
      gl_.Uniform1fv(steps_location, dispatch.step_count, dispatch.steps.data());
    }
    for (std::size_t number = 0; number < bound_.size(); ++number) {
      if (dispatch.arrays[number] != nullptr && dispatch.arrays[number] != bound_[number]) {
        of(*dispatch.arrays[number]).bind(number);
        bound_[number] = dispatch.arrays[number];
      }
    }
    gl_.DispatchCompute(static_cast<GLuint>(dispatch.groups.width),
                        static_cast<GLuint>(dispatch.groups.height),
                        static_cast<GLuint>(dispatch.groups.depth));
  }
  void run(const Fill& fill) {
    const GLuint zero = 0;
    of(*fill.array).bind_buffer(GL_SHADER_STORAGE_BUFFER);
    gl_.ClearBufferSubData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, static_cast<GLintptr>(fill.first),
                           static_cast<GLsizeiptr>(fill.bytes), GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
  }

  std::unique_ptr<Context> context_;
  const Api& gl_;
  Timer timer_{gl_};
  Device description_;
  DeviceLimits limits_;
  std::optional<Context::Current> current_;
  Bound bound_{};
};

class GlComputeApi final : public ComputeApi {
public:
  explicit GlComputeApi(std::unique_ptr<Platform> platform) : platform_(std::move(platform)) {}

  std::vector<Device> devices() const override { return platform_->devices(required); }
  std::unique_ptr<ComputeDevice> open(std::size_t index) const override {
    return std::make_unique<GlDevice>(platform_->open(index, required));
  }

private:
  std::unique_ptr<Platform> platform_;
};

} // namespace

std::string compute_text(const ProgramKind& kind) {
  std::string definitions = fmt::format("#define HDM_AXES {}\n", kind.axes);
  for (const ProgramKind::Constant& constant : kind.constants) {
    definitions += fmt::format("#define {} {}\n", constant.name, constant.value);
  }
  if (kind.steps) {
    definitions += steps_definition(*kind.steps);
  }
  return assemble(texts.at(static_cast<std::size_t>(kind.kernel)), definitions, *kind.energy, kind.law);
}

std::unique_ptr<Backend> make_compute(std::unique_ptr<Platform> platform) {
  return make_device_backend({.name = "gl-compute",
                              .description = "GLSL 4.30 compute shader, OpenGL through EGL",
                              .language = "GLSL 4.30, compute"},
                             std::make_unique<GlComputeApi>(std::move(platform)));
}

} // namespace hdmbench::gl
