#pragma once

#include "harness/scene/scene.hpp"

namespace hdmbench {

/// One level, for `ranks` >= 2 of them: every piece but the first sleeps, until a renewal brings a change
/// that it has to wake for. One site is pulled, just outside the halos of the other pieces, and what it pulls
/// along crosses into the halo before the first renewal and into a piece's own sites soon after. So a check
/// with Work::active sees tiles that sleep through a renewal. 124 x 120 sites: renewals are as frequent as
/// they can be, and on up to 4 ranks all backends but the fragment path, which visits small levels whole,
/// leave tiles out.
[[nodiscard]] Scene sleeping_pieces(int ranks);

} // namespace hdmbench
