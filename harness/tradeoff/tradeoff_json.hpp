#pragma once

#include "harness/tradeoff/equal_accuracy.hpp"
#include "harness/tradeoff/tradeoff.hpp"

#include <nlohmann/json.hpp>

namespace hdmbench {

/// Rows of `tradeoff --json` for one scene: "kind" is "point", one for every point, and "equal accuracy", the
/// last. A point has its figures only where it has samples, null where they are not finite.
[[nodiscard]] nlohmann::json to_json(const Scene& scene, const SceneTradeoff& tradeoff,
                                     const EqualAccuracy& equal);

} // namespace hdmbench
