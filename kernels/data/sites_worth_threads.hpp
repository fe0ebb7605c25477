#pragma once

#include <cstddef>

namespace hdmbench {

/// Below this many sites threads cost more than they bring.
inline constexpr std::size_t sites_worth_threads = std::size_t{1} << 15;

} // namespace hdmbench
