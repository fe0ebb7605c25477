#include "harness/ranks/ranked_elastic.hpp"

#include "harness/ranks/elastic_cells.hpp"
#include "harness/ranks/redistribution.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace hdmbench {

namespace {

/// Counts what call() sends.
template <typename Call>
void counted(const Ranks& ranks, RankedElastic::Sent& sent, const Call& call) {
  const Traffic before = ranks.traffic();
  call();
  const Traffic after = ranks.traffic();
  ++sent.times;
  sent.traffic.messages += after.messages - before.messages;
  sent.traffic.bytes += after.bytes - before.bytes;
  sent.traffic.seconds += after.seconds - before.seconds;
}

std::vector<float> both(const VectorField& field) {
  std::vector<float> values = field.x;
  values.insert(values.end(), field.y.begin(), field.y.end());
  return values;
}

VectorField apart(const std::vector<float>& values, Extent extent) {
  VectorField field;
  field.extent = extent;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(extent.sites());
  field.x.assign(values.begin(), middle);
  field.y.assign(middle, values.end());
  return field;
}

} // namespace

RankedElastic::RankedElastic(ElasticShare share, Ranks& ranks, Exchange& halos, const Open& open)
    : share_(std::move(share)), ranks_(ranks), halos_(halos), rank_(static_cast<std::size_t>(ranks.rank())),
      valid_(share_.shares.size()), sent_(share_.shares.size()) {
  if (share_.cut_levels() > 0 && rank_ < share_.image().cut.pieces.size()) {
    piece_ = open();
  }
  if (ranks.is_first()) {
    coarse_ = open();
  }
  for (const LevelShare& level : share_.shares) {
    ways_.push_back(halo_transfers(level.cut));
  }
}

void RankedElastic::load(const Level& part, double poisson, Springs springs) {
  if (share_.cut_levels() == 0) {
    if (coarse_ != nullptr) {
      coarse_sheet_ = make_elastic_hierarchy(part, poisson, springs);
      coarse_->load(coarse_sheet_);
    }
    return;
  }
  ElasticPart made;
  if (piece_ != nullptr) {
    made = make_elastic_part(part, poisson, springs, static_cast<int>(share_.shares.size()));
  }
  std::optional<ElasticHierarchy> coarse =
      gather_coarse_levels(made, share_, ElasticInFloat::poisson_ratio(poisson), ranks_);
  if (piece_ != nullptr) {
    piece_sheet_ = std::move(made.hierarchy);
    piece_->load(piece_sheet_);
  }
  if (coarse) {
    coarse_sheet_ = std::move(*coarse);
    coarse_->load(coarse_sheet_);
  }
  for (int level = 0; level < share_.cut_levels(); ++level) {
    valid_[static_cast<std::size_t>(level)].fill(halo(level)); // 0 everywhere
  }
}

Rectangle RankedElastic::owned(int level) const {
  if (share_.is_cut(level)) {
    return share_.share(level).owned[rank_];
  }
  return coarse_ != nullptr ? all_of(share_.levels.at(static_cast<std::size_t>(level))) : Rectangle{};
}

int& RankedElastic::valid(int level, ElasticField field) {
  return valid_.at(static_cast<std::size_t>(level)).at(static_cast<std::size_t>(field));
}

Rectangle RankedElastic::local(int level, Rectangle part) const {
  if (level <= share_.cut_levels()) {
    const Rectangle& loaded = share_.share(level).loaded[rank_];
    part.left -= loaded.left;
    part.top -= loaded.top;
  }
  return part;
}

void RankedElastic::want(int level, ElasticField field, int sites) {
  if (valid(level, field) >= sites) {
    return;
  }
  valid(level, field) = halo(level);
  counted(ranks_, sent_[static_cast<std::size_t>(level)], [&] {
    const std::vector<Transfer>& ways = ways_[static_cast<std::size_t>(level)];
    std::vector<Parcel> leaving;
    for (const Transfer& way : ways) {
      if (way.from == rank_) {
        VectorField rim;
        piece_->read_part(level, field, local(level, way.sites), rim);
        leaving.push_back({way, both(rim)});
      }
    }
    for (const Parcel& parcel : halos_.exchange(ways, std::move(leaving), 2)) {
      piece_->write_part(level, field, local(level, parcel.way.sites),
                         apart(parcel.values, parcel.way.sites.extent()));
    }
  });
}

void RankedElastic::write(int level, ElasticField field, const VectorField& values) {
  if (share_.is_cut(level)) {
    valid(level, field) = 0;
  }
  if (ElasticSession* const session = computing(level)) {
    session->write_part(level, field, local(level, owned(level)), values);
  }
}

void RankedElastic::read(int level, ElasticField field, VectorField& values) const {
  values = VectorField(owned(level).extent());
  if (const ElasticSession* const session = computing(level)) {
    session->read_part(level, field, local(level, owned(level)), values);
  }
}

void RankedElastic::relax(int level, ElasticField field) {
  if (share_.is_cut(level)) {
    want(level, field, 1);
    int& now = valid(level, field);
    now = field == ElasticField::correction ? std::min(now - 1, valid(level, ElasticField::load)) : now - 1;
  }
  if (ElasticSession* const session = computing(level)) {
    session->relax(level, field);
  }
}

void RankedElastic::relax_from_zero(int level) {
  if (share_.is_cut(level)) { // what a site on the outermost rim responds is not known
    valid(level, ElasticField::correction) = std::min(valid(level, ElasticField::load), halo(level) - 1);
  }
  if (ElasticSession* const session = computing(level)) {
    session->relax_from_zero(level);
  }
}

