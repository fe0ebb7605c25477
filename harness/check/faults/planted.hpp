#pragma once

#include "backends/backend.hpp"

#include <array>
#include <functional>
#include <memory>
#include <ostream>
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
  either,      ///< a mistake that a device need not show; counts for nothing
};

/// Where a mistake is put in.
enum class Layer {
  session, ///< between verify and any backend's Session
  shader,  ///< into the text of a real backend's shader, on its way to the driver
  driver,  ///< into the calls of a real backend to its driver
  ranks,   ///< into what ranks tell each other
};

/// What results call them, in the order of the enumerators.
inline constexpr std::array<std::string_view, 3> expected_names{"disagree", "let through", "either"};
inline constexpr std::array<std::string_view, 4> layer_names{"session", "shader", "driver", "ranks"};

/// In which part of the work a mistake is. It is tried only on scenes that have that part.
enum class Part {
  sweep,  ///< in every scene
  levels, ///< from one level to the next of a pyramid in one piece
  sleep,  ///< which tiles the next sweep has to visit: small levels are visited whole
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
  /// Computed by the processor's own instructions, denormal numbers as IEEE 754 has them.
  bool on_cpu = false;
  Expected expected = Expected::disagree;
  std::string method = "icm"; ///< that it concerns: it is tried on scenes solved that way only; empty: on all
  bool bitwise = false;       ///< rounding excuses no difference: it has to have the bits of the reference
  std::size_t variant = 0;    ///< SessionOptions::variant that it is tried with
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

} // namespace hdmbench::faults
