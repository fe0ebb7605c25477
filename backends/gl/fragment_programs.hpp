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
constexpr GLint confidence_unit = 2;
constexpr GLint awake_unit = 3;
constexpr GLint table_unit = 4;

/// sweep.frag for the tiles of a class; `active`: it says which sites changed.
[[nodiscard]] std::string sweep_fragment_text(const ShaderConstants& constants, std::size_t tile_class,
                                              bool active);

/// The fragment path's programs, each compiled when it is asked for the first time. Throws DeviceError with
/// the driver's log.
class FragmentPrograms {
public:
  explicit FragmentPrograms(const Api& api) : gl_(api) {}

  /// A sweep of the level over its tiles of one class, its uniforms set, but for the turn.
  [[nodiscard]] const SweepProgram& sweep(const FragmentLevel& level, std::size_t tile_class);
  /// Which cells the last sweep changed; for the level's grid.
  [[nodiscard]] const Program& cells(const FragmentLevel& level);
  [[nodiscard]] const Program& wake();
  [[nodiscard]] const Program& count();
  [[nodiscard]] const Program& sample();
  [[nodiscard]] const Program& project();

private:
  /// What a sweep's program is compiled for.
  struct Key {
    ShaderConstants constants;
    std::size_t tile_class;
    bool active = false; ///< sleeping tiles are left out

    auto operator<=>(const Key&) const = default;
  };

  void set_tiles(const Program& program, const FragmentLevel& level) const;

  const Api& gl_;
  std::map<Key, SweepProgram> sweeps_;
  std::optional<Program> cells_;
  std::optional<Program> wake_;
  std::optional<Program> count_;
  std::optional<Program> sample_;
  std::optional<Program> project_;
};

} // namespace hdmbench::gl
