#include "harness/agreement/one_piece.hpp"

#include "backends/coarse_levels.hpp"
#include "harness/agreement/compare.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

constexpr int apart = 0; // of SessionOptions::coarse_group

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

/// Those that compute a level of this pyramid together, and 0; none where there is one way only.
std::vector<int> coarse_groups_to_compare(const Pyramid& pyramid, const Backend& backend,
                                          const SessionOptions& options) {
  if (options.coarse_group || coarse_level_count(pyramid, coarse_group_sizes.back()) == 0) {
    return {};
  }
  std::vector<int> groups = backend.coarse_groups(options);
  std::erase_if(groups, [&](int group) { return group > 0 && coarse_level_count(pyramid, group) == 0; });
  return groups.size() > 1 ? groups : std::vector<int>{};
}

} // namespace

Comparison compare_in_one_piece(const Pyramid& pyramid, const ReferenceStep& end,
                                std::span<Follower> followers, const Backend& backend,
                                const SessionOptions& options) {
  const Comparison& followed = followers.front().comparison();
  Comparison comparison{.backend = followed.backend,
                        .device = followed.device,
                        .mode = Mode::pyramid,
                        .levels = followed.levels,
                        .iterations = followed.iterations,
                        .sweeps = followed.sweeps,
                        .reason = followed.reason};
  if (followers.front().session() == nullptr) {
    return comparison;
  }
  const auto solve = [&](Session& session, const Follower& follower, int solutions) {
    session.load(pyramid);
    VectorField found;
    for (int i = 0; i < solutions; ++i) {
      session.solve();
      session.read(found);
      judge(end, follower, found, session.changed(), comparison);
    }
  };
  for (Follower& follower : followers) {
    solve(*follower.session(), follower, &follower == &followers.back() ? 2 : 1);
  }
  for (const int group : coarse_groups_to_compare(pyramid, backend, options)) {
    comparison.coarse_levels.push_back(coarse_group_name(group));
    for (const Follower& follower : followers) {
      SessionOptions grouped = options;
      grouped.coarse_group = group;
      grouped.work = follower.comparison().mode == Mode::active ? Work::active : Work::dense;
      if (group != apart) { // which is what the followers' sessions did
        solve(*backend.open(grouped), follower, 1);
      }
    }
  }
  return comparison;
}

} // namespace hdmbench
