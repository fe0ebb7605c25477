#include "harness/ranks/ranked_parts.hpp"

#include "harness/ranks/ranked_resampling.hpp"
#include "harness/ranks/ranked_sampling.hpp"
#include "harness/ranks/redistribution.hpp"
#include "harness/solve/methods/multigrid.hpp"
#include "harness/solve/stopwatch.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace hdmbench {

namespace {

void add(Traffic& sum, const Traffic& traffic) {
  sum.messages += traffic.messages;
  sum.bytes += traffic.bytes;
  sum.seconds += traffic.seconds;
}

/// Columns in pairs: of numbers that go in two floats each.
std::vector<Rectangle> doubled(std::vector<Rectangle> parts) {
  for (Rectangle& part : parts) {
    part.left *= 2;
    part.width *= 2;
  }
  return parts;
}

/// The sites `part` of a field that has those of `loaded`, a double in two floats.
std::vector<float> as_floats(const std::vector<double>& values, const Rectangle& loaded,
                             const Rectangle& part) {
  std::vector<float> floats(2 * part.extent().sites());
  if (!floats.empty()) {
    std::memcpy(floats.data(), values.data() + loaded.extent().index(0, part.top - loaded.top),
                floats.size() * sizeof(float));
  }
  return floats;
}

VectorField owned_part(const VectorField& field, const Rectangle& loaded, const Rectangle& owned) {
  VectorField part(owned.extent());
  copy(owned, field, loaded, part, owned);
  return part;
}

} // namespace

RankedParts::RankedParts(Extent image, const Sharing& sharing, Ranks& ranks, Exchange& halos)
    : image_(image), sharing_(sharing), ranks_(ranks), halos_(halos),
      rank_(static_cast<std::size_t>(ranks.rank())) {}

Traffic RankedParts::since(const Traffic& before) const {
  const Traffic now = ranks_.traffic();
  return {now.messages - before.messages, now.bytes - before.bytes, now.seconds - before.seconds};
}

const LevelShare& RankedParts::share(Extent level) const {
  const auto known = shares_.find(level);
  return known != shares_.end() ? known->second : shares_.emplace(level, sharing_(level)).first->second;
}

LevelPart RankedParts::part(Extent level) const {
  const LevelShare& of_level = share(level);
  return {.level = level, .owned = of_level.owned[rank_], .loaded = of_level.loaded[rank_]};
}

Level RankedParts::sample(const Level& image, Extent level, Alignment alignment, Material material) const {
  return RankedSampling(ranks_, halos_, rank_, image_, share(image_), level, share(level),
                        alignment)(image, material);
}

VectorField RankedParts::sample(const VectorField& image, Extent level, Alignment alignment) const {
  return RankedSampling(ranks_, halos_, rank_, image_, share(image_), level, share(level), alignment)(image);
}

void RankedParts::renew(Extent level, VectorField& field) const {
  const LevelShare& of_level = share(level);
  if (of_level.cut.pieces.size() == 1) {
    return;
  }
  const Traffic before = ranks_.traffic();
  field = redistribute(halos_, rank_, of_level.owned, of_level.loaded,
                       owned_part(field, of_level.loaded[rank_], of_level.owned[rank_]));
  ++sent_[level].renewals;
  add(sent_[level].halos, since(before));
}

void RankedParts::renew(Extent level, DoubleField& field) const {
  const LevelShare& of_level = share(level);
  if (of_level.cut.pieces.size() == 1) {
    return;
  }
  const Traffic before = ranks_.traffic();
  VectorField own; // doubles in pairs of floats
  own.extent = doubled({of_level.owned[rank_]}).front().extent();
  own.x = as_floats(field.x, of_level.loaded[rank_], of_level.owned[rank_]);
  own.y = as_floats(field.y, of_level.loaded[rank_], of_level.owned[rank_]);
  const VectorField all = redistribute(halos_, rank_, doubled(of_level.owned), doubled(of_level.loaded), own);
  if (!field.x.empty()) {
    std::memcpy(field.x.data(), all.x.data(), all.x.size() * sizeof(float));
    std::memcpy(field.y.data(), all.y.data(), all.y.size() * sizeof(float));
  }
  ++sent_[level].renewals;
  add(sent_[level].halos, since(before));
}

