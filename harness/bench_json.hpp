#pragma once

#include "harness/bench.hpp"

#include <nlohmann/json.hpp>

namespace hdmbench {

/// 10^6 site updates per second of compute; 0 without samples.
[[nodiscard]] double msites_per_second(const BenchResult& result);
/// "icm", "icm-active".
[[nodiscard]] std::string bench_method_name(const Scene& scene, const BenchResult& result);

/// One row of bench's results. Null is what does not apply or was not measured; `valid` is null where nothing
/// was compared. Of ceilings, and of what is compared with them, giga is 10^9.
[[nodiscard]] nlohmann::json to_json(const Scene& scene, const BenchResult& result);

} // namespace hdmbench
