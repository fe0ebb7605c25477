#pragma once

#include "backends/gl/objects.hpp"
#include "backends/shared/sweep_shapes.hpp"
#include "backends/shared/tiles.hpp"

#include <array>
#include <compare>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench::gl {

/// The tiles that TileSweeps takes, of that many sites. Rules and updates other than the fast one, candidates
/// and simultaneous, take general ones: their programs gain less and compile longer.
[[nodiscard]] TileLists list_tiles(const Level& full, Extent extent, Alignment alignment, Extent tile);

/// What a program of kernels/shaders/sweep.comp is compiled for.
struct TileProgramKind {
  ShaderConstants constants{};
  /// The level's, padded, as constants. Empty for the general class, which is all that small levels have: a
  /// new set of candidates compiles nothing there.
  std::optional<std::array<float, 16>> steps{};
  std::size_t tile_class = general_class; ///< of kernels/specification/tile_class.inc
  SweepShape shape = sweep_shapes.front();
  bool active = false; ///< whether it lists the tiles for the next sweep

  auto operator<=>(const TileProgramKind&) const = default;
};

/// kernels/shaders/sweep.comp as the driver wants it.
[[nodiscard]] std::string assemble(const TileProgramKind& kind);

/// Programs by what they were compiled for: going back to a rule or a level compiles nothing.
using TilePrograms = std::map<TileProgramKind, SweepProgram>;

/// The sweeps of one level: which tiles in which programs. The lists of what has to be visited stay on the
/// device. `lists` must be of `shape`'s tiles. The context must be current in all calls.
class TileSweeps {
public:
  /// `level` gives the rules; fields are not read. Compiles into `programs`, which must outlive this, as
  /// `api`.
  TileSweeps(const Api& api, TilePrograms& programs, const Level& level, const TileLists& lists,
             const SweepShape& shape, bool active, GLint first_input);

  /// Binds the lists and sets what is the same in all sweeps of the level. Before sweep(), whenever another
  /// level was swept in between.
  void bind(Extent extent) const;
  /// All tiles are to be visited in the next sweep.
  void wake_all() { set_ = tile_class::full_set; }
  /// Sweep `number` of the level; image and next_image are bound. A barrier for all that it stores follows.
  void sweep(int number);

private:
  struct ClassOfTiles {
    const SweepProgram* program = nullptr;
    std::size_t number = 0;
    GLuint count = 0; ///< of all its tiles
  };

  const Api* gl_;
  GLint first_input_; ///< where the level's inputs begin (InputTexels)
  Level level_;       ///< without its fields
  Extent tiles_along_;
  std::vector<ClassOfTiles> classes_; ///< those that the level has
  bool active_ = false;
  GLint set_ = tile_class::full_set; ///< of lists that the next sweep visits
  GLint stamp_ = 0;                  ///< of the sweep before, since construction
  Buffer tiles_;                     ///< these two are kernels/shaders/wake.glsl's
  Buffer lengths_;
};

} // namespace hdmbench::gl
