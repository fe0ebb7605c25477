#include "backends/shared/cut_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

namespace hdmbench {

namespace {

/// Of cuts and halos, in sites: a multiple of the two colours along an axis.
constexpr int granule = 4;
/// Wide enough for the thesis's 50 iterations a level without a renewal.
constexpr int widest_halo = 64;

/// Where the pieces of an axis begin, and its end; empty where one would be empty.
std::vector<int> bounds(int sites, int pieces) {
  const int granules = (sites + granule - 1) / granule;
  std::vector<int> result;
  for (int i = 0; i <= pieces; ++i) {
    result.push_back(std::min(sites, granule * static_cast<int>(1LL * granules * i / pieces)));
  }
  return granules < pieces ? std::vector<int>{} : result;
}

/// `owned` and `halo` sites more on each side, as far as the image goes.
Rectangle with_halo(const Rectangle& owned, int halo, Extent extent) {
  const int left = std::max(0, owned.left - halo);
  const int top = std::max(0, owned.top - halo);
  return {.left = left,
          .top = top,
          .width = std::min(extent.width, owned.left + owned.width + halo) - left,
          .height = std::min(extent.height, owned.top + owned.height + halo) - top};
}

/// Without sites where they do not meet.
Rectangle intersection(const Rectangle& a, const Rectangle& b) {
  const int left = std::max(a.left, b.left);
  const int top = std::max(a.top, b.top);
  return {.left = left,
          .top = top,
          .width = std::max(0, std::min(a.left + a.width, b.left + b.width) - left),
          .height = std::max(0, std::min(a.top + a.height, b.top + b.height) - top)};
}

/// Copies what lies in `part` of the image between arrays that hold the sites `from_sites` and `to_sites` of
/// it.
void copy(const Rectangle& part, const std::vector<float>& from, const Rectangle& from_sites,
          std::vector<float>& to, const Rectangle& to_sites) {
  for (int y = part.top; y < part.top + part.height; ++y) {
    const auto at = [&](const Rectangle& sites) {
      return static_cast<std::ptrdiff_t>(sites.extent().index(part.left - sites.left, y - sites.top));
    };
    std::copy_n(from.begin() + at(from_sites), part.width, to.begin() + at(to_sites));
  }
}

void copy(const Rectangle& part, const VectorField& from, const Rectangle& from_sites, VectorField& to,
          const Rectangle& to_sites) {
  copy(part, from.x, from_sites, to.x, to_sites);
  copy(part, from.y, from_sites, to.y, to_sites);
}

Rectangle all_of(Extent extent) {
  return {.left = 0, .top = 0, .width = extent.width, .height = extent.height};
}

VectorField part_of(const VectorField& field, const Rectangle& part) {
  VectorField result(part.extent());
  copy(part, field, all_of(field.extent), result, part);
  return result;
}

ScalarField part_of(const ScalarField& field, const Rectangle& part) {
  ScalarField result(part.extent());
  copy(part, field.values, all_of(field.extent), result.values, part);
  return result;
}

/// The inverse curvature is the image's own: at an edge inside the image it is right as long as the halo
/// holds.
Level part_of(const Level& level, const Rectangle& part) {
  Level result = without_fields(level);
  result.extent = part.extent();
  result.target = part_of(level.target, part);
  result.confidence = part_of(level.confidence, part);
  result.modulus = part_of(level.modulus, part);
  result.inverse_modulus = part_of(level.inverse_modulus, part);
  std::ranges::transform(level.inputs, std::back_inserter(result.inputs),
                         [&](const ScalarField& input) { return part_of(input, part); });
  if (needs_inverse_curvature(level.rule)) {
    result.inverse_curvature = part_of(level.inverse_curvature, part);
  }
  return result;
}

/// Why the image cannot be cut; none where it can.
std::optional<std::string> obstacle(const Level& level) {
  if (level.rule == Rule::annealing) {
    return "annealing draws its random numbers by column and row";
  }
  if (level.update == Update::sequential) {
    return "sequential updates cross it in one sweep";
  }
  return std::nullopt;
}

/// Throws where the image, of which a session said `error`, cannot be cut.
void require_cuttable(const Level& level, const TooLarge& error) {
  if (const auto reason = obstacle(level)) {
    throw TooLarge(
        fmt::format("{}, and the image cannot be cut into pieces because {}", error.what(), *reason));
  }
}

} // namespace

Cut cut_image(Extent extent, int count) {
  int columns = 1;
  int rows = 1;
  while (columns * rows < count) {
    (extent.width / columns >= extent.height / rows ? columns : rows) *= 2;
  }
  const std::vector<int> xs = bounds(extent.width, columns);
  const std::vector<int> ys = bounds(extent.height, rows);
  if (xs.empty() || ys.empty()) {
    return {};
  }
  const int smallest = std::min(columns > 1 ? extent.width / columns : extent.height / rows,
                                rows > 1 ? extent.height / rows : extent.width / columns);
  Cut cut{.pieces = {}, .halo = std::clamp(smallest / 8 / granule * granule, granule, widest_halo)};
  for (std::size_t row = 0; row + 1 < ys.size(); ++row) {
    for (std::size_t column = 0; column + 1 < xs.size(); ++column) {
      const Rectangle owned{.left = xs[column],
                            .top = ys[row],
                            .width = xs[column + 1] - xs[column],
                            .height = ys[row + 1] - ys[row]};
      cut.pieces.push_back({.owned = owned, .loaded = with_halo(owned, cut.halo, extent)});
    }
  }
  return cut;
}

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
    Cut cut = cut_image(level.extent, count);
    if (cut.pieces.empty()) {
      throw TooLarge(fmt::format("{}; nor do pieces of it fit: {}", error.what(), of_piece));
    }
    try {
      for (std::size_t i = 0; i < cut.pieces.size(); ++i) {
        if (i == sessions_.size()) {
          sessions_.push_back(open_());
        }
        sessions_[i]->load(part_of(level, cut.pieces[i].loaded));
      }
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

/// The sessions number their sweeps as this one does.
void CutSession::do_step(int /*first*/, int sweeps) {
  if (!is_cut()) {
    return whole().step(sweeps);
  }
  sweep(sweeps - 1);
  sweep_and_count();
}

void CutSession::sweep(int sweeps) {
  while (sweeps > 0) {
    renew_halos();
    const int now = std::min(sweeps, sweeps_left_);
    for (std::size_t i = 0; i < cut_.pieces.size(); ++i) {
      sessions_[i]->step(now);
    }
    sweeps_left_ -= now;
    sweeps -= now;
  }
}

/// A session's own count has the halo in it, so the field is compared with the one before.
void CutSession::sweep_and_count() {
  renew_halos();
  changed_ = 0;
  VectorField before;
  VectorField after;
  for (std::size_t i = 0; i < cut_.pieces.size(); ++i) {
    const auto& [owned, loaded] = cut_.pieces[i];
    sessions_[i]->read(before);
    sessions_[i]->step(1);
    sessions_[i]->read(after);
    for (int y = owned.top; y < owned.top + owned.height; ++y) {
      const std::size_t first = loaded.extent().index(owned.left - loaded.left, y - loaded.top);
      for (std::size_t at = first; at < first + static_cast<std::size_t>(owned.width); ++at) {
        changed_ += before.x[at] != after.x[at] || before.y[at] != after.y[at] ? 1 : 0;
      }
    }
  }
  --sweeps_left_;
}

/// In two passes, so that the host holds one piece and the rims of all, never the image.
void CutSession::renew_halos() {
  if (sweeps_left_ > 0) {
    return;
  }
  struct Rim {
    std::size_t of; ///< the piece in whose halo it lies
    Rectangle sites;
    VectorField field;
  };
  std::vector<Rim> rims;
  VectorField field;
  for (std::size_t i = 0; i < cut_.pieces.size(); ++i) {
    sessions_[i]->read(field);
    for (std::size_t other = 0; other < cut_.pieces.size(); ++other) {
      const Rectangle shared = intersection(cut_.pieces[i].owned, cut_.pieces[other].loaded);
      if (other != i && shared.extent().sites() > 0) {
        Rim& rim = rims.emplace_back(Rim{other, shared, VectorField(shared.extent())});
        copy(shared, field, cut_.pieces[i].loaded, rim.field, shared);
      }
    }
  }
  for (std::size_t i = 0; i < cut_.pieces.size(); ++i) {
    sessions_[i]->read(field);
    for (const Rim& rim : rims) {
      if (rim.of == i) {
        copy(rim.sites, rim.field, rim.sites, field, cut_.pieces[i].loaded);
      }
    }
    sessions_[i]->write(field);
  }
  sweeps_left_ = cut_.halo;
}

std::int64_t CutSession::do_changed() {
  return is_cut() ? changed_ : whole().changed();
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
