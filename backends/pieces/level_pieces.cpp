#include "backends/pieces/level_pieces.hpp"

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

std::int64_t changed_sites(const VectorField& before, const VectorField& after) {
  std::int64_t count = 0;
  for (std::size_t at = 0; at < before.extent.sites(); ++at) {
    bool changed = false;
    for (std::size_t axis = 0; axis < before.extent.axes(); ++axis) {
      changed = changed || before[axis][at] != after[axis][at];
    }
    count += changed ? 1 : 0;
  }
  return count;
}

} // namespace

template <typename Call>
void LevelPieces::for_each_own(const Call& call) {
  const PieceRange here = own_pieces(*exchange_, share_.owned.size());
  exchange_->compute([&] {
    for (std::size_t i = here.first; i < std::min(here.end, share_.cut.pieces.size()); ++i) {
      call(*sessions_[i - here.first], i);
    }
  });
}

void LevelPieces::open(std::size_t sessions) {
  exchange_->compute([&] {
    while (sessions_.size() < sessions) {
      sessions_.push_back(open_());
    }
  });
}

void LevelPieces::load(const Level& level, LevelShare share) {
  extent_ = level.extent;
  share_ = std::move(share);
  const PieceRange here = own_pieces(*exchange_, share_.owned.size());
  open(here.end - here.first);
  for_each_own([&](Session& session, std::size_t i) {
    Level piece = part_of(level, share_.loaded[i]);
    piece.seed = seed_from_row(level.seed, share_.loaded[i].first[1]);
    session.load(piece);
  });
}

void LevelPieces::write(const VectorField& displacement) {
  for_each_own(
      [&](Session& session, std::size_t i) { session.write(part_of(displacement, share_.loaded[i])); });
  sweeps_left_ = share_.cut.halo;
}

VectorField LevelPieces::read() {
  return whole_of(*exchange_, share_.owned, extent_, owned());
}

std::vector<VectorField> LevelPieces::owned() {
  const PieceRange here = own_pieces(*exchange_, share_.owned.size());
  std::vector<VectorField> fields(here.end - here.first);
  for_each_own([&](Session& session, std::size_t i) {
    VectorField loaded;
    session.read(loaded);
    VectorField& own = fields[i - here.first] = VectorField(share_.owned[i].extent());
    copy(share_.owned[i], loaded, share_.loaded[i], own, share_.owned[i]);
  });
  return fields;
}

void LevelPieces::step(int sweeps) {
  sweep(sweeps - 1);
  const std::vector<VectorField> before = owned();
  sweep(1);
  const std::vector<VectorField> after = owned();
  changed_ = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    changed_ += changed_sites(before[i], after[i]);
  }
}

void LevelPieces::sweep(int sweeps) {
  const bool is_cut = share_.cut.pieces.size() > 1;
  while (sweeps > 0) {
    if (sweeps_left_ == 0 && is_cut) {
      const std::vector<VectorField> loaded =
          redistribute(*exchange_, Purpose::halos, share_.owned, share_.loaded, owned());
      const std::size_t first = own_pieces(*exchange_, share_.owned.size()).first;
      for_each_own([&](Session& session, std::size_t i) { session.write(loaded[i - first]); });
      sweeps_left_ = share_.cut.halo;
    }
    const int now = is_cut ? std::min(sweeps, sweeps_left_) : sweeps;
    for_each_own([&](Session& session, std::size_t) { session.step(now); });
    sweeps_left_ -= now;
    sweeps -= now;
  }
}

std::optional<double> LevelPieces::device_seconds() {
  std::optional<double> sum;
  for_each_own([&](Session& session, std::size_t) {
    if (const std::optional<double> seconds = session.device_seconds()) {
      sum = sum.value_or(0.0) + *seconds;
    }
  });
  return sum;
}

} // namespace hdmbench
