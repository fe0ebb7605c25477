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

} // namespace hdmbench
