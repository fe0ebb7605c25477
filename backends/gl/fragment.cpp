#include "backends/gl/fragment.hpp"

#include "backends/gl/ceilings.hpp"
#include "backends/gl/context_session.hpp"
#include "backends/gl/interleave.hpp"
#include "backends/gl/objects.hpp"

#include <fmt/format.h>
#include <shaders/count_fragment.hpp>
#include <shaders/quad_vertex.hpp>
#include <shaders/sweep_fragment.hpp>

#include <array>
#include <optional>

namespace hdmbench::gl {

namespace {

constexpr Version required{2, 1};

/// Texture units of the samplers.
constexpr GLint image_unit = 0;
constexpr GLint observation_unit = 1;
constexpr GLint confidence_unit = 2;

/// Everything that lives in the context, so that it can be destroyed while the context is current.
class FragmentSweep {
public:
  /// Four textures of four floats: image there and back, observation, confidence.
  static constexpr double bytes_per_update = 4 * 16;
  static Ceilings ceilings(const Api& api) { return fragment_ceilings(api); }

  explicit FragmentSweep(const Api& api)
      : gl_(api), images_{Texture(api), Texture(api)}, observation_(api),
        confidence_(api), framebuffers_{Framebuffer(api), Framebuffer(api)}, count_framebuffer_(api),
        count_target_(api), query_(api), quad_(api) {
    static constexpr std::array<GLfloat, 8> corners{-1, -1, 1, -1, -1, 1, 1, 1};
    gl_.BindBuffer(GL_ARRAY_BUFFER, quad_.name());
    gl_.BufferData(GL_ARRAY_BUFFER, sizeof(corners), corners.data(), GL_STATIC_DRAW);
    gl_.EnableVertexAttribArray(0);
    gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
    count_program_.emplace(api, std::initializer_list<Program::Stage>{
                                    {GL_VERTEX_SHADER, std::string(sources::quad_vertex)},
                                    {GL_FRAGMENT_SHADER, std::string(sources::count_fragment)}});
    count_program_->use();
    gl_.Uniform1i(count_program_->uniform("image"), image_unit);
    gl_.Uniform1i(count_program_->uniform("previous"), observation_unit);
  }

  void load(const Level& level) {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB, &limit);
    if (level.extent.width > limit || level.extent.height > limit) {
      throw TooLarge(fmt::format("the image is {} x {}, this device's rectangle textures end at {} x {}",
                                 level.extent.width, level.extent.height, limit, limit));
    }
    extent_ = level.extent;
    interleave<4>({level.target.x.data(), level.target.y.data(), level.modulus.values.data(), nullptr},
                  extent_.sites(), pixels_);
    allocate(observation_, pixels_.data());
    const bool curvature = needs_inverse_curvature(level.rule);
    interleave<4>({level.confidence.x.data(), level.confidence.y.data(),
                   curvature ? level.inverse_curvature.x.data() : nullptr,
                   curvature ? level.inverse_curvature.y.data() : nullptr},
                  extent_.sites(), pixels_);
    allocate(confidence_, pixels_.data());
    inverse_modulus_ = level.inverse_modulus.values;
    level_ = without_fields(level);
    for (std::size_t i = 0; i < 2; ++i) {
      allocate(images_[i], nullptr);
      gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffers_[i].name());
      gl_.FramebufferTexture2DEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_TEXTURE_RECTANGLE_ARB,
                                  images_[i].name(), 0);
      require_complete();
    }
    gl_.BindRenderbufferEXT(GL_RENDERBUFFER_EXT, count_target_.name());
    gl_.RenderbufferStorageEXT(GL_RENDERBUFFER_EXT, GL_RGBA8, extent_.width, extent_.height);
    gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, count_framebuffer_.name());
    gl_.FramebufferRenderbufferEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_RENDERBUFFER_EXT,
                                   count_target_.name());
    require_complete();
    prepare_program(level);
    gl_.Viewport(0, 0, extent_.width, extent_.height);
    gl_.Finish();
  }

  void write(const VectorField& displacement) {
    // b is what thesis Tab. 6.2 leaves free.
    interleave<4>({displacement.x.data(), displacement.y.data(), inverse_modulus_.data(), nullptr},
                  extent_.sites(), pixels_);
    gl_.BindTexture(GL_TEXTURE_RECTANGLE_ARB, images_[current_].name());
    gl_.TexSubImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, 0, 0, extent_.width, extent_.height, GL_RGBA, GL_FLOAT,
                      pixels_.data());
    gl_.Finish();
  }

  void step(int first, int sweeps) {
    sweep_->program.use();
    bind(observation_unit, observation_);
    bind(confidence_unit, confidence_);
    for (int number = first; number < first + sweeps; ++number) {
      sweep_->set_turn(gl_, sweep_state(level_, number));
      bind(image_unit, images_[current_]);
      gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffers_[1 - current_].name());
      gl_.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
      current_ = 1 - current_;
    }
    gl_.Finish();
  }

  void read(VectorField& displacement) {
    gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffers_[current_].name());
    gl_.ReadPixels(0, 0, extent_.width, extent_.height, GL_RGBA, GL_FLOAT, pixels_.data());
    for (std::size_t i = 0; i < extent_.sites(); ++i) {
      displacement.x[i] = pixels_[4 * i];
      displacement.y[i] = pixels_[4 * i + 1];
    }
  }

  std::int64_t changed() {
    count_program_->use();
    bind(image_unit, images_[current_]);
    bind(observation_unit, images_[1 - current_]);
    gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, count_framebuffer_.name());
    gl_.BeginQuery(GL_SAMPLES_PASSED, query_.name());
    gl_.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    gl_.EndQuery(GL_SAMPLES_PASSED);
    GLuint passed = 0;
    gl_.GetQueryObjectuiv(query_.name(), GL_QUERY_RESULT, &passed);
    return passed;
  }

