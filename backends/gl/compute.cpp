#include "backends/gl/compute.hpp"

#include "backends/gl/context_session.hpp"
#include "backends/gl/objects.hpp"

#include <fmt/format.h>
#include <shaders/count_compute.hpp>
#include <shaders/sweep_compute.hpp>

#include <array>
#include <optional>

namespace hdmbench::gl {

namespace {

constexpr Version required{4, 3};

/// As in the shaders' layout(binding = ..., location = ...).
constexpr GLenum image_unit = 0;
constexpr GLenum observation_unit = 1;
constexpr GLenum confidence_unit = 2;
constexpr GLenum previous_unit = 1;
constexpr GLint dimension_location = 0;
constexpr GLint penalty_location = 1;
constexpr GLint steps_location = 2;

constexpr int group_width = 64;

/// Everything that lives in the context, so that it can be destroyed while the context is current.
class ComputeSweep {
public:
  explicit ComputeSweep(const Api& api)
      : gl_(api), images_{Texture(api), Texture(api)}, observation_(api), confidence_(api), counter_(api) {
    count_program_.emplace(
        api, std::initializer_list<Program::Stage>{{GL_COMPUTE_SHADER, std::string(sources::count_compute)}});
  }

  void load(const Level& level) {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    if (level.extent.width > limit || level.extent.height > limit) {
      throw DeviceError(fmt::format("the image is {} x {}, this device's textures end at {} x {}",
                                    level.extent.width, level.extent.height, limit, limit));
    }
    extent_ = level.extent;
    pixels_.resize(4 * extent_.sites());
    for (std::size_t i = 0; i < extent_.sites(); ++i) {
      pixels_[4 * i] = level.target.x[i];
      pixels_[4 * i + 1] = level.target.y[i];
      pixels_[4 * i + 2] = level.modulus.values[i];
      pixels_[4 * i + 3] = level.inverse_modulus.values[i];
    }
    allocate(observation_, GL_RGBA32F, GL_RGBA, pixels_.data());
    interleave(level.confidence);
    allocate(confidence_, GL_RG32F, GL_RG, pixels_.data());
    for (const Texture& image : images_) {
      allocate(image, GL_RG32F, GL_RG, nullptr);
    }
    prepare_program(level);
    gl_.Finish();
  }

  void write(const VectorField& displacement) {
    interleave(displacement);
    gl_.MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    gl_.BindTexture(GL_TEXTURE_2D, images_[current_].name());
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, extent_.width, extent_.height, GL_RG, GL_FLOAT, pixels_.data());
    gl_.Finish();
  }

  void step(int iterations) {
    sweep_program_->use();
    bind(observation_unit, observation_);
    bind(confidence_unit, confidence_);
    for (int i = 0; i < iterations; ++i) {
      bind(image_unit, images_[current_]);
      gl_.BindImageTexture(0, images_[1 - current_].name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32F);
      dispatch();
      gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
      current_ = 1 - current_;
    }
    gl_.Finish();
  }

  void read(VectorField& displacement) {
    gl_.MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    gl_.BindTexture(GL_TEXTURE_2D, images_[current_].name());
    gl_.GetTexImage(GL_TEXTURE_2D, 0, GL_RG, GL_FLOAT, pixels_.data());
    for (std::size_t i = 0; i < extent_.sites(); ++i) {
      displacement.x[i] = pixels_[2 * i];
      displacement.y[i] = pixels_[2 * i + 1];
    }
  }

  std::int64_t changed() {
    GLuint count = 0;
    gl_.BindBuffer(GL_ATOMIC_COUNTER_BUFFER, counter_.name());
    gl_.BufferData(GL_ATOMIC_COUNTER_BUFFER, sizeof(count), &count, GL_DYNAMIC_READ);
    gl_.BindBufferBase(GL_ATOMIC_COUNTER_BUFFER, 0, counter_.name());
    count_program_->use();
    gl_.Uniform2i(dimension_location, extent_.width, extent_.height);
    bind(image_unit, images_[current_]);
    bind(previous_unit, images_[1 - current_]);
    dispatch();
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.GetBufferSubData(GL_ATOMIC_COUNTER_BUFFER, 0, sizeof(count), &count);
    return count;
  }

private:
  void bind(GLenum unit, const Texture& texture) const {
    gl_.ActiveTexture(GL_TEXTURE0 + unit);
    gl_.BindTexture(GL_TEXTURE_2D, texture.name());
  }

  void dispatch() const {
    gl_.DispatchCompute(static_cast<GLuint>((extent_.width + group_width - 1) / group_width),
                        static_cast<GLuint>(extent_.height), 1);
  }

  void allocate(const Texture& texture, GLint internal_format, GLenum format, const GLfloat* pixels) const {
    gl_.BindTexture(GL_TEXTURE_2D, texture.name());
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, internal_format, extent_.width, extent_.height, 0, format, GL_FLOAT,
                   pixels);
  }

  void interleave(const VectorField& field) {
    for (std::size_t i = 0; i < extent_.sites(); ++i) {
      pixels_[2 * i] = field.x[i];
      pixels_[2 * i + 1] = field.y[i];
    }
  }

  void prepare_program(const Level& level) {
    if (!sweep_program_ || program_steps_ != level.steps.count()) {
      program_steps_ = level.steps.count();
      sweep_program_.emplace(gl_, std::initializer_list<Program::Stage>{
                                      {GL_COMPUTE_SHADER, assemble(sources::sweep_compute, program_steps_)}});
    }
    sweep_program_->use();
    gl_.Uniform2i(dimension_location, extent_.width, extent_.height);
    gl_.Uniform1f(penalty_location, level.penalty);
    gl_.Uniform1fv(steps_location, level.steps.count(), level.steps.padded().data());
  }

  const Api& gl_;
  std::array<Texture, 2> images_;
  Texture observation_;
  Texture confidence_;
  Buffer counter_;
  std::optional<Program> sweep_program_;
  std::optional<Program> count_program_;
  int program_steps_ = 0;
  Extent extent_;
  std::size_t current_ = 0;
  std::vector<GLfloat> pixels_; ///< interleaved staging, up to 4 floats a site
};

} // namespace

std::unique_ptr<Backend> make_compute() {
  return std::make_unique<ContextBackend<ComputeSweep>>(
      "gl-compute", "GLSL 4.30 compute shader, OpenGL through EGL", make_egl_platform(), required);
}

} // namespace hdmbench::gl
