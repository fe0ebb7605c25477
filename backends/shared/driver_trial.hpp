#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

/// A driver that aborts, hangs or takes all memory when it is asked for its devices would take the program
/// with it. So it is asked first in a process of its own: the program itself, started again.
namespace hdmbench {

/// What the process of a driver may take.
struct TrialLimits {
  double seconds = 30.0; ///< drivers of several cards may take some to start them
  std::int64_t resident_bytes = 2'000'000'000;
};

/// In a process that try_driver() has started: calls `ask` with the name of the backend and ends the process.
/// In every other one: require_answer() tries drivers from now on, unless HDMBENCH_ASK_IN_PROCESS is set.
void begin_driver_trials(int argc, const char* const* argv,
                         const std::function<void(std::string_view backend)>& ask);

/// Asks the driver in a process of its own. Returns an empty text where it answered; else what happened, as a
/// sentence, with the last line that it printed. Empty as well where the process cannot be started, which
/// says nothing about the driver.
[[nodiscard]] std::string try_driver(const std::string& backend, const TrialLimits& limits = {});

/// Throws DeviceError, in the words of try_driver(), where the driver of this backend did not answer. It is
/// tried once a process. Does nothing before begin_driver_trials().
void require_answer(std::string_view backend);

} // namespace hdmbench
