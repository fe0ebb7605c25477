#include "backends/gl/coarse_levels.hpp"

#include "backends/shared/coarse_levels.hpp"

#include <fmt/format.h>
#include <shaders/coarse_levels_compute.hpp>

namespace hdmbench::gl {

namespace {

/// Of the shader's parameters.
constexpr GLint steps_location = 0;
constexpr GLint penalty_location = 16;
constexpr GLint full_width_location = 17;
constexpr GLint first_level_location = 18;
constexpr GLint level_count_location = 19;

} // namespace

const Program& CoarseLevels::program(const Variant& variant) {
  auto found = programs_.find(variant);
  if (found == programs_.end()) {
    const std::string text =
        assemble(sources::coarse_levels_compute,
                 fmt::format("#define INVOCATIONS {}\n#define STEP_COUNT {}\n#define STOPS_AT_REST {}\n",
                             variant.invocations, variant.step_count, variant.stops_at_rest),
                 *variant.energy);
    found =
        programs_.try_emplace(variant, gl_, std::initializer_list<Program::Stage>{{GL_COMPUTE_SHADER, text}})
            .first;
  }
  return found->second;
}

void CoarseLevels::load(const Pyramid& pyramid, const ResamplingEntries& entries, int group,
                        bool stops_at_rest) {
  count_ = group > 0 ? coarse_level_count(pyramid, group) : 0;
  extent_ = {};
  site_updates_ = 0.0;
  if (count_ == 0) {
    return;
  }
  const Level& full = *pyramid.full;
  program_ = &program({.energy = full.energy,
                       .invocations = group,
                       .step_count = full.steps.count(),
                       .stops_at_rest = stops_at_rest});
  extent_ = pyramid.levels[count_ - 1].extent;
  site_updates_ = coarse_site_updates(pyramid, count_);
  levels_begin_ = entries.levels_begin;
  full_width_ = full.extent.width;
  penalty_ = full.penalty;
  steps_ = full.steps.padded();
}

void CoarseLevels::solve() const {
  program_->use();
  gl_.Uniform1i(first_level_location, levels_begin_);
  gl_.Uniform1i(level_count_location, static_cast<GLint>(count_));
  gl_.Uniform1i(full_width_location, full_width_);
  gl_.Uniform1f(penalty_location, penalty_);
  gl_.Uniform1fv(steps_location, static_cast<GLsizei>(steps_.size()), steps_.data());
  gl_.DispatchCompute(1, 1, 1);
  gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

} // namespace hdmbench::gl
