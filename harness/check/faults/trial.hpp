#pragma once

#include "harness/check/verify.hpp"

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// The checker checked: mistakes planted on purpose, each of which `verify` must see.
namespace hdmbench::faults {

/// What the cross-check has to say of it.
enum class Expected {
  disagree,    ///< on one scene at least
  let_through, ///< a control: agree or certified on every scene
};

/// Where a mistake is put in.
enum class Layer {
  session, ///< between verify and any backend's Session
  shader,  ///< into the text of a real backend's shader, on its way to the driver
  driver,  ///< into the calls of a real backend to its driver
  ranks,   ///< into what ranks tell each other
};

/// In which part of the work a mistake is. It is tried only on scenes that have that part.
enum class Part {
  sweep,         ///< in every scene
  levels,        ///< from one level to the next of a pyramid in one piece
  coarse_levels, ///< of such a pyramid, in one dispatch
  sleep,         ///< which tiles the next sweep has to visit: small levels are visited whole
};

/// A fault could not be put in: its text is not in the shader, or more than once; its call is never made.
class NotPlanted : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// A backend with one mistake, ready to be verified.
struct Planted {
  std::string name;    ///< "skipped-sweep", unique together with `backend`
  std::string what;    ///< one line for people
  std::string backend; ///< that it is planted on
  Layer layer = Layer::session;
  Expected expected = Expected::disagree;
  std::string method = "icm"; ///< that it concerns: it is tried on scenes solved that way only; empty: on all
  std::size_t axes = 0;       ///< of the scenes that it is tried on, 2 or 3; 0: of all
  bool bitwise = false;       ///< rounding excuses no difference: it has to have the bits of the reference
  Part part = Part::sweep;
  /// Makes the backend. It throws DeviceError on devices() or open() where the device is not there.
  std::function<std::unique_ptr<Backend>()> make;
  /// Throws NotPlanted where what make() returned has run and the fault has not. Null: it always does.
  std::function<void()> require_planted{};

  friend void PrintTo(const Planted& planted, std::ostream* stream) {
    *stream << planted.name << " on " << planted.backend;
  }
};

/// Everything: controls and mistakes of sessions on `carrier`, which must outlive the list, and those in the
/// shaders and driver calls of this build's OpenGL backends.
[[nodiscard]] std::vector<Planted> all_planted(const Backend& carrier);

/// A scene that faults are tried on.
struct TrialScene {
  std::string label; ///< "random, coloured"
  Scene scene;
  bool tiles_sleep = false; ///< large enough for every backend to leave tiles out; for Part::sleep only
};

/// Scenes by name or file at one size; none: small ones. Without names: the thesis's square and circle,
/// tie-rich, random, the exact ones of the shipped scenes, random again by the rules that some faults
/// concern, one that comes to rest, one of sleeping tiles, and volumes. Throws InputError.
[[nodiscard]] std::vector<TrialScene> trial_scenes(const std::vector<std::string>& names,
                                                   std::optional<Extent> size);

/// Scenes that `planted` is for.
[[nodiscard]] bool concerns(const Planted& planted, const TrialScene& scene);

/// Verifies the backend with the fault against `reference`, a few iterations per level. One row of `faults`'
/// results: {"fault", "what", "backend", "device", "layer", "expected", "ran", "caught", "as_expected",
/// "not_planted", "scenes": [{"scene", "width", "height", "method", "exact", "verdict", "sites_differing",
/// "uncertified", "counts_differing", "reason"}]}. "scenes" has those that `planted` is for, with the worst
/// verdict of all modes, "skipped" where all are, "error" where the driver refused to go on. "ran": there is
/// a verdict that is worth anything. "as_expected": verify did what Planted::expected says, or nothing could
/// be run. A control on a scene that is mistrusted did not: what is let through there says nothing.
/// "not_planted": why not; empty: it was.
[[nodiscard]] nlohmann::json try_out(const Planted& planted, const Backend& reference,
                                     std::span<const TrialScene> scenes, Progress& progress);

} // namespace hdmbench::faults
