#include "backends/shared/cut_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// Throws where the image, of which a session said `error`, cannot be cut.
void require_cuttable(const Level& level, const TooLarge& error) {
  if (level.update == Update::sequential) {
    throw TooLarge(fmt::format(
        "{}, and the image cannot be cut into pieces because sequential updates cross it in one sweep",
        error.what()));
  }
}

} // namespace

CutSession::CutSession(std::function<std::unique_ptr<Session>()> open) : open_(std::move(open)) {
  sessions_.push_back(open_());
}

void CutSession::do_load(const Level& level) {
  in_one_piece_ = false;
  cut_ = {};
  try {
    whole().load(level);
  } catch (const TooLarge& error) {
    require_cuttable(level, error);
    load_pieces(level, error);
  }
}

void CutSession::load_pieces(const Level& level, const TooLarge& error) {
  std::string of_piece = error.what();
  for (int count = 2;; count *= 2) {
    const bool in_rows = level.rule == Rule::annealing; // as its random numbers want
    Cut cut = in_rows ? cut_rows(level.extent, count) : cut_image(level.extent, count);
    if (cut.pieces.empty()) {
      throw TooLarge(fmt::format("{}; nor do pieces of it fit{}: {}", error.what(),
                                 in_rows ? ", which annealing needs in whole rows" : "", of_piece));
    }
    try {
      for (std::size_t i = 0; i < cut.pieces.size(); ++i) {
        if (i == sessions_.size()) {
          sessions_.push_back(open_());
        }
        Level piece = part_of(level, cut.pieces[i].loaded);
        piece.seed = seed_from_row(level.seed, cut.pieces[i].loaded.first[1]);
        sessions_[i]->load(piece);
      }
      extent_ = level.extent;
      cut_ = std::move(cut);
      return;
    } catch (const TooLarge& again) {
      of_piece = again.what();
    }
  }
}

void CutSession::do_write(const VectorField& displacement) {
  if (!is_cut()) {
    return whole().write(displacement);
  }
  for (std::size_t i = 0; i < cut_.pieces.size(); ++i) {
    sessions_[i]->write(part_of(displacement, cut_.pieces[i].loaded));
  }
  sweeps_left_ = cut_.halo;
}

void CutSession::do_read(VectorField& displacement) {
  if (!is_cut()) {
    return whole().read(displacement);
  }
  VectorField field;
  for (std::size_t i = 0; i < cut_.pieces.size(); ++i) {
    const Piece& piece = cut_.pieces[i];
    sessions_[i]->read(field);
    copy(piece.owned, field, piece.loaded, displacement, all_of(displacement.extent));
  }
}

/// The sessions number their sweeps as this one does. Their own counts have the halos in them, so the field
/// is compared with the one before.
void CutSession::do_step(int /*first*/, int sweeps) {
  if (!is_cut()) {
    return whole().step(sweeps);
  }
  VectorField before(extent_);
  VectorField after(extent_);
  sweep(sweeps - 1);
  do_read(before);
  sweep(1);
  do_read(after);
  changed_ = 0;
  for (std::size_t at = 0; at < extent_.sites(); ++at) {
    bool changed = false;
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      changed = changed || before[axis][at] != after[axis][at];
    }
    changed_ += changed ? 1 : 0;
  }
}

/// Each piece goes on as long as its halo holds, then halos are renewed.
void CutSession::sweep(int sweeps) {
  while (sweeps > 0) {
    if (sweeps_left_ == 0) {
      VectorField field(extent_);
      do_read(field);
      do_write(field);
    }
    const int now = std::min(sweeps, sweeps_left_);
    for (std::size_t i = 0; i < cut_.pieces.size(); ++i) {
      sessions_[i]->step(now);
    }
    sweeps_left_ -= now;
    sweeps -= now;
  }
}

std::int64_t CutSession::do_changed() {
  return is_cut() ? changed_ : whole().changed();
}

std::optional<double> CutSession::device_seconds() {
  std::optional<double> sum;
  for (std::size_t i = 0; i < std::max<std::size_t>(cut_.pieces.size(), 1); ++i) {
    if (const std::optional<double> seconds = sessions_[i]->device_seconds()) {
      sum = sum.value_or(0.0) + *seconds;
    }
  }
  return sum;
}

void CutSession::do_load_pyramid(const Pyramid& pyramid) {
  cut_ = {};
  try {
    whole().load(pyramid);
    in_one_piece_ = true;
  } catch (const TooLarge& error) {
    require_cuttable(*pyramid.full, error);
    in_one_piece_ = false;
  }
}

void CutSession::do_solve(const Advance& advance) {
  double told = 0.0; // of the levels before one that turns out to be too large
  if (in_one_piece_) {
    try {
      return whole().solve([&](double site_updates) {
        told += site_updates;
        advance(site_updates);
      });
    } catch (const TooLarge& error) {
      require_cuttable(*pyramid().full, error);
      in_one_piece_ = false;
    }
  }
  Session::do_solve([&](double site_updates) {
    const double again = std::min(told, site_updates);
    told -= again;
    advance(site_updates - again);
  });
}

} // namespace hdmbench
