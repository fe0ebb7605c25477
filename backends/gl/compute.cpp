#include "backends/gl/compute.hpp"

#include "backends/gl/ceilings.hpp"
#include "backends/gl/context_session.hpp"
#include "backends/gl/interleave.hpp"
#include "backends/gl/objects.hpp"

#include <fmt/format.h>
#include <shaders/count_compute.hpp>
#include <shaders/sweep_compute.hpp>

#include <array>
#include <span>

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

/// A buffer that shaders read as a texture of one row.
class BufferTexture {
public:
  explicit BufferTexture(const Api& api) : gl_(api), buffer_(api), texture_(api) {}

  /// `bytes` of texels of `format`; uninitialised where data is null.
  void allocate(GLenum format, std::size_t bytes, const GLfloat* data) const {
    gl_.BindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    gl_.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_COPY);
    gl_.BindTexture(GL_TEXTURE_BUFFER, texture_.name());
    gl_.TexBuffer(GL_TEXTURE_BUFFER, format, buffer_.name());
  }
  void write(std::span<const GLfloat> data) const {
    gl_.BindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    gl_.BufferSubData(GL_TEXTURE_BUFFER, 0, static_cast<GLsizeiptr>(data.size_bytes()), data.data());
  }
  void read(std::span<GLfloat> data) const {
    gl_.BindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    gl_.GetBufferSubData(GL_TEXTURE_BUFFER, 0, static_cast<GLsizeiptr>(data.size_bytes()), data.data());
  }
  void bind(GLenum unit) const {
    gl_.ActiveTexture(GL_TEXTURE0 + unit);
    gl_.BindTexture(GL_TEXTURE_BUFFER, texture_.name());
  }
  [[nodiscard]] GLuint texture() const { return texture_.name(); }

private:
  const Api& gl_;
  Buffer buffer_;
  Texture texture_;
};

/// Everything that lives in the context, so that it can be destroyed while the context is current.
class ComputeSweep {
public:
  /// Displacement there and back, observation, confidence.
  static constexpr double bytes_per_update = 8 + 8 + 16 + 8;
  static Ceilings ceilings(const Api& api) { return compute_ceilings(api); }

  explicit ComputeSweep(const Api& api)
      : gl_(api), images_{BufferTexture(api), BufferTexture(api)}, observation_(api), confidence_(api),
        counter_(api), count_program_(api, {{GL_COMPUTE_SHADER, std::string(sources::count_compute)}}) {}

  void load(const Level& level) {
    require_room(level.extent);
    extent_ = level.extent;
    const std::size_t sites = extent_.sites();
    interleave<4>({level.target.x.data(), level.target.y.data(), level.modulus.values.data(),
                   level.inverse_modulus.values.data()},
                  sites, texels_);
    observation_.allocate(GL_RGBA32F, 4 * sites * sizeof(GLfloat), texels_.data());
    if (needs_inverse_curvature(level.rule)) {
      interleave<4>({level.confidence.x.data(), level.confidence.y.data(), level.inverse_curvature.x.data(),
                     level.inverse_curvature.y.data()},
                    sites, texels_);
      confidence_.allocate(GL_RGBA32F, 4 * sites * sizeof(GLfloat), texels_.data());
    } else {
      interleave<2>({level.confidence.x.data(), level.confidence.y.data()}, sites, texels_);
      confidence_.allocate(GL_RG32F, 2 * sites * sizeof(GLfloat), texels_.data());
    }
    for (const BufferTexture& image : images_) {
      image.allocate(GL_RG32F, 2 * sites * sizeof(GLfloat), nullptr);
    }
    level_ = without_fields(level);
    prepare_program(level);
    gl_.Finish();
  }

  void write(const VectorField& displacement) {
    interleave<2>({displacement.x.data(), displacement.y.data()}, extent_.sites(), texels_);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    images_[current_].write(texels_);
    gl_.Finish();
  }

  void step(int first, int sweeps) {
    sweep_->program.use();
    observation_.bind(observation_unit);
    confidence_.bind(confidence_unit);
    for (int number = first; number < first + sweeps; ++number) {
      sweep_->set_turn(gl_, sweep_state(level_, number));
      images_[current_].bind(image_unit);
      gl_.BindImageTexture(0, images_[1 - current_].texture(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32F);
      dispatch();
      gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
      current_ = 1 - current_;
    }
    gl_.Finish();
  }

  void read(VectorField& displacement) {
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    texels_.resize(2 * extent_.sites());
    images_[current_].read(texels_);
    for (std::size_t i = 0; i < extent_.sites(); ++i) {
      displacement.x[i] = texels_[2 * i];
      displacement.y[i] = texels_[2 * i + 1];
    }
  }

  std::int64_t changed() {
    GLuint count = 0;
    gl_.BindBuffer(GL_ATOMIC_COUNTER_BUFFER, counter_.name());
    gl_.BufferData(GL_ATOMIC_COUNTER_BUFFER, sizeof(count), &count, GL_DYNAMIC_READ);
    gl_.BindBufferBase(GL_ATOMIC_COUNTER_BUFFER, 0, counter_.name());
    count_program_.use();
    gl_.Uniform2i(dimension_location, extent_.width, extent_.height);
    images_[current_].bind(image_unit);
    images_[1 - current_].bind(previous_unit);
    dispatch();
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.GetBufferSubData(GL_ATOMIC_COUNTER_BUFFER, 0, sizeof(count), &count);
    return count;
  }

private:
  void require_room(Extent extent) const {
    GLint texels = 0;
    gl_.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    // The number of groups along y; core OpenGL guarantees 65535 and has no query without an index.
    constexpr int largest_height = 65535;
    if (extent.sites() > static_cast<std::size_t>(texels) || extent.height > largest_height) {
      throw TooLarge(
          fmt::format("the image is {} x {}, this device's buffer textures end at {} sites and {} rows",
                      extent.width, extent.height, texels, largest_height));
    }
  }

  void dispatch() const {
    gl_.DispatchCompute(static_cast<GLuint>((extent_.width + group_width - 1) / group_width),
                        static_cast<GLuint>(extent_.height), 1);
  }

  void prepare_program(const Level& level) {
    const ShaderConstants constants = shader_constants(level);
    auto found = programs_.find(constants);
    if (found == programs_.end()) {
      found = programs_
                  .try_emplace(constants, gl_,
                               std::initializer_list<Program::Stage>{
                                   {GL_COMPUTE_SHADER, assemble(sources::sweep_compute, constants)}})
                  .first;
    }
    sweep_ = &found->second;
    sweep_->program.use();
    gl_.Uniform2i(dimension_location, extent_.width, extent_.height);
    gl_.Uniform1f(penalty_location, level.penalty);
    gl_.Uniform1fv(steps_location, level.steps.count(), level.steps.padded().data());
  }

  const Api& gl_;
  std::array<BufferTexture, 2> images_;
  BufferTexture observation_;
  BufferTexture confidence_;
  Buffer counter_;
  Program count_program_;
  SweepPrograms programs_;
  const SweepProgram* sweep_ = nullptr; ///< of the level, one of programs_
  Level level_;                         ///< without its fields
  Extent extent_;
  std::size_t current_ = 0;
  std::vector<GLfloat> texels_; ///< interleaved staging, as long as what was uploaded or read last
};

} // namespace

std::unique_ptr<Backend> make_compute(std::unique_ptr<Platform> platform) {
  return std::make_unique<ContextBackend<ComputeSweep>>(
      "gl-compute", "GLSL 4.30 compute shader, OpenGL through EGL", std::move(platform), required);
}

} // namespace hdmbench::gl
