#pragma once

#include "backends/gl/fragment_level.hpp"

#include <compare>
#include <map>
#include <optional>
#include <string>

namespace hdmbench::gl {

/// Texture units of the samplers.
constexpr GLint image_unit = 0;
constexpr GLint observation_unit = 1;
constexpr GLint second_unit = 2; ///< Constants::second
constexpr GLint awake_unit = 3;
constexpr GLint table_unit = 4;
constexpr GLint inputs_unit = 5;
constexpr GLint previous_unit = observation_unit; ///< the image before the last sweep

/// sweep.frag for the tiles of a class.
[[nodiscard]] std::string sweep_text(const ShaderConstants& constants, std::size_t tile_class);
/// sweep_pairs.frag likewise, for these candidates.
[[nodiscard]] std::string sweep_pairs_text(const ShaderConstants& constants,
                                           const std::array<float, 16>& steps, std::size_t tile_class);

/// The fragment path's programs, each compiled when it is asked for the first time. Throws DeviceError with
/// the driver's log.
class FragmentPrograms {
public:
  explicit FragmentPrograms(const Api& api) : gl_(api) {}

  /// What draws `draw` of the level, its uniforms set, but for the turn.
  [[nodiscard]] const SweepProgram& sweep(const FragmentLevel& level, const FragmentLevel::Draw& draw);
  /// Which cells the last sweep changed; for the level's grid.
  [[nodiscard]] const Program& cells(const FragmentLevel& level);
  [[nodiscard]] const Program& wake();
  [[nodiscard]] const Program& count(Texels texels);
  /// From a texture of whole texels, or, by default, of one pixel per site.
  [[nodiscard]] const Program& sample(Texels texels = {});
  [[nodiscard]] const Program& project(Texels texels);

private:
  /// What a sweep's program is compiled for.
  struct Key {
    ShaderConstants constants;
    std::optional<std::array<float, 16>> steps{}; ///< of sweep_pairs.frag, none: sweep.frag
    std::size_t tile_class;
    bool active = false; ///< sleeping tiles are left out

    auto operator<=>(const Key&) const = default;
  };

  void set_tiles(const Program& program, const FragmentLevel& level) const;

  const Api& gl_;
  std::map<Key, SweepProgram> sweeps_;
  std::optional<Program> cells_;
  std::optional<Program> wake_;
  /// By the number of columns of a texel, less one.
  std::array<std::optional<Program>, 2> count_;
  std::array<std::optional<Program>, 2> sample_;
  std::array<std::optional<Program>, 2> project_;
};

} // namespace hdmbench::gl
