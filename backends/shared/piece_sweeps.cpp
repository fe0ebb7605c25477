#include "backends/shared/piece_sweeps.hpp"

#include <utility>

namespace hdmbench {

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

/// One piece after the other, so that a process never holds the image.
void PieceSweeps::renew_halos() {
  if (sweeps_left_ > 0) {
    return;
  }
  sweeps_left_ = cut_.halo;
  if (ways_.empty()) { // one piece needs no halo
    return;
  }
  const auto halves = [](Parcel& parcel) {
    const std::span<float> values = parcel.values;
    return std::pair{values.first(values.size() / 2), values.last(values.size() / 2)};
  };
  VectorField field;
  std::vector<Parcel> leaving;
  for (const Own& own : own_) { // ways are in the order of the pieces where they begin
    own.session->read(field);
    for (const Transfer& way : ways_) {
      if (way.from == own.piece) {
        leaving.push_back({.way = way, .values = std::vector<float>(2 * way.sites.extent().sites())});
        Parcel& parcel = leaving.back();
        const auto [x, y] = halves(parcel);
        copy(way.sites, field.x, piece(own).loaded, x, way.sites);
        copy(way.sites, field.y, piece(own).loaded, y, way.sites);
      }
    }
  }
  std::vector<Parcel> arrived = exchange_->exchange(ways_, std::move(leaving), 2);
  for (const Own& own : own_) {
    own.session->read(field);
    for (Parcel& parcel : arrived) {
      if (parcel.way.to == own.piece) {
        const auto [x, y] = halves(parcel);
        copy(parcel.way.sites, x, parcel.way.sites, field.x, piece(own).loaded);
        copy(parcel.way.sites, y, parcel.way.sites, field.y, piece(own).loaded);
      }
    }
    own.session->write(field);
  }
}

} // namespace hdmbench
