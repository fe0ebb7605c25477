#pragma once

#include "backends/session/level_arrays.hpp"
#include "backends/session/shapes.hpp"
#include "backends/shared/interface.hpp"
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

/// The sweeps of one level: which tiles in which programs, and which of them can see a change.
class Sweeps : public Interface {
public:
  /// All tiles are to be visited in the next sweep.
  virtual void wake_all(Commands& commands) = 0;
  /// Appends sweeps first ... first + count - 1 of the level.
  virtual void append(Commands& commands, int first, int count, const LevelArrays& level, const Array& inputs,
                      Displacements& displacements) = 0;
};

/// By lists of tiles of a class, which the device writes itself (kernels/shaders/sweep.comp), or where arrays
/// are planes by flags of tiles (kernels/shaders/sweep.cl). Compiles what is missing in `programs`. Throws
/// DeviceError.
[[nodiscard]] std::unique_ptr<Sweeps> make_sweeps(ComputeDevice& device, Programs& programs,
                                                  const SweptLevel& level);

} // namespace hdmbench
