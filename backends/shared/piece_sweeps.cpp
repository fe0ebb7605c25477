#include "backends/shared/piece_sweeps.hpp"

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

std::span<float> component(Parcel& parcel, std::size_t number) {
  const std::size_t sites = parcel.way.sites.extent().sites();
  return std::span(parcel.values).subspan(number * sites, sites);
}

Parcel parcel_of(const Transfer& way, const VectorField& field, const Rectangle& sites) {
  Parcel parcel{.way = way, .values = std::vector<float>(2 * way.sites.extent().sites())};
  copy(way.sites, field.x, sites, component(parcel, 0), way.sites);
  copy(way.sites, field.y, sites, component(parcel, 1), way.sites);
  return parcel;
}

void unpack(Parcel& parcel, VectorField& field, const Rectangle& sites) {
  copy(parcel.way.sites, component(parcel, 0), parcel.way.sites, field.x, sites);
  copy(parcel.way.sites, component(parcel, 1), parcel.way.sites, field.y, sites);
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

/// In two passes, so that a process holds one piece and the rims of all, never the image.
void PieceSweeps::renew_halos() {
  if (sweeps_left_ > 0) {
    return;
  }
  sweeps_left_ = cut_.halo;
  if (ways_.empty()) { // one piece needs no halo
    return;
  }
  std::vector<Parcel> leaving;
  VectorField field;
  for (const Transfer& way : ways_) {
    const auto own = std::ranges::find(own_, way.from, &Own::piece);
    if (own != own_.end()) {
      const bool is_read = !leaving.empty() && leaving.back().way.from == way.from;
      if (!is_read) {
        own->session->read(field);
      }
      leaving.push_back(parcel_of(way, field, piece(*own).loaded));
    }
  }
  std::vector<Parcel> arrived = exchange_->exchange(ways_, std::move(leaving), 2);
  for (const Own& own : own_) {
    if (own_.size() > 1) { // else `field` is still its own
      own.session->read(field);
    }
    for (Parcel& parcel : arrived) {
      if (parcel.way.to == own.piece) {
        unpack(parcel, field, piece(own).loaded);
      }
    }
    own.session->write(field);
  }
  ++renewals_;
}

} // namespace hdmbench