private:
  void bind(GLint unit, const Texture& texture) const {
    gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl_.BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture.name());
  }

  void allocate(const Texture& texture, const GLfloat* pixels) const {
    gl_.BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture.name());
    gl_.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl_.TexImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, GL_RGBA32F_ARB, extent_.width, extent_.height, 0, GL_RGBA,
                   GL_FLOAT, pixels);
  }

  void require_complete() const {
    const GLenum status = gl_.CheckFramebufferStatusEXT(GL_FRAMEBUFFER_EXT);
    if (status != GL_FRAMEBUFFER_COMPLETE_EXT) {
      throw DeviceError(fmt::format(
          "glCheckFramebufferStatusEXT: 0x{:04x} (this driver cannot render to float rectangle textures)",
          status));
    }
  }

  void prepare_program(const Level& level) {
    const ShaderConstants constants = shader_constants(level);
    auto found = programs_.find(constants);
    if (found == programs_.end()) {
      found = programs_
                  .try_emplace(constants, gl_,
                               std::initializer_list<Program::Stage>{
                                   {GL_VERTEX_SHADER, std::string(sources::quad_vertex)},
                                   {GL_FRAGMENT_SHADER, assemble(sources::sweep_fragment, constants)}})
                  .first;
    }
    sweep_ = &found->second;
    const Program& program = sweep_->program;
    program.use();
    gl_.Uniform1i(program.uniform("image"), image_unit);
    gl_.Uniform1i(program.uniform("observation"), observation_unit);
    gl_.Uniform1i(program.uniform("confidence"), confidence_unit);
    gl_.Uniform2f(program.uniform("dimension"), static_cast<GLfloat>(extent_.width),
                  static_cast<GLfloat>(extent_.height));
    gl_.Uniform1f(program.uniform("penalty"), level.penalty);
    gl_.Uniform1fv(program.uniform("steps"), level.steps.count(), level.steps.padded().data());
  }

  const Api& gl_;
  std::array<Texture, 2> images_;
  Texture observation_;
  Texture confidence_;
  std::array<Framebuffer, 2> framebuffers_;
  Framebuffer count_framebuffer_;
  Renderbuffer count_target_;
  Query query_;
  Buffer quad_;
  SweepPrograms programs_;
  const SweepProgram* sweep_ = nullptr; ///< of the level, one of programs_
  std::optional<Program> count_program_;
  Level level_; ///< without its fields
  Extent extent_;
  std::size_t current_ = 0;
  std::vector<float> inverse_modulus_;
  std::vector<GLfloat> pixels_; ///< RGBA staging
};

} // namespace

std::unique_ptr<Backend> make_fragment(std::string_view name, std::string_view description,
                                       std::unique_ptr<Platform> platform) {
  return std::make_unique<ContextBackend<FragmentSweep>>(name, description, std::move(platform), required);
}

} // namespace hdmbench::gl
