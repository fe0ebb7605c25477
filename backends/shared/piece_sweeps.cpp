#include "backends/shared/piece_sweeps.hpp"

#include <utility>

namespace hdmbench {

namespace {

/// Both components, as the session of `piece` numbers sites.
FieldPart part_of(Parcel& parcel, const Piece& piece) {
  const std::size_t sites = parcel.way.sites.extent().sites();
  const std::span<float> values = parcel.values;
  return {.sites = local(piece, parcel.way.sites), .x = values.first(sites), .y = values.last(sites)};
}

} // namespace

PieceSweeps::PieceSweeps(Cut cut, std::vector<Own> own, Exchange& exchange)
    : cut_(std::move(cut)), ways_(halo_transfers(cut_)), own_(std::move(own)), exchange_(&exchange) {}

void PieceSweeps::sweep(int sweeps) {
  while (sweeps > 0) {
    renew_halos();
    const int now = std::min(sweeps, sweeps_left_);
    for (const Own& own : own_) {
      own.session->step(now);
    }
    sweeps_left_ -= now;
    sweeps -= now;
  }
}

/// A session's own count has the halo in it, so the field is compared with the one before.
void PieceSweeps::sweep_and_count() {
  renew_halos();
  changed_ = 0;
  VectorField before;
  VectorField after;
  for (const Own& own : own_) {
    const auto& [owned, loaded] = piece(own);
    own.session->read(before);
    own.session->step(1);
    own.session->read(after);
    for (int y = owned.top; y < owned.top + owned.height; ++y) {
      const std::size_t first = loaded.extent().index(owned.left - loaded.left, y - loaded.top);
      for (std::size_t at = first; at < first + static_cast<std::size_t>(owned.width); ++at) {
        changed_ += before.x[at] != after.x[at] || before.y[at] != after.y[at] ? 1 : 0;
      }
    }
  }
  --sweeps_left_;
}

/// In two passes, so that a process holds the rims of its pieces, never the image.
void PieceSweeps::renew_halos() {
  if (sweeps_left_ > 0) {
    return;
  }
  sweeps_left_ = cut_.halo;
  if (ways_.empty()) { // one piece needs no halo
    return;
  }
  const auto parts_of = [&](const Own& own, std::vector<Parcel>& parcels, std::size_t Transfer::*end) {
    std::vector<FieldPart> parts;
    for (Parcel& parcel : parcels) {
      if (parcel.way.*end == own.piece) {
        parts.push_back(part_of(parcel, piece(own)));
      }
    }
    return parts;
  };
  std::vector<Parcel> leaving;
  for (const Transfer& way : ways_) {
    if (exchange_->is_here(way.from)) {
      leaving.push_back({.way = way, .values = std::vector<float>(2 * way.sites.extent().sites())});
    }
  }
  for (const Own& own : own_) {
    own.session->read_parts(parts_of(own, leaving, &Transfer::from));
  }
  std::vector<Parcel> arrived = exchange_->exchange(ways_, std::move(leaving), 2);
  for (const Own& own : own_) {
    own.session->write_parts(parts_of(own, arrived, &Transfer::to));
  }
}

} // namespace hdmbench
