#include "backends/gl/ceilings.hpp"
#include "backends/gl/objects.hpp"
#include "backends/shared/ceiling_shaders.hpp"

#include <shaders/ceiling_copy.hpp>
#include <shaders/ceiling_multiply_add.hpp>

#include <algorithm>
#include <bit>

namespace hdmbench::gl {

namespace {

constexpr GLuint group_size = 64; // local_size_x of the shaders

class Loops {
public:
  explicit Loops(const Api& api)
      : gl_(api), source_buffer_(api), target_buffer_(api), source_(api), target_(api),
        copy_(api, {{GL_COMPUTE_SHADER, std::string(sources::ceiling_copy)}}),
        multiply_add_(api, {{GL_COMPUTE_SHADER, std::string(sources::ceiling_multiply_add)}}) {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    texels_ = std::min(bytes_to_copy() / ceiling_shaders::texel_bytes,
                       std::bit_floor(static_cast<std::size_t>(limit)));
    if (texels_ < ceiling_shaders::texels) {
      throw TooLarge("buffer textures end at 65536 texels or little more");
    }
    given_ = ceiling_shaders::source(texels_);
    allocate(target_buffer_, target_, nullptr);
    allocate(source_buffer_, source_, given_.data());
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_BUFFER, source_.name());
    gl_.BindImageTexture(1, target_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  }

  [[nodiscard]] Ceilings measure() const {
    Ceilings ceilings;
    const double bytes = 2.0 * static_cast<double>(texels_ * ceiling_shaders::texel_bytes);
    ceilings.copy_bytes_per_second = sample_rates(bytes, [&](int times) { run(copy_, texels_, times); });
    ceiling_shaders::require_copied(given_, result(texels_));
    ceilings.operations_per_second = sample_rates(ceiling_shaders::operations(), [&](int times) {
      run(multiply_add_, ceiling_shaders::texels, times);
    });
    ceiling_shaders::require_computed(given_, result(ceiling_shaders::texels));
    return ceilings;
  }

private:
  void allocate(const Buffer& buffer, const Texture& texture, const GLfloat* texels) const {
    gl_.BindBuffer(GL_TEXTURE_BUFFER, buffer.name());
    gl_.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(texels_ * ceiling_shaders::texel_bytes), texels,
                   GL_DYNAMIC_COPY);
    gl_.BindTexture(GL_TEXTURE_BUFFER, texture.name());
    gl_.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, buffer.name());
  }

  void run(const Program& program, std::size_t texels, int times) const {
    constexpr GLuint groups_across = 1024;
    program.use();
    for (int i = 0; i < times; ++i) {
      gl_.DispatchCompute(groups_across, static_cast<GLuint>(texels) / group_size / groups_across, 1);
      gl_.MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
    gl_.Finish();
  }

  [[nodiscard]] std::vector<GLfloat> result(std::size_t texels) const {
    std::vector<GLfloat> values(4 * texels);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.BindBuffer(GL_TEXTURE_BUFFER, target_buffer_.name());
    gl_.GetBufferSubData(GL_TEXTURE_BUFFER, 0, static_cast<GLsizeiptr>(4 * texels * sizeof(GLfloat)),
                         values.data());
    return values;
  }

  const Api& gl_;
  Buffer source_buffer_;
  Buffer target_buffer_;
  Texture source_;
  Texture target_;
  Program copy_;
  Program multiply_add_;
  std::size_t texels_ = 0;
  std::vector<GLfloat> given_;
};

} // namespace

Ceilings compute_ceilings(const Api& api) {
  return Loops(api).measure();
}

} // namespace hdmbench::gl
