#include "harness/check/one_piece.hpp"

#include "harness/check/compare.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

constexpr std::size_t plain = 0; // of SessionOptions::variant

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

/// Those that compute this pyramid otherwise than the plain way, and that one; none where there is no other.
std::vector<std::size_t> variants_to_compare(const Pyramid& pyramid, const Variants& variants) {
  std::vector<std::size_t> found;
  for (std::size_t variant = 0; variant < variants.worth_trying; ++variant) {
    if (variant == plain || variants.concerns(pyramid, variant)) {
      found.push_back(variant);
    }
  }
  return found.size() > 1 ? found : std::vector<std::size_t>{};
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
  const Variants variants = options.variant ? Variants{} : backend.variants(options);
  for (const std::size_t variant : variants_to_compare(pyramid, variants)) {
    comparison.coarse_levels.push_back(variants.names[variant]);
    for (const Follower& follower : followers) {
      SessionOptions varied = options;
      varied.variant = variant;
      varied.work = follower.comparison().mode == Mode::active ? Work::active : Work::dense;
      if (variant != plain) { // which is what the followers' sessions did
        solve(*backend.open(varied), follower, 1);
      }
    }
  }
  return comparison;
}

} // namespace hdmbench
