#include "backends/gl/arithmetic.hpp"
#include "backends/gl/objects.hpp"

#include <shaders/probe_fragment.hpp>
#include <shaders/quad_vertex.hpp>

namespace hdmbench::gl {

namespace {

void allocate(const Api& gl, const Texture& texture, GLsizei width, GLsizei height, const GLfloat* texels) {
  gl.BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture.name());
  gl.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, GL_RGBA32F_ARB, width, height, 0, GL_RGBA, GL_FLOAT, texels);
}

} // namespace

std::vector<float> evaluate_in_fragments(const Api& api, std::span<const ArithmeticCase> cases) {
  const auto width = static_cast<GLsizei>(cases_at_once);
  const auto height = static_cast<GLsizei>(cases.size() / cases_at_once);
  const Program program(api, {{GL_VERTEX_SHADER, std::string(sources::quad_vertex)},
                              {GL_FRAGMENT_SHADER, assemble(sources::probe_fragment, "")}});
  const Buffer quad(api);
  static constexpr std::array<GLfloat, 8> corners{-1, -1, 1, -1, -1, 1, 1, 1};
  api.BindBuffer(GL_ARRAY_BUFFER, quad.name());
  api.BufferData(GL_ARRAY_BUFFER, sizeof(corners), corners.data(), GL_STATIC_DRAW);
  api.EnableVertexAttribArray(0);
  api.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);

  const Texture target(api);
  const Framebuffer framebuffer(api);
  allocate(api, target, width, height, nullptr);
  api.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffer.name());
  api.FramebufferTexture2DEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_TEXTURE_RECTANGLE_ARB,
                              target.name(), 0);
  if (api.CheckFramebufferStatusEXT(GL_FRAMEBUFFER_EXT) != GL_FRAMEBUFFER_COMPLETE_EXT) {
    throw DeviceError("glCheckFramebufferStatusEXT: cannot render to float rectangle textures");
  }
  const Texture source(api);
  allocate(api, source, 2 * width, height, cases.front().data()); // stays bound
  program.use();
  api.Viewport(0, 0, width, height);
  api.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  std::vector<GLfloat> texels(4 * cases.size());
  api.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, texels.data());
  std::vector<float> results;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    results.push_back(texels[4 * i]);
  }
  return results;
}

} // namespace hdmbench::gl