VectorField RankedParts::to_coarser(Extent fine, Extent coarse, Alignment alignment, VectorField rows) const {
  const Traffic before = ranks_.traffic();
  std::vector<Rectangle> held;
  for (const Rectangle& owned : share(fine).owned) {
    held.push_back(rows_restricted(fine, owned, coarse, alignment));
  }
  VectorField result = redistribute(halos_, rank_, held, share(coarse).loaded, rows);
  add(sent_[coarse].between, since(before));
  return result;
}

VectorField RankedParts::to_finer(Extent coarse, Extent fine, Alignment alignment,
                                  const VectorField& field) const {
  const Traffic before = ranks_.traffic();
  const LevelShare& from = share(coarse);
  const LevelShare& to = share(fine);
  const RankedProjection projection(coarse, fine, alignment);
  std::vector<Rectangle> wanted;
  for (const Rectangle& loaded : to.loaded) {
    wanted.push_back(projection.sites(loaded));
  }
  VectorField result = projection(redistribute(halos_, rank_, from.owned, wanted,
                                               owned_part(field, from.loaded[rank_], from.owned[rank_])),
                                  to.loaded[rank_]);
  add(sent_[fine].between, since(before));
  return result;
}

double RankedParts::sum(Extent level, std::span<const double> rows) const {
  const Traffic before = ranks_.traffic();
  const LevelShare& of_level = share(level);
  const auto column = [](const Rectangle& part) {
    return Rectangle{.left = 0, .top = part.top, .width = part.height > 0 ? 2 : 0, .height = part.height};
  };
  std::vector<Rectangle> held;
  std::ranges::transform(of_level.owned, std::back_inserter(held), column);
  std::vector<Rectangle> all(held.size());
  all.front() = column(all_of(level));
  std::vector<float> own(held[rank_].extent().sites());
  if (!own.empty()) {
    std::memcpy(own.data(), rows.data() + (held[rank_].top - of_level.loaded[rank_].top),
                own.size() * sizeof(float));
  }
  const std::vector<float> gathered = redistribute(halos_, rank_, held, all, own);
  std::vector<double> values(gathered.size() / 2);
  if (!values.empty()) {
    std::memcpy(values.data(), gathered.data(), gathered.size() * sizeof(float));
  }
  const double sum = whole_image().sum(level, values);
  add(sent_[level].between, since(before));
  return std::bit_cast<double>(halos_.sum(ranks_.is_first() ? std::bit_cast<std::int64_t>(sum) : 0));
}

RankedSolution solve_cycles_on_ranks(ScenePart part, const Backend& backend, const SessionOptions& options,
                                     const Sharing& sharing, Ranks& ranks, Exchange& halos,
                                     Progress& progress) {
  const Clock clock;
  const Extent image = part.scene.extent();
  Scene scene = part.scene;
  const Level schedule = scene.full; // what the command line may have changed
  scene.full = std::move(part.full);
  scene.full.penalty = schedule.penalty;
  scene.full.steps = schedule.steps;
  scene.full.update = schedule.update;
  scene.start = std::move(part.start);
  const RankedParts parts(image, sharing, ranks, halos);
  CycleSolution solved = solve_on_parts(scene, backend, options, parts, progress);
  const LevelPart own = parts.part(image);
  RankedSolution solution{.owned = own.owned,
                          .displacement = owned_part(solved.displacement, own.loaded, own.owned),
                          .levels = {},
                          .residual = solved.residual};
  for (const LevelResult& work : solved.levels) {
    const LevelShare& share = parts.share(work.extent);
    const RankedParts::Sent& sent = parts.sent(work.extent);
    solution.levels.push_back({.extent = work.extent,
                               .pieces = share.cut.pieces.size(),
                               .halo = share.cut.pieces.size() > 1 ? share.cut.halo : 0,
                               .sweeps = work.iterations * sweeps_per_iteration(scene.full),
                               .renewals = sent.renewals,
                               .before = sent.between,
                               .halos = sent.halos});
  }
  solution.levels.back().seconds = clock.seconds();
  return solution;
}

} // namespace hdmbench
