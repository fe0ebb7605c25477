#include "backends/gl/fragment_programs.hpp"

#include <fmt/format.h>
#include <shaders/cells_fragment.hpp>
#include <shaders/count_fragment.hpp>
#include <shaders/project_fragment.hpp>
#include <shaders/quad_vertex.hpp>
#include <shaders/sample_fragment.hpp>
#include <shaders/sweep_fragment.hpp>
#include <shaders/sweep_pairs_fragment.hpp>
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

/// tiles.vert for points of `side` texels.
std::string tiles_text(int side, bool active) {
  return defining(std::string(sources::tiles_vertex),
                  fmt::format("#define POINTS {}\n{}", FragmentLevel::tile_side / side,
                              active ? "#define ACTIVE\n" : ""));
}

/// What programs of tiles of a class may take for granted.
std::string class_definitions(std::size_t tile_class) {
  const auto may_be = [&](std::size_t bit) { return (tile_class & bit) != 0; };
  return fmt::format("{}{}{}", may_be(tile_class::border_bit) ? "" : "#define INTERIOR\n",
                     may_be(tile_class::elastic_bit) ? "" : "#define HOMOGENEOUS\n",
                     may_be(tile_class::observed_bit) ? "" : "#define UNOBSERVED\n");
}

std::string pairs_definition(Texels texels) {
  return texels.columns == 2 ? "#define PAIRS\n" : "";
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

const SweepProgram& FragmentPrograms::sweep(const FragmentLevel& level, const FragmentLevel::Draw& draw) {
  const Level& header = level.header;
  Key key{.constants = shader_constants(header),
          .tile_class = draw.tile_class,
          .active = level.activity.has_value()};
  if (level.texels.columns == 2) {
    key.steps = header.steps.padded();
  }
  auto found = sweeps_.find(key);
  if (found == sweeps_.end()) {
    const std::string text = key.steps ? sweep_pairs_text(key.constants, *key.steps, draw.tile_class)
                                       : sweep_text(key.constants, draw.tile_class);
    found = sweeps_
                .try_emplace(
                    key, gl_,
                    std::initializer_list<Program::Stage>{
                        {GL_VERTEX_SHADER, tiles_text(draw.side, key.active)}, {GL_FRAGMENT_SHADER, text}})
                .first;
  }
  const Program& program = found->second.program;
  program.use();
  gl_.Uniform1i(program.uniform("image"), image_unit);
  gl_.Uniform1i(program.uniform("observation"), observation_unit);
  gl_.Uniform1i(program.uniform(key.steps ? "material" : "confidence"), second_unit);
  gl_.Uniform1i(program.uniform("inputs"), inputs_unit); // -1, ignored, where the energy has none
  gl_.Uniform2f(program.uniform("dimension"), static_cast<GLfloat>(header.extent.width),
                static_cast<GLfloat>(header.extent.height));
  gl_.Uniform1f(program.uniform("penalty"), header.penalty);
  if (!key.steps) {
    gl_.Uniform1fv(program.uniform("steps"), header.steps.count(), header.steps.padded().data());
  }
  set_tiles(program, level);
  return found->second;
}

const Program& FragmentPrograms::cells(const FragmentLevel& level) {
  const Program& program =
      made(gl_, cells_, tiles_text(FragmentLevel::tile_side, true),
           defining(std::string(sources::cells_fragment),
                    fmt::format("#define CELL {}\n",
                                FragmentLevel::tile_side / FragmentLevel::cells_along_a_tile)),
           {{"image", image_unit}, {"previous", previous_unit}});
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

const Program& FragmentPrograms::count(Texels texels) {
  return made(gl_, count_.at(static_cast<std::size_t>(texels.columns - 1)), std::string(sources::quad_vertex),
              assemble(sources::count_fragment, pairs_definition(texels)),
              {{"image", image_unit}, {"previous", previous_unit}});
}

const Program& FragmentPrograms::sample(Texels texels) {
  return made(gl_, sample_.at(static_cast<std::size_t>(texels.columns - 1)),
              std::string(sources::quad_vertex), assemble(sources::sample_fragment, pairs_definition(texels)),
              {{"full", image_unit}, {"table", table_unit}});
}

const Program& FragmentPrograms::project(Texels texels) {
  return made(gl_, project_.at(static_cast<std::size_t>(texels.columns - 1)),
              std::string(sources::quad_vertex),
              assemble(sources::project_fragment, pairs_definition(texels)),
              {{"coarse", image_unit}, {"observation", observation_unit}, {"table", table_unit}});
}

void FragmentPrograms::set_tiles(const Program& program, const FragmentLevel& level) const {
  gl_.Uniform2f(program.uniform("grid"), static_cast<GLfloat>(level.grid.width),
                static_cast<GLfloat>(level.grid.height));
  if (level.activity) {
    gl_.Uniform1i(program.uniform("awake"), awake_unit);
  }
}

std::string sweep_text(const ShaderConstants& constants, std::size_t tile_class) {
  return defining(assemble(sources::sweep_fragment, constants), class_definitions(tile_class));
}

std::string sweep_pairs_text(const ShaderConstants& constants, const std::array<float, 16>& steps,
                             std::size_t tile_class) {
  return assemble(sources::sweep_pairs_fragment,
                  definitions(constants) + steps_definition(steps) + "#define PAIRS\n" +
                      class_definitions(tile_class),
                  *constants.energy);
}

} // namespace hdmbench::gl
