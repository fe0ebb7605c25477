#pragma once

#include "backends/gl/fragment_level.hpp"

#include <array>
#include <compare>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace hdmbench::gl {

/// Texture units of the samplers.
constexpr GLint image_unit = 0;
constexpr GLint observation_unit = 1;
constexpr GLint second_unit = 2; ///< Constants::second
constexpr GLint awake_unit = 3;
constexpr GLint inputs_unit = 4;
constexpr GLint curvature_unit = 5;
constexpr GLint previous_unit = observation_unit; ///< the image before the last sweep

/// sweep.frag for the tiles of a class, in pairs for these candidates, or without them in texels of one site;
/// of a volume without them.
[[nodiscard]] std::string sweep_text(const ShaderConstants& constants, std::size_t tile_class,
                                     const std::optional<std::array<float, 16>>& steps = {},
                                     std::size_t axes = 2);

/// The fragment path's programs, each compiled when it is asked for the first time. Throws DeviceError with
/// the driver's log.
class FragmentPrograms {
public:
  explicit FragmentPrograms(const Api& api) : gl_(api) {}

  struct Sweep {
    Program program;
    GLint turn;  ///< location of the uniform that changes from sweep to sweep, -1 where the rule has none
    GLint slice; ///< of that which changes from slice to slice, -1 in an image
  };
  /// What draws `draw` of the level, its uniforms set, but for the turn.
  [[nodiscard]] const Sweep& sweep(const FragmentLevel& level, const FragmentLevel::Draw& draw);
  /// What passes.frag is with these definitions, on a quad, in use.
  [[nodiscard]] const Program& pass(const std::string& definitions);
  /// That which finds out which cells the last sweep changed; for the level's grid.
  void use_cells(const FragmentLevel& level);

private:
  /// What a sweep's program is compiled for.
  struct Key {
    ShaderConstants constants;
    std::optional<std::array<float, 16>> steps{}; ///< of pairs
    std::size_t tile_class;
    bool active = false; ///< sleeping tiles are left out
    std::size_t axes = 2;

    auto operator<=>(const Key&) const = default;
  };

  const Program& pass(const std::string& vertices, const std::string& definitions);
  void set_tiles(const Program& program, const FragmentLevel& level) const;

  const Api& gl_;
  std::map<Key, Sweep> sweeps_;
  std::map<std::string, std::unique_ptr<Program>> passes_; ///< by their definitions
};

} // namespace hdmbench::gl
