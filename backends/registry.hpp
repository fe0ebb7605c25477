#pragma once

#include "backends/backend.hpp"

#include <memory>
#include <string_view>
#include <vector>

namespace hdmbench {

/// Every backend this source tree knows, `scalar` first (the reference for bits). One that was not built is
/// listed as well: its devices() throws and says so.
[[nodiscard]] std::vector<std::unique_ptr<Backend>> make_backends();

/// Throws InputError listing the names that exist.
[[nodiscard]] const Backend& find_backend(const std::vector<std::unique_ptr<Backend>>& backends,
                                          std::string_view name);

/// To be called first in main(), by a program that a driver must not take along. From then on `devices()`
/// asks each driver first in a process of its own, in which this same program is started again, and throws
/// DeviceError where the driver aborts, hangs or takes too much memory there (shared/driver_trial.hpp). In
/// such a process this function asks the driver and does not return. A program that does not call it asks
/// drivers in its own process, as does one that finds HDMBENCH_ASK_IN_PROCESS in its environment.
void ask_drivers_apart(int argc, const char* const* argv);

} // namespace hdmbench
