#pragma once

#include "harness/check/faults/planted.hpp"
#include "harness/check/verify.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench::faults {

/// A scene that faults are tried on.
struct TrialScene {
  std::string label; ///< "random, coloured"
  Scene scene;
  /// Its numbers are such that a GPU may compute otherwise without a mistake.
  bool only_on_cpu = false;
  bool tiles_sleep = false; ///< large enough for every backend to leave tiles out; for Part::sleep only
};

/// A level of 3 x 3 tiles of the largest size that a backend has, most of them asleep from the second sweep
/// on. The tile in the middle has something pulled next to each of its sides, away from its corners; the one
/// at the top right, in its middle and along y alone.
[[nodiscard]] TrialScene sleeping_tiles();

/// Scenes by name or file at one size; none: small ones. Without names: the thesis's square and circle,
/// tie-rich, random, the exact ones of the shipped scenes, random again by the rules that some faults
/// concern, one that comes to rest, one of sleeping tiles, and one with denormal displacements. Throws
/// InputError.
[[nodiscard]] std::vector<TrialScene> trial_scenes(const std::vector<std::string>& names,
                                                   std::optional<Extent> size);

/// What verify said of a planted fault on one scene, all modes together.
struct Seen {
  Verdict verdict = Verdict::skipped; ///< the worst; skipped where all are
  std::int64_t sites_differing = 0;
  std::int64_t uncertified = 0;
  std::int64_t counts_differing = 0;
  std::string reason; ///< of skipped and mistrusted
  std::string error;  ///< the driver's words where it refused to go on; then there is no verdict
};

/// "disagree", or "error".
[[nodiscard]] std::string_view text(const Seen& seen);

/// One planted fault on all scenes.
struct Trial {
  Planted planted;
  Device device;                         ///< it ran on
  std::vector<std::optional<Seen>> seen; ///< per scene; none: the scene is not for this fault
  std::string not_planted;               ///< why not; empty: it was

  /// Verdicts that are worth anything: of a run, not skipped, mistrusted or broken off.
  [[nodiscard]] bool ran() const;
  /// verify said disagree on one scene at least.
  [[nodiscard]] bool caught() const;
  /// Whether verify did what Planted::expected says, or nothing could be run. A control on a scene that is
  /// mistrusted did not: what is let through there says nothing.
  [[nodiscard]] bool as_expected() const;
};

/// Scenes that `planted` is for.
[[nodiscard]] bool concerns(const Planted& planted, const TrialScene& scene);

/// Verifies the backend with the fault against `reference`, a few iterations per level.
[[nodiscard]] Trial try_out(const Planted& planted, const Backend& reference,
                            std::span<const TrialScene> scenes, Progress& progress);

/// One row of `faults`' results: {"fault", "what", "backend", "device", "layer", "expected", "caught",
/// "as_expected", "not_planted", "scenes": [{"scene", "width", "height", "method", "exact", "verdict",
/// "sites_differing", "uncertified", "counts_differing", "reason"}]}.
[[nodiscard]] nlohmann::json json_row(const Trial& trial, std::span<const TrialScene> scenes);

} // namespace hdmbench::faults
