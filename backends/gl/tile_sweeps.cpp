#include "backends/gl/tile_sweeps.hpp"

#include <fmt/format.h>
#include <shaders/sweep_compute.hpp>

#include <algorithm>

namespace hdmbench::gl {

namespace {

/// As in kernels/shaders/sweep.comp's layout(binding = ..., location = ...).
constexpr GLuint tiles_binding = 0;
constexpr GLuint lengths_binding = 1;
constexpr GLint dimension_location = 0;
constexpr GLint penalty_location = 1;
constexpr GLint steps_location = 2; // of the general class
constexpr GLint tiles_across_location = 19;
constexpr GLint tile_count_location = 20;
constexpr GLint list_location = 21;
constexpr GLint length_location = 22;
constexpr GLint next_list_location = 23;
constexpr GLint next_length_location = 24;
constexpr GLint stamp_location = 25;
constexpr GLint first_input_location = 26;

/// Sites side by side that an invocation computes. Other rules gain less by more and compile longer.
int columns(const TileProgramKind& kind) {
  const bool fast = kind.constants.rule == static_cast<int>(Rule::steps) && kind.constants.colours == 1;
  return fast ? kind.shape.columns : 1;
}

/// Tiles of a class that make a dispatch worth it: one costs llvmpipe about 10 us of CPU time, and a tile of
/// 512 sites 3.5 us in the general program and 2 us in the plainest.
constexpr std::uint32_t fewest_of_a_class = 8;

/// Of a list, as wake.glsl has it: work groups along x, y, z; number of tiles.
using Length = std::array<GLuint, 4>;

Length length_of(GLuint tiles) {
  const auto most = static_cast<GLuint>(tile_class::most_groups_across);
  return tiles == 0 ? Length{} : Length{std::min(tiles, most), (tiles + most - 1) / most, 1, tiles};
}

/// Element of the lengths where those of a set begin.
constexpr GLint first_length(GLint set) {
  return set * static_cast<GLint>(class_count);
}

/// The words of wake.glsl: the classes and the full lists.
std::vector<GLuint> words(const TileLists& lists) {
  const std::size_t count = lists.list.size();
  std::vector<GLuint> result(tile_class::words_per_tile * count);
  std::ranges::copy(lists.classes,
                    result.begin() + static_cast<std::ptrdiff_t>(tile_class::classes_section * count));
  for (std::size_t number = 0; number < class_count; ++number) {
    std::copy_n(lists.list.begin() + lists.first[number], lists.count[number],
                result.begin() +
                    static_cast<std::ptrdiff_t>(tile_class::list_begin(tile_class::full_set, number, count)));
  }
  return result;
}

template <typename Value>
void fill(const Api& api, const Buffer& buffer, const std::vector<Value>& values) {
  api.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.name());
  api.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(Value)),
                 values.data(), GL_DYNAMIC_COPY);
}

} // namespace

TileLists list_tiles(const Level& full, Extent extent, Alignment alignment, Extent tile) {
  return classify_tiles(
      full, extent, alignment,
      {.tile = tile,
       .classes = changes_spread_by_contact(full) ? classes_inside | class_set({4, 5, 6}) : class_set({}),
       .fewest = fewest_of_a_class});
}

std::string assemble(const TileProgramKind& kind) {
  const int wide = columns(kind);
  return assemble(sources::sweep_compute,
                  definitions(kind.constants) +
                      fmt::format("#define TILE_WIDTH {}\n#define TILE_HEIGHT {}\n#define COLUMNS {}\n"
                                  "#define LANES {}\n#define CLASS {}\n#define ACTIVE {}\n",
                                  kind.shape.tile.width, kind.shape.tile.height, wide,
                                  kind.shape.tile.width / wide, kind.tile_class, kind.active) +
                      (kind.steps ? steps_definition(*kind.steps) : ""),
                  *kind.constants.energy);
}

TileSweeps::TileSweeps(const Api& api, TilePrograms& programs, const Level& level, const TileLists& lists,
                       const SweepShape& shape, bool active, GLint first_input)
    : gl_(&api), first_input_(first_input), level_(without_fields(level)), tiles_along_(lists.tiles),
      active_(active), tiles_(api), lengths_(api) {
  std::vector<Length> lengths(3 * class_count);
  for (std::size_t number = 0; number < class_count; ++number) {
    lengths[tile_class::full_set * class_count + number] = length_of(lists.count[number]);
    if (lists.count[number] == 0) {
      continue;
    }
    TileProgramKind kind{.constants = shader_constants(level),
                         .steps = {},
                         .tile_class = number,
                         .shape = shape,
                         .active = active};
    if (number != general_class) {
      kind.steps = level.steps.padded();
    }
    auto found = programs.find(kind);
    if (found == programs.end()) {
      found = programs
                  .try_emplace(kind, api,
                               std::initializer_list<Program::Stage>{{GL_COMPUTE_SHADER, assemble(kind)}})
                  .first;
    }
    classes_.push_back({.program = &found->second, .number = number, .count = lists.count[number]});
  }
  fill(api, tiles_, words(lists));
  fill(api, lengths_, lengths);
}

void TileSweeps::bind(Extent extent) const {
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, tiles_binding, tiles_.name());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, lengths_binding, lengths_.name());
  gl_->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, lengths_.name());
  for (const ClassOfTiles& tiles : classes_) {
    tiles.program->program.use();
    gl_->Uniform2i(dimension_location, extent.width, extent.height);
    gl_->Uniform1f(penalty_location, level_.penalty);
    if (tiles.number == general_class) {
      gl_->Uniform1fv(steps_location, level_.steps.count(), level_.steps.padded().data());
    }
    if (level_.energy->inputs > 0) {
      gl_->Uniform1i(first_input_location, first_input_);
    }
    gl_->Uniform1i(tiles_across_location, tiles_along_.width);
    gl_->Uniform1i(tile_count_location, static_cast<GLint>(tiles_along_.sites()));
  }
}

void TileSweeps::sweep(int number) {
  const SweepState state = sweep_state(level_, number);
  const GLint written = set_ == 0 ? 1 : 0;
  if (active_) {
    ++stamp_;
    gl_->ClearBufferSubData(GL_DISPATCH_INDIRECT_BUFFER, GL_RGBA32UI,
                            first_length(written) * static_cast<GLintptr>(sizeof(Length)),
                            static_cast<GLsizeiptr>(class_count * sizeof(Length)), GL_RGBA_INTEGER,
                            GL_UNSIGNED_INT, Length{}.data());
  }
  for (const ClassOfTiles& tiles : classes_) {
    tiles.program->program.use();
    tiles.program->set_turn(*gl_, state);
    gl_->Uniform1i(list_location, set_);
    gl_->Uniform1i(length_location, first_length(set_));
    if (active_) {
      gl_->Uniform1i(next_list_location, written);
      gl_->Uniform1i(next_length_location, first_length(written));
      gl_->Uniform1i(stamp_location, stamp_);
    }
    if (set_ == tile_class::full_set) {
      const Length length = length_of(tiles.count);
      gl_->DispatchCompute(length[0], length[1], length[2]);
    } else {
      const auto element = first_length(set_) + static_cast<GLintptr>(tiles.number);
      gl_->DispatchComputeIndirect(element * static_cast<GLintptr>(sizeof(Length)));
    }
  }
  GLbitfield barriers = GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT;
  if (active_) {
    barriers |= GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT;
    set_ = written;
  }
  gl_->MemoryBarrier(barriers);
}

} // namespace hdmbench::gl
