#include "backends/gl/tile_sweeps.hpp"

#include <fmt/format.h>
#include <shaders/sweep_compute.hpp>

#include <algorithm>

namespace hdmbench::gl {

namespace {

/// As in kernels/sweep.comp's layout(binding = ..., location = ...).
constexpr GLuint tiles_binding = 0;
constexpr GLuint arguments_binding = 1;
constexpr GLuint visited_binding = 2;
constexpr GLuint classes_binding = 3;
constexpr GLint dimension_location = 0;
constexpr GLint penalty_location = 1;
constexpr GLint steps_location = 2; // of the general class
constexpr GLint lists_location = 19;
constexpr GLint first_location = 20;

/// Sites side by side that an invocation computes. Measured on llvmpipe with 8 lanes, 600 x 600, CPU time: 1,
/// 2, 4 sites are 103, 130, 142 Msites/s where most tiles are plain, and 4 not slower than 2 in any class.
/// Other rules gain less and compile longer.
int columns(const ShaderConstants& constants) {
  return constants.rule == static_cast<int>(Rule::steps) && constants.colours == 1 ? 4 : 1;
}

constexpr std::uint32_t most_groups = 65535; // wake.glsl

/// Tiles of a class that make a dispatch worth it: one costs llvmpipe about 10 us of CPU time, and a tile of
/// 512 sites 3.5 us in the general program and 2 us in the plainest.
constexpr std::uint32_t fewest_of_a_class = 8;

/// A class's words in the buffer of arguments: groups along x, y, z; number of tiles.
using Arguments = std::array<GLuint, 4>;
constexpr Arguments no_tiles{0, 1, 1, 0};
constexpr std::size_t list_count = 3;

template <typename Value>
void fill(const Api& api, const Buffer& buffer, const std::vector<Value>& values) {
  api.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.name());
  api.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(Value)),
                 values.data(), GL_DYNAMIC_COPY);
}

} // namespace

TileLists list_tiles(const Level& full, Extent extent, Alignment alignment) {
  return classify_tiles(
      full, extent, alignment,
      {.tile = tile_size,
       .classes = changes_spread_by_contact(full) ? class_set({0, 1, 2, 3, 4, 5, 6}) : class_set({}),
       .fewest = fewest_of_a_class});
}

std::string assemble(const TileProgramKind& kind) {
  const auto may_be = [&](std::size_t bit) { return (kind.tile_class & bit) != 0; };
  const int wide = columns(kind.constants);
  return assemble(sources::sweep_compute,
                  definitions(kind.constants) +
                      fmt::format("#define TILE_WIDTH {}\n#define TILE_HEIGHT {}\n#define COLUMNS {}\n"
                                  "#define LANES {}\n#define CLASS {}\n#define CLASSES {}\n"
                                  "#define BORDER {}\n#define OBSERVED {}\n#define ELASTIC {}\n"
                                  "#define ACTIVE {}\n",
                                  tile_size.width, tile_size.height, wide, tile_size.width / wide,
                                  kind.tile_class, class_count, may_be(tile_class::border_bit),
                                  may_be(tile_class::observed_bit), may_be(tile_class::elastic_bit),
                                  kind.active) +
                      (kind.steps ? steps_definition(*kind.steps) : ""));
}

TileSweeps::TileSweeps(const Api& api, TilePrograms& programs, const Level& level, const TileLists& lists,
                       bool active)
    : gl_(&api), level_(without_fields(level)), first_(lists.first), active_(active), tiles_(api),
      arguments_(api), visited_(api), of_tile_(api) {
  std::vector<std::uint32_t> tiles(list_count * lists.list.size());
  std::ranges::copy(lists.list, tiles.begin());
  std::vector<Arguments> arguments(list_count * class_count, no_tiles);
  for (std::size_t index = 0; index < class_count; ++index) {
    const GLuint groups = std::min(lists.count[index], most_groups);
    arguments[index] = {groups, 1, 1, lists.count[index]};
    if (groups == 0) {
      continue;
    }
    TileProgramKind kind{
        .constants = shader_constants(level), .steps = {}, .tile_class = index, .active = active};
    if (index != general_class) {
      kind.steps = level.steps.padded();
    }
    auto found = programs.find(kind);
    if (found == programs.end()) {
      found = programs
                  .try_emplace(kind, api,
                               std::initializer_list<Program::Stage>{{GL_COMPUTE_SHADER, assemble(kind)}})
                  .first;
    }
    classes_.push_back({.program = &found->second, .index = index, .groups = groups});
  }
  fill(api, tiles_, tiles);
  fill(api, arguments_, arguments);
  fill(api, visited_, std::vector<GLuint>(lists.classes.size()));
  fill(api, of_tile_, std::vector<GLuint>(lists.classes.begin(), lists.classes.end()));
}

void TileSweeps::bind(Extent extent) const {
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, tiles_binding, tiles_.name());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, arguments_binding, arguments_.name());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, visited_binding, visited_.name());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, classes_binding, of_tile_.name());
  gl_->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, arguments_.name());
  for (const ClassOfTiles& tiles : classes_) {
    tiles.program->program.use();
    gl_->Uniform2i(dimension_location, extent.width, extent.height);
    gl_->Uniform1f(penalty_location, level_.penalty);
    if (tiles.index == general_class) {
      gl_->Uniform1fv(steps_location, level_.steps.count(), level_.steps.padded().data());
    }
    gl_->Uniform1uiv(first_location, static_cast<GLsizei>(first_.size()), first_.data());
  }
}

void TileSweeps::sweep(int number) {
  const SweepState state = sweep_state(level_, number);
  const GLuint written = source_ == 1 ? 2 : 1;
  constexpr std::size_t bytes = class_count * sizeof(Arguments);
  if (active_) {
    ++list_;
    gl_->ClearBufferSubData(GL_DISPATCH_INDIRECT_BUFFER, GL_RGBA32UI, static_cast<GLintptr>(written * bytes),
                            static_cast<GLsizeiptr>(bytes), GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                            no_tiles.data());
  }
  for (const ClassOfTiles& tiles : classes_) {
    tiles.program->program.use();
    tiles.program->set_turn(*gl_, state);
    gl_->Uniform3ui(lists_location, source_, written, list_);
    if (source_ == 0) {
      gl_->DispatchCompute(tiles.groups, 1, 1);
    } else {
      gl_->DispatchComputeIndirect(static_cast<GLintptr>(source_ * bytes + tiles.index * sizeof(Arguments)));
    }
  }
  GLbitfield barriers = GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT;
  if (active_) {
    barriers |= GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT;
    source_ = written;
  }
  gl_->MemoryBarrier(barriers);
}

} // namespace hdmbench::gl
