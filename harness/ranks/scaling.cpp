#include "harness/ranks/scaling.hpp"

#include "harness/solve/stopwatch.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// Seconds of the slowest rank for one exchange of `sites` floats between the first two, both ways; the
/// median of several.
double exchange_seconds(Ranks& ranks, int sites, int repeats) {
  const std::vector<Transfer> ways{{0, 1, {.width = sites, .height = 1}},
                                   {1, 0, {.width = sites, .height = 1}}};
  std::vector<double> samples;
  for (int i = 0; i < repeats; ++i) {
    std::vector<Parcel> leaving;
    for (const Transfer& way : ways) {
      if (ranks.is_here(way.from)) {
        leaving.push_back({.way = way, .values = std::vector<float>(way.sites.extent().sites())});
      }
    }
    const Clock clock;
    (void)ranks.exchange(ways, std::move(leaving), 1);
    samples.push_back(clock.seconds());
  }
  std::ranges::nth_element(samples, samples.begin() + repeats / 2);
  return ranks.largest(ranks.rank() < 2 ? samples[static_cast<std::size_t>(repeats / 2)] : 0.0);
}

/// Of the slowest rank, all at once.
template <typename Call>
double slowest(Ranks& ranks, const Call& call) {
  (void)ranks.largest(0.0); // all begin together
  const Clock clock;
  call();
  return ranks.largest(clock.seconds());
}

} // namespace

RankRates measure_rates(const Level& sample, Session& session, Ranks& ranks) {
  constexpr int sweeps = 20;
  const auto sites = static_cast<double>(sample.extent.sites());
  VectorField field(sample.extent);
  session.load(sample); // the first time is slower: shaders are compiled, memory is new
  session.write(field);
  session.step(2);
  RankRates rates;
  rates.load = sites / slowest(ranks, [&] { session.load(sample); });
  session.write(field);
  rates.sweep = sweeps * sites / slowest(ranks, [&] { session.step(sweeps); });
  rates.copy = sites / slowest(ranks, [&] {
                 session.read(field);
                 session.write(field);
               });
  constexpr int large = 1 << 20;
  rates.latency = exchange_seconds(ranks, 1, 201);
  rates.bandwidth = large * sizeof(float) / exchange_seconds(ranks, large, 21);
  return rates;
}

double predicted_seconds(std::span<const PyramidLevel> levels, const Sharing& sharing,
                         const RankRates& rates) {
  double seconds = 0.0;
  for (const PyramidLevel& level : levels) {
    const Cut cut = sharing(level.extent).cut;
    const auto pieces = static_cast<int>(cut.pieces.size());
    double sites = 0.0;
    double halo_bytes = 0.0;
    for (const Piece& piece : cut.pieces) {
      const auto loaded = static_cast<double>(piece.loaded.extent().sites());
      sites = std::max(sites, loaded);
      halo_bytes = std::max(halo_bytes, 2.0 * sizeof(float) *
                                            (loaded - static_cast<double>(piece.owned.extent().sites())));
    }
    const int columns = std::min(cut.columns, 3);
    const int rows = std::min(pieces / cut.columns, 3);
    const double messages = columns * rows - 1; // of a piece in the middle
    const double renewals = pieces > 1 ? std::ceil(static_cast<double>(level.sweeps) / cut.halo) - 1.0 : 0.0;
    seconds += sites / rates.load + sites / rates.copy + level.sweeps * sites / rates.sweep +
               std::max(0.0, renewals) *
                   (sites / rates.copy + messages * rates.latency + halo_bytes / rates.bandwidth);
  }
  return seconds;
}

} // namespace hdmbench
