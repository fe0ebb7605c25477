#pragma once

#include "backends/backend.hpp"

#include <memory>

namespace hdmbench {

[[nodiscard]] std::unique_ptr<Backend> make_scalar();

} // namespace hdmbench
