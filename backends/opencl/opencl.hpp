#pragma once

#include "backends/backend.hpp"

#include <memory>

namespace hdmbench {

/// OpenCL C 1.2 on any device of any driver that the loader, opened at run time, finds.
[[nodiscard]] std::unique_ptr<Backend> make_opencl();

} // namespace hdmbench
