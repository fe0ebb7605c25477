#include "harness/ranks/scaling.hpp"

#include "harness/ranks/ranked_resampling.hpp"
#include "harness/solve/stopwatch.hpp"

#include <algorithm>
#include <array>
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

/// Of the slowest rank, all at once; the best of several, as other work on the machine only adds.
template <typename Call>
double slowest(Ranks& ranks, AtWork at_work, const Call& call) {
  std::array<double, 9> samples{};
  for (double& sample : samples) {
    (void)ranks.largest(0.0); // all begin together
    const Clock clock;
    if (at_work == AtWork::all || ranks.is_first()) {
      call();
    }
    sample = ranks.largest(clock.seconds());
  }
  return std::ranges::min(samples);
}

// What RankedSolver makes of the image, and of the level before.
void sample(const Level& image, Extent level) {
  const RankedSampler sampler(image.extent, level, Alignment::corner);
  const Rectangle all = all_of(image.extent);
  for (const auto* const values : {&image.target.x, &image.target.y, &image.confidence.x, &image.confidence.y,
                                   &image.modulus.values, &image.inverse_modulus.values}) {
    (void)sampler(*values, all, all);
  }
}
void project(Extent level) {
  const Extent coarse{(level.width + 1) / 2, (level.height + 1) / 2};
  (void)RankedProjection(coarse, level, Alignment::corner)(VectorField(coarse), all_of(level));
}

PieceRates measure_piece(const Level& image, const Level& piece, Session& session, Ranks& ranks,
                         AtWork at_work) {
  constexpr int sweeps = 20;
  PieceRates rates{.sites = static_cast<double>(piece.extent.sites())};
  VectorField field(piece.extent);
  session.load(piece); // the first time is slower: shaders are compiled, memory is new
  session.write(field);
  session.step(2);
  rates.sample = rates.sites / slowest(ranks, at_work, [&] { sample(image, piece.extent); });
  rates.project = rates.sites / slowest(ranks, at_work, [&] { project(piece.extent); });
  rates.load = rates.sites / slowest(ranks, at_work, [&] { session.load(piece); });
  session.write(field);
  rates.sweep = sweeps * rates.sites / slowest(ranks, at_work, [&] { session.step(sweeps); });
  rates.copy = rates.sites / slowest(ranks, at_work, [&] {
                 session.read(field);
                 session.write(field);
               });
  return rates;
}

} // namespace

const PieceRates& RankRates::of(double sites) const {
  return *std::ranges::min_element(
      pieces, {}, [&](const PieceRates& piece) { return std::abs(std::log(piece.sites / sites)); });
}

RankRates measure_rates(const Level& sample, Session& session, Ranks& ranks, AtWork at_work) {
  RankRates rates;
  Rectangle part = all_of(sample.extent);
  // Down to pieces that no rank would get.
  constexpr double smallest = 4096.0;
  do {
    rates.pieces.push_back(measure_piece(sample, part_of(sample, part), session, ranks, at_work));
    part.width = (part.width + 1) / 2;
    part.height = (part.height + 1) / 2;
  } while (-ranks.largest(-static_cast<double>(part.extent().sites())) >= smallest);
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
    const PieceRates& piece = rates.of(sites);
    seconds += level.extent == levels.back().extent ? 0.0 : sites / piece.sample;
    seconds += sites / piece.project + sites / piece.load + sites / piece.copy +
               level.sweeps * sites / piece.sweep +
               std::max(0.0, renewals) *
                   (sites / piece.copy + messages * rates.latency + halo_bytes / rates.bandwidth);
  }
  return seconds;
}

} // namespace hdmbench
