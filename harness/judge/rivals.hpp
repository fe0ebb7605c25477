#pragma once

#include "harness/judge/accuracy/truths.hpp"
#include "harness/scene/scene.hpp"
#include "reference/interpolation.hpp"

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What else solves a scene. Names beside those of the methods.
inline constexpr std::array<std::string_view, 6> rival_names{"fem",        "fem-cg",      "fem-amg",
                                                             "fem-coarse", "fixed-point", "interpolation"};

/// One setting of a rival.
struct Rival {
  std::string_view name;
  std::string effort; ///< as Judged::effort
  std::optional<EnergyModel> energy{};
  std::optional<double> poisson{};
  std::function<ReferenceField()> solve;  ///< the whole solution, assembly included; throws InputError
  const ReferenceField* solved = nullptr; ///< where it is one of the truths ...
  double seconds = 0.0;                   ///< ... and what that took
};

/// All settings of the rivals in the order of their names: finite elements factorised and by conjugate
/// gradients, and by multigrid of others where the build has it, with Poisson ratio 0 and the scene's, coarse
/// finite elements, the fixed point by factorisation, interpolation of the conditions. Both must outlive
/// them. With `quick` one setting of each.
[[nodiscard]] std::vector<Rival> rivals(const Scene& scene, const Truths& truths, bool quick);

} // namespace hdmbench
