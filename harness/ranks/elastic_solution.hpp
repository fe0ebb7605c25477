#pragma once

#include "harness/ranks/ranked_elastic.hpp"
#include "harness/solve/progress.hpp"

namespace hdmbench {

/// The extended conditions (kernels/data/elastic/conditions.hpp) of the sites that this rank owns, from the
/// part that it loads. Collective.
[[nodiscard]] VectorField extended_conditions_on_ranks(const Level& part, const ElasticShare& share,
                                                       Ranks& ranks);

/// The scene by the method that its schedule names: solve_elastic() on ranks, whose bits it has. `part` has
/// the sites that this rank loads, steps.share().image(). Collective. RankedLevel::sweeps do not count
/// residuals; `halos` of the finest level that is not cut what went to the first rank and back. Throws
/// InputError where no condition holds the sheet, or there is void in it, which only one rank can judge.
[[nodiscard]] RankedSolution solve_elastic_on_ranks(const ScenePart& part, RankedElastic& steps, Ranks& ranks,
                                                    Progress& progress);

} // namespace hdmbench
