#pragma once

#include "backends/backend.hpp"
#include "harness/ranks/message_passing.hpp"

#include <memory>
#include <string_view>
#include <vector>

namespace hdmbench {

/// Which device a rank opens: "by-rank" is the one that has the rank's number among the ranks of its machine,
/// from the first one on again where there are fewer. Threads that nobody asked for: the machine's, shared
/// out. Throws DeviceError.
[[nodiscard]] SessionOptions options_of_rank(SessionOptions asked, const Backend& backend,
                                             const Ranks& ranks);

/// "openmp", or "openmp+vulkan-compute": the backend of each rank in turn, from the first one on again.
/// Throws InputError where one is unknown.
[[nodiscard]] const Backend& backend_of_rank(const std::vector<std::unique_ptr<Backend>>& registry,
                                             std::string_view names, int rank);

} // namespace hdmbench
