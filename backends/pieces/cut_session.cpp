#include "backends/pieces/cut_session.hpp"

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

/// Returns what is said of an image that is too large even in pieces, the last of which met `of_piece`.
TooLarge even_in_pieces(const TooLarge& error, std::string_view kind, std::string_view of_piece) {
  return TooLarge(fmt::format("{}; nor do pieces of it fit{}: {}", error.what(), kind, of_piece));
}

} // namespace

CutSession::CutSession(std::function<std::unique_ptr<Session>()> open)
    : whole_(open()), pieces_(std::make_unique<InMemory>(), std::move(open)) {}

void CutSession::do_load(const Level& level) {
  in_one_piece_ = false;
  is_cut_ = false;
  try {
    whole_->load(level);
  } catch (const TooLarge& error) {
    require_cuttable(level, error);
    load_pieces(level, error);
  }
}

void CutSession::load_pieces(const Level& level, const TooLarge& error) {
  std::string of_piece = error.what();
  for (int count = 2; !is_cut_; count *= 2) {
    const bool in_rows = level.rule == Rule::annealing; // as its random numbers want
    Cut cut = in_rows ? cut_rows(level.extent, count) : cut_image(level.extent, count);
    if (cut.pieces.empty()) {
      throw even_in_pieces(error, in_rows ? ", which annealing needs in whole rows" : "", of_piece);
    }
    try {
      pieces_.load(level, share_of(std::move(cut), count));
      is_cut_ = true;
    } catch (const TooLarge& again) {
      of_piece = again.what();
    }
  }
}

void CutSession::do_write(const VectorField& displacement) {
  is_cut_ ? pieces_.write(displacement) : whole_->write(displacement);
}

void CutSession::do_read(VectorField& displacement) {
  if (is_cut_) {
    displacement = pieces_.read();
  } else {
    whole_->read(displacement);
  }
}

void CutSession::do_step(int /*first*/, int sweeps) {
  is_cut_ ? pieces_.step(sweeps) : whole_->step(sweeps);
}

std::int64_t CutSession::do_changed() {
  return is_cut_ ? pieces_.changed() : whole_->changed();
}

std::optional<double> CutSession::device_seconds() {
  return is_cut_ ? pieces_.device_seconds() : whole_->device_seconds();
}

void CutSession::do_load_pyramid(const Pyramid& pyramid) {
  is_cut_ = false;
  try {
    whole_->load(pyramid);
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
      return whole_->solve([&](double site_updates) {
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

CutElasticSession::CutElasticSession(ElasticPieces::Open open) : open_(std::move(open)), session_(open_()) {}

double CutElasticSession::do_load_body(const ElasticBody& body) {
  set_outline(body);
  join();
  try {
    return session_->load(body);
  } catch (const TooLarge& error) {
    return load_pieces(body, error);
  }
}

/// What is left of the hierarchy here says how many levels there are.
void CutElasticSession::do_load(ElasticHierarchy& hierarchy) {
  std::vector<ElasticLevel> grids;
  for (const ElasticLevel& level : hierarchy.levels) {
    grids.emplace_back().grid = level.grid;
  }
  join();
  session_->load(std::move(hierarchy));
  hierarchy.levels = std::move(grids);
}

void CutElasticSession::join() {
  if (std::exchange(is_cut_, false)) {
    session_ = open_();
  }
}

/// As many levels are cut as make the session of the coarse ones smaller than one of a piece.
double CutElasticSession::load_pieces(const ElasticBody& body, const TooLarge& error) {
  is_cut_ = true;
  std::string of_piece = error.what();
  const std::size_t sites = body.level.extent.sites();
  for (int count = 2;; count *= 2) {
    const auto square = static_cast<std::size_t>(count) * static_cast<std::size_t>(count);
    const Sharing sharing{
        .ranks = count, .pieces = count, .fewest_sites = std::max<std::size_t>(sites / square, 1)};
    if (sharing.elastic(sites_of(hierarchy())).image().cut.pieces.size() < static_cast<std::size_t>(count)) {
      throw even_in_pieces(error, "", of_piece);
    }
    session_ = std::make_unique<ElasticPieces>(std::make_unique<InMemory>(), sharing, open_);
    try {
      return session_->load(body);
    } catch (const TooLarge& again) {
      of_piece = again.what();
    }
  }
}

} // namespace hdmbench