void RankedElastic::forces(ElasticField of, ElasticField to) {
  if (share_.is_cut(0)) {
    want(0, of, 1);
    valid(0, to) = valid(0, of) - 1;
  }
  if (ElasticSession* const session = computing(0)) {
    session->forces(of, to);
  }
}

void RankedElastic::restrict_residual(int level, ElasticField of) {
  int residual = 0;
  if (share_.is_cut(level)) {
    // A coarse site takes the residual of the sites around it, which takes the field around these.
    want(level, of, 2);
    residual = valid(level, of) - 1;
    if (of == ElasticField::correction) {
      want(level, ElasticField::load, 1);
      residual = std::min(residual, valid(level, ElasticField::load));
    }
  }
  if (ElasticSession* const session = computing(level)) {
    session->restrict_residual(level, of);
  }
  restricted(level, residual);
}

void RankedElastic::restrict_load(int level) {
  int load = 0;
  if (share_.is_cut(level)) {
    want(level, ElasticField::load, 1);
    load = std::min(valid(level, ElasticField::load), halo(level) - 1);
  }
  if (ElasticSession* const session = computing(level)) {
    session->restrict_load(level);
  }
  restricted(level, load);
}

void RankedElastic::restricted(int level, int sites) {
  if (share_.is_cut(level + 1)) {
    valid(level + 1, ElasticField::load) = (sites - 1) / 2;
  } else if (share_.is_cut(level)) {
    send_load();
  }
}

void RankedElastic::send_load() {
  const int level = share_.cut_levels();
  const LevelShare& share = share_.share(level);
  counted(ranks_, sent_.back(), [&] {
    VectorField own(share.owned[rank_].extent());
    if (piece_ != nullptr) {
      piece_->read_part(level, ElasticField::load, local(level, share.owned[rank_]), own);
    }
    const VectorField whole =
        redistribute(halos_, rank_, share.owned,
                     all_on_first(share_.levels[static_cast<std::size_t>(level)], ranks_.size()), own);
    if (coarse_ != nullptr) {
      coarse_->write(level, ElasticField::load, whole);
    }
  });
}

int RankedElastic::bring_correction(int level) {
  if (share_.is_cut(level + 1)) {
    want(level + 1, ElasticField::correction, 1);
    return 2 * valid(level + 1, ElasticField::correction) - 1;
  }
  const LevelShare& share = share_.share(level + 1);
  counted(ranks_, sent_.back(), [&] {
    const Extent sites = share_.levels[static_cast<std::size_t>(level) + 1];
    VectorField whole(coarse_ != nullptr ? sites : Extent{});
    if (coarse_ != nullptr) {
      coarse_->read(level + 1, ElasticField::correction, whole);
    }
    const VectorField part =
        redistribute(halos_, rank_, all_on_first(sites, ranks_.size()), share.loaded, whole);
    if (piece_ != nullptr) {
      piece_->write(level + 1, ElasticField::correction, part);
    }
  });
  return 2 * share.cut.halo - 1;
}

void RankedElastic::interpolate(int level) {
  if (share_.is_cut(level)) {
    valid(level, ElasticField::correction) = bring_correction(level);
  }
  if (ElasticSession* const session = computing(level)) {
    session->interpolate(level);
  }
}

void RankedElastic::correct(int level, ElasticField field) {
  if (share_.is_cut(level)) {
    const int brought = bring_correction(level);
    valid(level, field) = std::min(valid(level, field), brought);
  }
  if (ElasticSession* const session = computing(level)) {
    session->correct(level, field);
  }
}

void RankedElastic::solve_coarsest() {
  if (coarse_ != nullptr) {
    coarse_->solve_coarsest();
  }
}

void RankedElastic::advance(ElasticField to, ElasticField value, float factor, ElasticField direction) {
  if (share_.is_cut(0)) {
    valid(0, to) = std::min(valid(0, value), valid(0, direction));
  }
  if (ElasticSession* const session = computing(0)) {
    session->advance(to, value, factor, direction);
  }
}

float RankedElastic::dot(ElasticField first, ElasticField second) const {
  const int height = share_.cut_levels();
  if (height == 0) {
    return value_of_first(coarse_ != nullptr ? coarse_->dot(first, second) : 0.0F);
  }
  const auto squares = [&](const Rectangle& sites) {
    const auto up = [&](int side) { return (side + (1 << height) - 1) >> height; };
    return Rectangle{.left = sites.left >> height,
                     .top = sites.top >> height,
                     .width = up(sites.width),
                     .height = up(sites.height)};
  };
  float sum = 0.0F;
  counted(ranks_, sums_, [&] {
    std::vector<Rectangle> held;
    std::ranges::transform(share_.image().owned, std::back_inserter(held), squares);
    const Extent all = squares(all_of(share_.levels.front())).extent();
    ScalarField own;
    if (piece_ != nullptr) {
      own = part_of(piece_->dot_squares(first, second, height), squares(local(0, owned(0))));
    }
    ScalarField sums;
    sums.extent = all;
    sums.values = redistribute(halos_, rank_, held, all_on_first(all, ranks_.size()), own.values);
    while (coarse_ != nullptr && sums.extent.sites() > 1) {
      sums = square_sums(sums);
    }
    sum = value_of_first(coarse_ != nullptr ? sums.values.front() : 0.0F);
  });
  return sum;
}

float RankedElastic::value_of_first(float value) const {
  const std::int64_t bits = coarse_ != nullptr ? std::bit_cast<std::uint32_t>(value) : 0;
  return std::bit_cast<float>(static_cast<std::uint32_t>(halos_.sum(bits)));
}

} // namespace hdmbench
