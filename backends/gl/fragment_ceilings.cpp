#include "backends/gl/ceilings.hpp"
#include "backends/gl/objects.hpp"
#include "backends/shared/ceiling_shaders.hpp"

#include <algorithm>
#include <array>

namespace hdmbench::gl {

namespace {

constexpr const char* vertex_shader = R"(#version 120
attribute vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }
)";

constexpr const char* copy_shader = R"(#version 120
#extension GL_ARB_texture_rectangle : require
uniform sampler2DRect source;
void main() { gl_FragColor = texture2DRect(source, gl_FragCoord.xy); }
)";

// ceiling_multiply_add.comp for fragments.
constexpr const char* multiply_add_shader = R"(#version 120
#extension GL_ARB_texture_rectangle : require
uniform sampler2DRect source;
#define ROUND a = a * factor + term; b = b * factor + term; c = c * factor + term;
void main() {
  vec4 given = texture2DRect(source, gl_FragCoord.xy);
  float factor = given.z;
  float term = given.w;
  vec4 a = given.x + vec4(0.0, 1.0, 2.0, 3.0);
  vec4 b = given.x + vec4(4.0, 5.0, 6.0, 7.0);
  vec4 c = given.x + vec4(8.0, 9.0, 10.0, 11.0);
  for (int i = 0; i < 64; ++i) {
    ROUND ROUND ROUND ROUND ROUND ROUND ROUND ROUND
  }
  ROUND
  gl_FragColor = a + b + c;
}
)";

/// A float rectangle texture.
struct Size {
  GLsizei width;
  GLsizei height;

  [[nodiscard]] std::size_t texels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

class Loops {
public:
  explicit Loops(const Api& api)
      : gl_(api),
        source_(api), targets_{Texture(api), Texture(api)}, framebuffers_{Framebuffer(api), Framebuffer(api)},
        quad_(api), copy_(api, {{GL_VERTEX_SHADER, vertex_shader}, {GL_FRAGMENT_SHADER, copy_shader}}),
        multiply_add_(api, {{GL_VERTEX_SHADER, vertex_shader}, {GL_FRAGMENT_SHADER, multiply_add_shader}}) {
    static constexpr std::array<GLfloat, 8> corners{-1, -1, 1, -1, -1, 1, 1, 1};
    gl_.BindBuffer(GL_ARRAY_BUFFER, quad_.name());
    gl_.BufferData(GL_ARRAY_BUFFER, sizeof(corners), corners.data(), GL_STATIC_DRAW);
    gl_.EnableVertexAttribArray(0);
    gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB, &limit);
    size_.width = std::min(4096, limit);
    size_.height = std::min(static_cast<GLsizei>(bytes_to_copy() / ceiling_shaders::texel_bytes /
                                                 static_cast<std::size_t>(size_.width)),
                            limit);
    given_ = ceiling_shaders::source(size_.texels());
    found_.resize(given_.size());
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      allocate(targets_[i], nullptr);
      gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffers_[i].name());
      gl_.FramebufferTexture2DEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_TEXTURE_RECTANGLE_ARB,
                                  targets_[i].name(), 0);
      if (gl_.CheckFramebufferStatusEXT(GL_FRAMEBUFFER_EXT) != GL_FRAMEBUFFER_COMPLETE_EXT) {
        throw DeviceError("glCheckFramebufferStatusEXT: cannot render to float rectangle textures");
      }
    }
    allocate(source_, given_.data()); // stays bound
  }

  [[nodiscard]] Ceilings measure() {
    Ceilings ceilings;
    const double bytes = 2.0 * static_cast<double>(given_.size() * sizeof(GLfloat));
    ceilings.copy_bytes_per_second = sample_rates(bytes, [&](int times) { draw(copy_, size_, times); });
    ceiling_shaders::require_copied(given_, result(size_));
    const Size part{512, static_cast<GLsizei>(ceiling_shaders::texels / 512)};
    ceilings.operations_per_second =
        sample_rates(ceiling_shaders::operations(), [&](int times) { draw(multiply_add_, part, times); });
    // Row by row as the texture has them: the values are those of whole rows of size_.
    const std::span<const GLfloat> computed = result(part);
    for (GLsizei row = 0; row < part.height; ++row) {
      const std::size_t length = 4 * static_cast<std::size_t>(part.width);
      ceiling_shaders::require_computed(
          std::span<const GLfloat>(given_).subspan(
              4 * static_cast<std::size_t>(row) * static_cast<std::size_t>(size_.width), length),
          computed.subspan(static_cast<std::size_t>(row) * length, length));
    }
    return ceilings;
  }

private:
  void allocate(const Texture& texture, const GLfloat* texels) const {
    gl_.BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture.name());
    gl_.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl_.TexImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, GL_RGBA32F_ARB, size_.width, size_.height, 0, GL_RGBA,
                   GL_FLOAT, texels);
  }

  /// Into both targets in turn, as sweeps are: of several opaque drawings into one, a driver that draws tile
  /// by tile does only the last.
  void draw(const Program& program, Size size, int times) const {
    program.use();
    gl_.Viewport(0, 0, size.width, size.height);
    for (int i = 0; i < times; ++i) {
      gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffers_[static_cast<std::size_t>(i % 2)].name());
      gl_.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    }
    gl_.Finish();
  }

  [[nodiscard]] std::span<const GLfloat> result(Size size) {
    gl_.ReadPixels(0, 0, size.width, size.height, GL_RGBA, GL_FLOAT, found_.data());
    return std::span<const GLfloat>(found_).first(4 * size.texels());
  }

  const Api& gl_;
  Texture source_;
  std::array<Texture, 2> targets_;
  std::array<Framebuffer, 2> framebuffers_;
  Buffer quad_;
  Program copy_;
  Program multiply_add_;
  Size size_{};
  std::vector<GLfloat> given_;
  std::vector<GLfloat> found_;
};

} // namespace

Ceilings fragment_ceilings(const Api& api) {
  return Loops(api).measure();
}

} // namespace hdmbench::gl
