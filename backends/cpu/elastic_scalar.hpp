#pragma once

#include "backends/shared/elastic_session.hpp"

#include <memory>

namespace hdmbench {

/// Site by site on one thread, as plainly as the specification reads: the reference for bits.
[[nodiscard]] std::unique_ptr<ElasticSession> make_elastic_scalar();

} // namespace hdmbench
