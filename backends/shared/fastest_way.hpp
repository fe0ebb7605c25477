#pragma once

#include "backends/backend.hpp"

#include <functional>

namespace hdmbench {

/// For Variants::measure: of each way worth trying, after take(), some samples of seconds(); in turn, so that
/// a drift of the machine hits all alike.
[[nodiscard]] Choice fastest_way(const Variants& variants, const std::function<void(std::size_t)>& take,
                                 const std::function<double()>& seconds);

/// How long `work` takes on a clock.
[[nodiscard]] double seconds_of(const std::function<void()>& work);

/// An image of one modulus but for a square in it, with its border held and one corner of that displaced.
[[nodiscard]] Level measured_level(Extent extent, float modulus_of_square);

} // namespace hdmbench
