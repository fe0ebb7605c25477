#include "backends/gl/arithmetic.hpp"
#include "backends/gl/buffer_texture.hpp"

#include <shaders/probe_compute.hpp>

namespace hdmbench::gl {

std::vector<float> evaluate_in_compute(const Api& api, std::span<const ArithmeticCase> cases) {
  const Program program(api, {{GL_COMPUTE_SHADER, assemble(sources::probe_compute, "")}});
  const BufferTexture source(api);
  const BufferTexture target(api);
  source.allocate(GL_RGBA32F, cases.size_bytes(), cases.front().data());
  target.allocate(GL_RGBA32F, cases.size_bytes() / 2, nullptr);
  source.bind(0);
  target.bind_image(1, GL_RGBA32F);
  program.use();
  api.DispatchCompute(static_cast<GLuint>(cases.size() / cases_at_once), 1, 1);
  api.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::vector<GLfloat> texels(4 * cases.size());
  target.read(texels);
  std::vector<float> results;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    results.push_back(texels[4 * i]);
  }
  return results;
}

} // namespace hdmbench::gl
