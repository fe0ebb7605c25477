#include "backends/gl/coarse_levels.hpp"

#include "backends/coarse_levels.hpp"
#include "backends/gl/interleave.hpp"
#include "backends/resampling_entries.hpp"

#include <fmt/format.h>
#include <shaders/coarse_levels_compute.hpp>

namespace hdmbench::gl {

namespace {

/// As in the shader's layout(binding = ..., location = ...).
constexpr GLenum entries_unit = 0;
constexpr GLenum material_unit = 1;
constexpr GLenum observation_unit = 2;
constexpr GLuint displacement_unit = 0;
constexpr GLint levels_location = 0;
constexpr GLint full_width_location = 1;
constexpr GLint penalty_location = 2;
constexpr GLint steps_location = 3;

} // namespace

const Program& CoarseLevels::program(const Variant& variant) {
  auto found = programs_.find(variant);
  if (found == programs_.end()) {
    const std::string text =
        assemble(sources::coarse_levels_compute,
                 fmt::format("#define INVOCATIONS {}\n#define STEP_COUNT {}\n#define STOPS_AT_REST {}\n",
                             variant.invocations, variant.step_count, variant.stops_at_rest));
    found =
        programs_.try_emplace(variant, gl_, std::initializer_list<Program::Stage>{{GL_COMPUTE_SHADER, text}})
            .first;
  }
  return found->second;
}

void CoarseLevels::load(const Pyramid& pyramid, int group, bool stops_at_rest) {
  count_ = group > 0 ? coarse_level_count(pyramid, group) : 0;
  extent_ = {};
  site_updates_ = 0.0;
  if (count_ == 0) {
    return;
  }
  const Level& full = *pyramid.full;
  const ResamplingEntries entries(pyramid);
  std::vector<GLfloat> texels;
  interleave<4>({entries.planes[0].data(), entries.planes[1].data(), entries.planes[2].data(),
                 entries.planes[3].data()},
                entries.count(), texels);
  entries_.allocate(GL_RGBA32F, texels.size() * sizeof(GLfloat), texels.data());
  program_ =
      &program({.invocations = group, .step_count = full.steps.count(), .stops_at_rest = stops_at_rest});
  extent_ = pyramid.levels[count_ - 1].extent;
  site_updates_ = coarse_site_updates(pyramid, count_);
  levels_begin_ = entries.levels_begin;
  full_width_ = full.extent.width;
  penalty_ = full.penalty;
  steps_ = full.steps.padded();
}

void CoarseLevels::solve(const BufferTexture& material, const BufferTexture& observation,
                         const BufferTexture& displacement) const {
  program_->use();
  gl_.Uniform2i(levels_location, levels_begin_, static_cast<GLint>(count_));
  gl_.Uniform1i(full_width_location, full_width_);
  gl_.Uniform1f(penalty_location, penalty_);
  gl_.Uniform1fv(steps_location, static_cast<GLsizei>(steps_.size()), steps_.data());
  entries_.bind(entries_unit);
  material.bind(material_unit);
  observation.bind(observation_unit);
  displacement.bind_image(displacement_unit, GL_RG32F);
  gl_.DispatchCompute(1, 1, 1);
  gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

} // namespace hdmbench::gl
