#pragma once

#include "backends/backend.hpp"

#include <string_view>

namespace hdmbench {

/// The processor's name as the operating system has it; `driver` says how it is used ("2 threads, AVX2").
[[nodiscard]] Device cpu_device(std::string_view driver);

/// Starts the threads of OpenMP, each on a processor of its own. Without it a second thread may begin on the
/// first one's, and both wait for each other in turn until the system moves one: up to 0.1 s. Afterwards
/// every thread may run where the process may. Does nothing where there are not as many processors as
/// threads, or the system cannot say.
void place_threads();

} // namespace hdmbench
