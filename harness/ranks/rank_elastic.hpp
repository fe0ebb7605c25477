#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/ranks/rank_faults.hpp"
#include "harness/ranks/sharing.hpp"

#include <functional>
#include <memory>

namespace hdmbench {

/// Opens a session that all ranks have together: every rank makes the same calls, with the same hierarchy and
/// the same fields. Levels that are cut are computed by every rank with a piece, with its halo: each step
/// makes the rim of what it writes wrong, and a halo is renewed when what is left of it is too narrow for the
/// next step. Coarse levels are computed by the first rank. The bits of one session. `open` is called as
/// often as a rank needs a session of its own: once for its piece, once on the first rank. It and `ranks`
/// must outlive the session. Calls throw what Ranks throw, and InputError in the words of a session of one
/// rank: no other one could go on.
[[nodiscard]] std::unique_ptr<ElasticSession>
open_elastic_on_ranks(Ranks& ranks, const Sharing& sharing, const faults::RankFault& fault,
                      std::function<std::unique_ptr<ElasticSession>()> open);

} // namespace hdmbench
