#pragma once

#include "backends/session/level_arrays.hpp"
#include "backends/session/shapes.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace hdmbench {

/// The two displacements of a session: sweeps read one and write the other.
struct Displacements {
  [[nodiscard]] const Array* field() const { return arrays[newest].get(); }
  /// The field one sweep before, or what is to be written.
  [[nodiscard]] const Array* other() const { return arrays[1 - newest].get(); }
  void swap() { newest = 1 - newest; }

  std::array<std::unique_ptr<Array>, 2> arrays;
  std::size_t newest = 0;
};

/// What does not change during the sweeps of a level.
struct LevelArrays {
  std::unique_ptr<Array> material;          ///< modulus, 1 / modulus
  std::unique_ptr<Array> observation;       ///< target and confidence
  std::unique_ptr<Array> inverse_curvature; ///< one element where no rule needs it
};

/// A level that samples `full`, which may be the level itself, and how it is swept.
struct SweptLevel {
  const Level& full;
  Extent extent;
  Alignment alignment = Alignment::corner;
  std::vector<float> strengths{};
  Work work = Work::dense;
  SweepShape shape{};
  std::int32_t first_input = 0; ///< element of the inputs where the level's begin
};

/// The sweeps of one level. Work groups take tiles, and pass by those that cannot see a change:
/// every tile has a flag, the number of the last sweep that has to visit it. Programs are for classes of
/// tiles (kernels/shaders/sweep.comp), or where arrays are planes one branches by class
/// (kernels/shaders/sweep.cl).
class Sweeps {
public:
  /// Compiles what is missing in `programs`. Throws DeviceError.
  Sweeps(ComputeDevice& device, Programs& programs, const SweptLevel& level);

  /// All tiles are to be visited in the next sweep.
  void wake_all(Commands& commands);
  /// Appends sweeps first ... first + count - 1 of the level.
  void append(Commands& commands, int first, int count, const LevelArrays& level, const Array& inputs,
              Displacements& displacements);

private:
  /// Tiles by one program: those of a class, a part of the list.
  struct Share {
    const Program* program = nullptr;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    bool is_told_steps = true;
  };

  Level level_; ///< without its fields
  SiteLayout layout_;
  std::int32_t first_input_;
  std::uint32_t tiles_a_group_; ///< where tiles are left out
  bool is_fast_; ///< whether a change spreads by contact: the rule and the order that have programs by class
  bool active_;  ///< whether tiles are left out
  bool by_one_group_; ///< whether one group does several sweeps in a dispatch
  Extent tiles_;      ///< how many
  std::vector<Share> shares_;
  std::unique_ptr<Array>
      listed_; ///< tiles, class after class; of planes the class of every tile, if it has one
  std::unique_ptr<Array> flags_; ///< twice for every tile: by sweeps of odd numbers, and of even ones
  std::uint32_t stamp_ = 0;      ///< of the sweep before, since wake_all()
};

} // namespace hdmbench
