#include "harness/ranks/scaling.hpp"

#include "backends/shared/fastest_way.hpp"
#include "harness/ranks/ranked_resampling.hpp"
#include "harness/solve/stopwatch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

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
template <int repeats = 9, typename Call>
double slowest(Ranks& ranks, AtWork at_work, const Call& call) {
  std::array<double, repeats> samples{};
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
  const Rectangle all = all_of(level);
  for (const auto* const values : {&image.target.x, &image.target.y, &image.confidence.x, &image.confidence.y,
                                   &image.modulus.values, &image.inverse_modulus.values}) {
    std::vector<float> sampled(level.sites());
    sampler(all, *values, all_of(image.extent), sampled, all);
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

HaloCosts measure_halo_costs(Session& session, Ranks& ranks) {
  constexpr Extent extent{256, 256};
  constexpr int sweeps = 8;
  constexpr int narrow = 4;
  constexpr int wide = 64;
  constexpr int few = 3;
  const Level level = measured_level(extent, 10.0F);
  VectorField field(extent);
  std::iota(field.x.begin(), field.x.end(), 0.0F); // so that sites move
  session.load(level);
  session.write(field);
  session.step(sweeps); // the first time is slower
  HaloCosts costs;
  costs.site = slowest<few>(ranks, AtWork::all, [&] { session.step(sweeps); }) /
               (sweeps * static_cast<double>(extent.sites()));
  const auto rim_seconds = [&](int rows) {
    const std::size_t sites = extent.index(0, rows);
    const FieldPart part{{.width = extent.width, .height = rows},
                         std::span(field.x).first(sites),
                         std::span(field.y).first(sites)};
    return slowest<few>(ranks, AtWork::all, [&] {
      session.read_parts(std::span(&part, 1));
      session.write_parts(std::span(&part, 1));
    });
  };
  const double of_narrow = rim_seconds(narrow);
  costs.rim = std::max(0.0, rim_seconds(wide) - of_narrow) / (extent.width * (wide - narrow));
  costs.piece =
      std::max(0.0, of_narrow - costs.rim * extent.width * narrow) / static_cast<double>(extent.sites());
  constexpr int large = 1 << 18;
  costs.message = exchange_seconds(ranks, 1, 101);
  costs.byte = std::max(0.0, exchange_seconds(ranks, large, 9) - costs.message) / (large * sizeof(float));
  return costs;
}

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
  rates.halos = measure_halo_costs(session, ranks);
  return rates;
}

double predicted_seconds(std::span<const PyramidLevel> levels, const Sharing& sharing,
                         const RankRates& rates) {
  double seconds = 0.0;
  for (const PyramidLevel& level : levels) {
    const Cut cut = sharing(level.extent).cut;
    double sites = 0.0;
    for (const Piece& piece : cut.pieces) {
      sites = std::max(sites, static_cast<double>(piece.loaded.extent().sites()));
    }
    const double renewals = cut.pieces.size() > 1 && level.sweeps > 0
                                ? std::ceil(static_cast<double>(level.sweeps) / cut.halo) - 1.0
                                : 0.0;
    const PieceRates& piece = rates.of(sites);
    seconds += level.extent == levels.back().extent ? 0.0 : sites / piece.sample;
    seconds += sites / piece.project + sites / piece.load + sites / piece.copy +
               level.sweeps * sites / piece.sweep + renewals * renewal_seconds(rates.halos, cut);
  }
  return seconds;
}

} // namespace hdmbench
