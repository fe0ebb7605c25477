#pragma once

#include "backends/backend.hpp"

#include <string_view>

namespace hdmbench {

/// The processor's name as the operating system has it; `driver` says how it is used ("2 threads, AVX2").
[[nodiscard]] Device cpu_device(std::string_view driver);

} // namespace hdmbench
