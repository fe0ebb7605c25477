#pragma once

#include "harness/ranks/ranked_solution.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// Measured now, on all ranks at once, with a session that nobody uses; takes some milliseconds. Collective.
/// At least two ranks.
[[nodiscard]] HaloCosts measure_halo_costs(Session& session, Ranks& ranks);

/// What a rank was measured to do on a piece of so many sites.
struct PieceRates {
  double sites = 0.0;
  double sweep = 0.0;   ///< sites a second
  double sample = 0.0;  ///< sites a second, of a level's fields from the image's
  double project = 0.0; ///< sites a second, of a displacement from the level before
  double load = 0.0;    ///< sites a second, of a level's fields into the session
  double copy = 0.0;    ///< sites a second, of the displacement out of the session and into it again
};

struct RankRates {
  std::vector<PieceRates> pieces; ///< the largest first: what fits into a cache is faster
  HaloCosts halos;                ///< for what a renewal takes

  /// Of the piece whose size is the nearest.
  [[nodiscard]] const PieceRates& of(double sites) const;
};

/// Who computes while rates are measured: ranks of one machine share its memory and its processors' caches.
enum class AtWork {
  all,  ///< the rates are the slowest rank's
  first ///< alone
};

/// Measured now, with sweeps over `sample` and smaller parts of it on the session of every rank; the best of
/// several. Collective. At least two ranks.
[[nodiscard]] RankRates measure_rates(const Level& sample, Session& session, Ranks& ranks, AtWork at_work);

/// Seconds of a pyramid on so many ranks. A level of the pieces' largest l sites with their halo, S sweeps
/// and a halo of h, which is renewed n = ceil(S / h) - 1 times, takes
///   l / sample + l / project + l / load + l / copy + S l / sweep + n renewal_seconds(rates.halos, cut)
/// by the rates of a piece of l sites. The image is not sampled. What brings a level to other ranks is not
/// counted.
[[nodiscard]] double predicted_seconds(std::span<const PyramidLevel> levels, const Sharing& sharing,
                                       const RankRates& rates);

} // namespace hdmbench
