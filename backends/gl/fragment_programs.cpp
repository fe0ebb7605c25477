#include "backends/gl/fragment_programs.hpp"

#include <fmt/format.h>
#include <shaders/passes_fragment.hpp>
#include <shaders/quad_vertex.hpp>
#include <shaders/sweep_fragment.hpp>
#include <shaders/tiles_vertex.hpp>

#include <utility>

namespace hdmbench::gl {

namespace {

/// tiles.vert for points of `side` texels.
std::string tiles_text(int side, bool active) {
  return assemble(sources::tiles_vertex, fmt::format("#define POINTS {}\n{}", FragmentLevel::tile_side / side,
                                                     active ? "#define ACTIVE\n" : ""));
}

/// What programs of tiles of a class may take for granted.
std::string class_definitions(std::size_t tile_class) {
  const auto may_be = [&](std::size_t bit) { return (tile_class & bit) != 0; };
  return fmt::format("{}{}{}", may_be(tile_class::border_bit) ? "" : "#define INTERIOR\n",
                     may_be(tile_class::elastic_bit) ? "" : "#define HOMOGENEOUS\n",
                     may_be(tile_class::observed_bit) ? "" : "#define UNOBSERVED\n");
}

} // namespace

std::string sweep_text(const ShaderConstants& constants, std::size_t tile_class,
                       const std::optional<std::array<float, 16>>& steps, std::size_t axes) {
  return assemble(sources::sweep_fragment,
                  definitions(constants) + class_definitions(tile_class) +
                      fmt::format("#define HDM_AXES {}\n", axes) +
                      (steps ? steps_definition(*steps) + "#define PAIRS\n" : ""),
                  *constants.energy);
}

const FragmentPrograms::Sweep& FragmentPrograms::sweep(const FragmentLevel& level,
                                                       const FragmentLevel::Draw& draw) {
  const Level& header = level.header;
  Key key{.constants = shader_constants(header),
          .tile_class = draw.tile_class,
          .active = level.activity.has_value(),
          .axes = header.extent.axes()};
  if (level.texels.columns == 2) {
    key.steps = header.steps.padded();
  }
  auto found = sweeps_.find(key);
  if (found == sweeps_.end()) {
    Program made(gl_,
                 {{GL_VERTEX_SHADER,
                   key.axes == 3 ? std::string(sources::quad_vertex) : tiles_text(draw.side, key.active)},
                  {GL_FRAGMENT_SHADER, sweep_text(key.constants, draw.tile_class, key.steps, key.axes)}});
    const GLint turn = made.uniform("turn");
    const GLint slice = made.uniform("slice");
    found = sweeps_.emplace(key, Sweep{std::move(made), turn, slice}).first;
  }
  const Program& program = found->second.program;
  program.use();
  gl_.Uniform1i(program.uniform("image"), image_unit);
  gl_.Uniform1i(program.uniform("observation"), observation_unit);
  gl_.Uniform1i(program.uniform(key.steps ? "material" : "confidence"), second_unit);
  gl_.Uniform1i(program.uniform("inputs"), inputs_unit); // -1, ignored, where the energy has none
  gl_.Uniform1i(program.uniform("curvature"), curvature_unit);
  const auto [width, height, depth] = header.extent.sides();
  if (key.axes == 3) {
    gl_.Uniform3f(program.uniform("dimension"), static_cast<GLfloat>(width), static_cast<GLfloat>(height),
                  static_cast<GLfloat>(depth));
    level.constants.observation.tell_slices(program.uniform("slices"));
  } else {
    gl_.Uniform2f(program.uniform("dimension"), static_cast<GLfloat>(width), static_cast<GLfloat>(height));
  }
  gl_.Uniform1f(program.uniform("penalty"), header.penalty);
  if (!key.steps) {
    gl_.Uniform1fv(program.uniform("steps"), header.steps.count(), header.steps.padded().data());
  }
  set_tiles(program, level);
  return found->second;
}

const Program& FragmentPrograms::pass(const std::string& vertices, const std::string& definitions) {
  std::unique_ptr<Program>& known = passes_[definitions];
  if (known == nullptr) {
    auto made = std::make_unique<Program>(
        gl_, std::initializer_list<Program::Stage>{
                 {GL_VERTEX_SHADER, vertices},
                 {GL_FRAGMENT_SHADER, assemble(sources::passes_fragment, definitions)}});
    made->use();
    gl_.Uniform1i(made->uniform("image"), image_unit); // -1, ignored, where the pass has no such sampler
    gl_.Uniform1i(made->uniform("previous"), previous_unit);
    known = std::move(made);
  }
  known->use();
  return *known;
}

const Program& FragmentPrograms::pass(const std::string& definitions) {
  return pass(std::string(sources::quad_vertex), definitions);
}

void FragmentPrograms::use_cells(const FragmentLevel& level) {
  constexpr int cell = FragmentLevel::tile_side / FragmentLevel::cells_along_a_tile;
  set_tiles(pass(tiles_text(FragmentLevel::tile_side, true), fmt::format("#define CELL {}\n", cell)), level);
}

void FragmentPrograms::set_tiles(const Program& program, const FragmentLevel& level) const {
  gl_.Uniform2f(program.uniform("grid"), static_cast<GLfloat>(level.grid.width),
                static_cast<GLfloat>(level.grid.height));
  if (level.activity) {
    gl_.Uniform1i(program.uniform("awake"), awake_unit);
  }
}

} // namespace hdmbench::gl
