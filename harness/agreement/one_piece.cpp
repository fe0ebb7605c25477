#include "harness/agreement/one_piece.hpp"

#include "harness/agreement/compare.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

void judge(const ReferenceStep& end, const Follower& follower, const VectorField& found, std::int64_t changed,
           Comparison& comparison) {
  const FieldDifference difference = compare(end.after, found);
  comparison.sites_compared += static_cast<std::int64_t>(found.extent.sites());
  comparison.sites_differing += difference.sites;
  comparison.sites_drifted += difference.sites;
  comparison.not_finite += difference.not_finite;
  comparison.largest_difference = std::max(comparison.largest_difference, difference.largest);
  if (difference.sites == 0) {
    comparison.counts_differing += changed == end.changed ? 0 : 1;
    return;
  }
  const bool explained = follower.comparison().uncertified == 0 && follower.comparison().not_finite == 0 &&
                         compare(follower.displacement(), found).sites == 0;
  if (explained) {
    comparison.certified_ties += difference.sites;
    comparison.largest_gap_over_bound =
        std::max(comparison.largest_gap_over_bound, follower.comparison().largest_gap_over_bound);
    comparison.counts_differing += changed == follower.last_changed() ? 0 : 1;
  }
  const bool first_failure = !explained && comparison.uncertified == 0;
  comparison.uncertified += explained ? 0 : difference.sites;
  if (first_failure || !comparison.first) {
    comparison.first = describe_difference(end, end.after, end.after, found, *difference.first);
    comparison.first->certificate.holds = explained;
  }
}

} // namespace

Comparison compare_in_one_piece(const Pyramid& pyramid, const ReferenceStep& end,
                                std::span<Follower> followers) {
  const Comparison& followed = followers.front().comparison();
  Comparison comparison{.backend = followed.backend,
                        .device = followed.device,
                        .mode = Mode::pyramid,
                        .levels = followed.levels,
                        .iterations = followed.iterations,
                        .sweeps = followed.sweeps,
                        .reason = followed.reason};
  VectorField found;
  for (Follower& follower : followers) {
    if (Session* const session = follower.session()) {
      const int solutions = &follower == &followers.back() ? 2 : 1;
      session->load(pyramid);
      for (int i = 0; i < solutions; ++i) {
        session->solve();
        session->read(found);
        judge(end, follower, found, session->changed(), comparison);
      }
    }
  }
  return comparison;
}

} // namespace hdmbench
