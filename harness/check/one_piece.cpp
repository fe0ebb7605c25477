#include "harness/check/one_piece.hpp"

#include "harness/check/compare.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

constexpr std::size_t plain = 0; // of SessionOptions::variant

void judge(const ReferenceStep& end, const Follower& follower, const VectorField& found, std::int64_t changed,
           Comparison& comparison) {
  const FieldDifference difference = compare(end.after, found);
  const bool explained = difference.sites > 0 && follower.comparison().uncertified == 0 &&
                         follower.comparison().not_finite == 0 &&
                         compare(follower.displacement(), found).sites == 0;
  if (explained) {
    comparison.largest_gap_over_bound =
        std::max(comparison.largest_gap_over_bound, follower.comparison().largest_gap_over_bound);
  }
  if (explained || difference.sites == 0) {
    const std::int64_t expected = explained ? follower.last_changed() : end.changed;
    comparison.counts_differing += changed == expected ? 0 : 1;
  }
  count_end(comparison, difference, found.extent, explained,
            [&](std::size_t site) { return describe_difference(end, end.after, end.after, found, site); });
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
