#include "backends/gl/fragment_programs.hpp"

#include <fmt/format.h>
#include <shaders/cells_fragment.hpp>
#include <shaders/count_fragment.hpp>
#include <shaders/project_fragment.hpp>
#include <shaders/quad_vertex.hpp>
#include <shaders/sample_fragment.hpp>
#include <shaders/sweep_fragment.hpp>
#include <shaders/tiles_vertex.hpp>
#include <shaders/wake_fragment.hpp>

#include <initializer_list>
#include <utility>

namespace hdmbench::gl {

namespace {

/// A sampler and the unit it fetches from.
using Sampler = std::pair<const char*, GLint>;

/// The text with lines of definitions after the #version line.
std::string defining(std::string text, const std::string& lines) {
  text.insert(text.find('\n') + 1, lines);
  return text;
}

std::string activity(bool active) {
  return active ? "#define ACTIVE\n" : "";
}

/// Compiled now, if it is not yet.
const Program& made(const Api& gl, std::optional<Program>& program, const std::string& vertex,
                    const std::string& fragment, std::initializer_list<Sampler> samplers) {
  if (!program) {
    program.emplace(gl, std::initializer_list<Program::Stage>{{GL_VERTEX_SHADER, vertex},
                                                              {GL_FRAGMENT_SHADER, fragment}});
    try {
      program->use();
      for (const auto& [name, unit] : samplers) {
        gl.Uniform1i(program->uniform(name), unit);
      }
    } catch (...) { // half of a program must not be taken for a whole one the next time
      program.reset();
      throw;
    }
  }
  return *program;
}

} // namespace

const SweepProgram& FragmentPrograms::sweep(const FragmentLevel& level, std::size_t tile_class) {
  const Level& header = level.header;
  const Key key{
      .constants = shader_constants(header), .tile_class = tile_class, .active = level.activity.has_value()};
  auto found = sweeps_.find(key);
  if (found == sweeps_.end()) {
    found =
        sweeps_
            .try_emplace(
                key, gl_,
                std::initializer_list<Program::Stage>{
                    {GL_VERTEX_SHADER, defining(std::string(sources::tiles_vertex), activity(key.active))},
                    {GL_FRAGMENT_SHADER, sweep_fragment_text(key.constants, tile_class, key.active)}})
            .first;
  }
  const Program& program = found->second.program;
  program.use();
  gl_.Uniform1i(program.uniform("image"), image_unit);
  gl_.Uniform1i(program.uniform("observation"), observation_unit);
  gl_.Uniform1i(program.uniform("confidence"), confidence_unit);
  gl_.Uniform2f(program.uniform("dimension"), static_cast<GLfloat>(header.extent.width),
                static_cast<GLfloat>(header.extent.height));
  gl_.Uniform1f(program.uniform("penalty"), header.penalty);
  gl_.Uniform1fv(program.uniform("steps"), header.steps.count(), header.steps.padded().data());
  set_tiles(program, level);
  return found->second;
}

const Program& FragmentPrograms::cells(const FragmentLevel& level) {
  const Program& program =
      made(gl_, cells_, defining(std::string(sources::tiles_vertex), activity(true)),
           defining(std::string(sources::cells_fragment),
                    fmt::format("#define CELL {}\n",
                                FragmentLevel::tile_side / FragmentLevel::cells_along_a_tile)),
           {{"image", image_unit}});
  program.use();
  set_tiles(program, level);
  return program;
}

const Program& FragmentPrograms::wake() {
  return made(gl_, wake_, std::string(sources::quad_vertex),
              defining(std::string(sources::wake_fragment),
                       fmt::format("#define CELLS {}\n", FragmentLevel::cells_along_a_tile)),
              {{"cells", image_unit}});
}

const Program& FragmentPrograms::count() {
  return made(gl_, count_, std::string(sources::quad_vertex), std::string(sources::count_fragment),
              {{"image", image_unit}, {"previous", observation_unit}});
}

const Program& FragmentPrograms::sample() {
  return made(gl_, sample_, std::string(sources::quad_vertex), std::string(sources::sample_fragment),
              {{"full", image_unit}, {"table", table_unit}});
}

const Program& FragmentPrograms::project() {
  return made(gl_, project_, std::string(sources::quad_vertex), assemble(sources::project_fragment, ""),
              {{"coarse", image_unit}, {"observation", observation_unit}, {"table", table_unit}});
}

void FragmentPrograms::set_tiles(const Program& program, const FragmentLevel& level) const {
  gl_.Uniform2f(program.uniform("grid"), static_cast<GLfloat>(level.grid.width),
                static_cast<GLfloat>(level.grid.height));
  if (level.activity) {
    gl_.Uniform1i(program.uniform("awake"), awake_unit);
  }
}

std::string sweep_fragment_text(const ShaderConstants& constants, std::size_t tile_class, bool active) {
  const auto may_be = [&](std::size_t bit) { return (tile_class & bit) != 0; };
  return defining(assemble(sources::sweep_fragment, constants),
                  fmt::format("{}{}{}{}", may_be(tile_class::border_bit) ? "" : "#define INTERIOR\n",
                              may_be(tile_class::elastic_bit) ? "" : "#define HOMOGENEOUS\n",
                              may_be(tile_class::observed_bit) ? "" : "#define UNOBSERVED\n",
                              activity(active)));
}

} // namespace hdmbench::gl
