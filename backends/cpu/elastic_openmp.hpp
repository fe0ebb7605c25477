#pragma once

#include "backends/cpu/elastic_rows.hpp"
#include "backends/shared/elastic_session.hpp"

#include <memory>

namespace hdmbench {

/// OpenMP threads x SIMD lanes; `rows` of an instruction set that this processor has must outlive it. With
/// less than `sites_worth_a_thread` for each a thread costs more than it brings; tests ask for less.
[[nodiscard]] std::unique_ptr<ElasticSession>
make_elastic_openmp(int threads, const openmp::ElasticRows& rows, std::size_t sites_worth_a_thread = 8192);

} // namespace hdmbench
