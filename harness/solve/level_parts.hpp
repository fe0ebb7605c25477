#pragma once

#include "backends/shared/box.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/level.hpp"

#include <optional>

/// Parts of a level of the elastic energy that are solved by themselves.
namespace hdmbench {

struct LevelPart {
  Box sites; ///< of the whole level
  Level level;
};

/// Returns the level without the sites that conditions prescribe altogether and that touch nothing else,
/// where these lie around the rest: the rest has the same solution. Where tissue of large strains slides,
/// the layer of void beside what is prescribed is cut off, too. None where so little would be cut off that
/// it is not worth a copy.
[[nodiscard]] std::optional<LevelPart> moving_part(const Level& level);

/// Returns what solve() does, which solves a part of the level: where that is refused, the places in what is
/// said are those of the whole level.
template <typename Solve>
[[nodiscard]] auto with_places_of(const Level& level, const Solve& solve) {
  try {
    return solve();
  } catch (const InputError&) {
    require_held(level); // says the same of the whole level
    throw;
  }
}

/// Returns these sites of a level, those that lie beside others being held where `displacement` has them.
[[nodiscard]] LevelPart held_part(const Level& level, const Box& sites, const VectorField& displacement);

/// Returns the displacement of `level`, `part` of which moves so, and whose other sites have their targets;
/// void that has none has means of those around.
[[nodiscard]] VectorField with_prescribed(const Level& level, const Box& part, const VectorField& of_part);

} // namespace hdmbench
