#include "harness/ranks/ranked_solution.hpp"

#include "backends/shared/cut_rows.hpp"
#include "harness/ranks/ranked_resampling.hpp"
#include "harness/ranks/ranked_sampling.hpp"
#include "harness/ranks/redistribution.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/solve/solve.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <utility>

namespace hdmbench {

namespace {

template <typename Call>
std::vector<Rectangle> each(const std::vector<Rectangle>& parts, const Call& call) {
  std::vector<Rectangle> result;
  std::ranges::transform(parts, std::back_inserter(result), call);
  return result;
}

template <typename Operation>
void combine(VectorField& field, const VectorField& other, const Operation& operation) {
  std::ranges::transform(field.x, other.x, field.x.begin(), operation);
  std::ranges::transform(field.y, other.y, field.y.begin(), operation);
}

Traffic operator-(const Traffic& now, const Traffic& before) {
  return {now.messages - before.messages, now.bytes - before.bytes, now.seconds - before.seconds};
}

/// Computes the levels of a pyramid one after the other.
class RankedSolver {
public:
  RankedSolver(RankedPyramid pyramid, const Sharing& sharing, Ranks& ranks, Exchange& halos, Session& session)
      : pyramid_(std::move(pyramid)), sharing_(sharing), ranks_(ranks), halos_(halos), session_(session),
        rank_(static_cast<std::size_t>(ranks.rank())), full_(sharing(pyramid_.extent)) {}

  RankedLevel compute(const PyramidLevel& level, bool is_last, bool counted) {
    RankedLevel result{.extent = level.extent};
    LevelShare share = sharing_(level.extent);
    result.pieces = share.cut.pieces.size();
    result.columns = share.cut.columns;
    result.halo = result.pieces > 1 ? share.cut.halo : 0;
    const Traffic at_first = ranks_.traffic();
    const bool has_piece = rank_ < result.pieces;
    Level piece = sample(level, share, is_last);
    const bool may_diverge = is_accelerated(piece);
    if (has_piece) {
      session_.load(piece);
    }
    field_ = begin(level.extent, share); // and memory for what comes out
    if (has_piece) {
      session_.write(field_);
    }
    const LevelRange range = may_diverge ? over_all(range_of(piece, field_)) : LevelRange{};
    const VectorField first = may_diverge ? field_ : VectorField{};
    if (!may_diverge) {
      piece = {}; // the sweeps may need its memory
    }
    result.before = ranks_.traffic() - at_first;

    std::vector<PieceSweeps::Own> own;
    if (has_piece) {
      own.push_back({rank_, &session_});
    }
    PieceSweeps pieces(share.cut, std::move(own), halos_);
    pieces.written();
    sweep(level, counted, pieces, result);
    read(share, has_piece);
    result.repeated = may_diverge && ranks_.largest(is_within(range, field_) ? 0.0 : 1.0) > 0.0;
    if (result.repeated) {
      piece.strengths = {1.0F};
      if (has_piece) {
        session_.load(piece);
        session_.write(first);
      }
      pieces.written();
      sweep(level, counted, pieces, result);
      read(share, has_piece);
    }
    result.renewals = pieces.renewals();
    result.halos = ranks_.traffic() - at_first;
    result.halos = result.halos - result.before;
    extent_ = level.extent;
    share_ = std::move(share);
    return result;
  }

  RankedSolution take(std::vector<RankedLevel> levels) {
    return {.owned = share_.owned[rank_], .displacement = std::move(field_), .levels = std::move(levels)};
  }

private:
  /// What this rank owns of the session's field.
  void read(const LevelShare& share, bool has_piece) {
    if (share.cut.pieces.size() > 1 && has_piece) {
      field_.extent = share.owned[rank_].extent();
      field_.x.resize(field_.extent.sites());
      field_.y.resize(field_.extent.sites());
      const FieldPart owned{local(share.cut.pieces[rank_], share.owned[rank_]), field_.x, field_.y};
      session_.read_parts(std::span(&owned, 1));
    } else if (has_piece) {
      session_.read(field_);
    }
  }

  /// Of the parts of all ranks.
  [[nodiscard]] LevelRange over_all(const LevelRange& own) {
    LevelRange all;
    for (std::size_t component = 0; component < all.least.size(); ++component) {
      all.least[component] = -ranks_.largest(-own.least[component]);
      all.most[component] = ranks_.largest(own.most[component]);
    }
    return all;
  }

  /// What this rank loads of the level.
  Level sample(const PyramidLevel& level, const LevelShare& share, bool is_last) {
    const RankedSampling sampling(ranks_, halos_, rank_, pyramid_.extent, full_, level.extent, share,
                                  pyramid_.alignment);
    const bool is_full =
        level.extent == pyramid_.extent; // what is here; after the last level nobody needs it
    Level result = !is_full  ? sampling(pyramid_.part, pyramid_.material)
                   : is_last ? std::move(pyramid_.part)
                             : pyramid_.part;
    result.strengths = level.strengths;
    result.seed = seed_from_row(result.seed, share.loaded[rank_].top);
    if (needs_inverse_curvature(result.rule)) { // wrong on the outermost rim, as the first sweep is there
      set_inverse_curvature(result);
    }
    if (pyramid_.start) {
      start_before_ = std::move(start_);
      start_ = is_full ? *pyramid_.start : sampling(*pyramid_.start);
    }
    return result;
  }

  /// What the level begins with (LevelSequence::begin()), at the sites that this rank loads.
  VectorField begin(Extent level, const LevelShare& share) {
    if (extent_ == Extent{}) {
      return pyramid_.start ? start_ : VectorField(share.loaded[rank_].extent());
    }
    if (pyramid_.start) {
      VectorField own(field_.extent);
      copy(share_.owned[rank_], start_before_, share_.loaded[rank_], own, share_.owned[rank_]);
      combine(field_, own, std::minus());
    }
    const RankedProjection projection(extent_, level, pyramid_.alignment);
    const std::vector<Rectangle> wanted =
        each(share.loaded, [&](const Rectangle& part) { return projection.sites(part); });
    VectorField first =
        projection(redistribute(ranks_, rank_, share_.owned, wanted, field_), share.loaded[rank_]);
    if (pyramid_.start) {
      combine(first, start_, std::plus());
    }
    return first;
  }

  void sweep(const PyramidLevel& level, bool counted, PieceSweeps& pieces, RankedLevel& result) {
    const int together = sweeps_per_iteration(pyramid_.part);
    if (!pyramid_.until_still) {
      const int uncounted = counted ? std::max(0, level.sweeps - 1) : level.sweeps;
      pieces.sweep(uncounted);
      if (uncounted < level.sweeps) {
        pieces.sweep_and_count();
        result.changed = halos_.sum(pieces.changed());
      }
      result.sweeps += level.sweeps;
      return;
    }
    std::int64_t moved = 1;
    for (int done = 0; moved > 0 && done < level.sweeps; done += together) {
      moved = 0;
      for (int i = 0; i < together; ++i) {
        pieces.sweep_and_count();
        result.changed = halos_.sum(pieces.changed());
        moved += result.changed;
      }
      result.sweeps += together;
    }
  }

  RankedPyramid pyramid_;
  const Sharing& sharing_;
  Ranks& ranks_;
  Exchange& halos_;
  Session& session_;
  std::size_t rank_;
  LevelShare full_;          ///< of the full image
  Extent extent_{};          ///< of the level computed before
  LevelShare share_;         ///< the same
  VectorField field_;        ///< of it, what this rank owns
  VectorField start_;        ///< at the sites that this rank loads of the level
  VectorField start_before_; ///< of the level computed before
};

} // namespace

LevelShare by_rank(Cut cut, int ranks) {
  LevelShare share{.cut = std::move(cut), .owned = {}, .loaded = {}};
  share.owned.resize(static_cast<std::size_t>(ranks));
  share.loaded.resize(share.owned.size());
  for (std::size_t i = 0; i < share.cut.pieces.size(); ++i) {
    share.owned[i] = share.cut.pieces[i].owned;
    share.loaded[i] = share.cut.pieces[i].loaded;
  }
  return share;
}

double renewal_seconds(const HaloCosts& costs, const Cut& cut) {
  double loaded = 0.0;
  double rim = 0.0;
  for (const Piece& piece : cut.pieces) {
    const auto sites = static_cast<double>(piece.loaded.extent().sites());
    loaded = std::max(loaded, sites);
    rim = std::max(rim, sites - static_cast<double>(piece.owned.extent().sites()));
  }
  const int columns = std::min(cut.columns, 3);
  const int rows = std::min(static_cast<int>(cut.pieces.size()) / cut.columns, 3);
  const double messages = columns * rows - 1; // of a piece in the middle
  constexpr double bytes_of_a_site = 2.0 * sizeof(float);
  return messages * costs.message + rim * (bytes_of_a_site * costs.byte + costs.rim) + loaded * costs.piece;
}

namespace {

/// The same pieces with the halo that costs least. `cut_with(count, halo)` cuts them.
template <typename CutWith>
Cut with_cheapest_halo(const HaloCosts& costs, Extent extent, Cut cut, const CutWith& cut_with) {
  constexpr std::array widths{8, 16, 32, 64}; // up to eight sweeps pass through memory together
  const int count = static_cast<int>(cut.pieces.size());
  const Rectangle& first = cut.pieces.front().owned;
  const int shortest = std::min(cut.columns > 1 ? first.width : extent.width,
                                cut.columns < count ? first.height : extent.height);
  double least = std::numeric_limits<double>::infinity();
  for (const int width : widths) {
    if (width > shortest / 2) {
      break; // `cut` is as narrow as can be where no width is left
    }
    Cut candidate = cut_with(count, width);
    double sites = 0.0;
    for (const Piece& piece : candidate.pieces) {
      sites = std::max(sites, static_cast<double>(piece.loaded.extent().sites()));
    }
    const double seconds = sites * costs.site + renewal_seconds(costs, candidate) / width;
    if (seconds < least) {
      least = seconds;
      cut = std::move(candidate);
    }
  }
  return cut;
}

} // namespace

LevelShare Sharing::operator()(Extent extent) const {
  auto worth = static_cast<int>(std::clamp<std::size_t>(
      extent.sites() / std::max<std::size_t>(fewest_sites, 1), 1, static_cast<std::size_t>(pieces)));
  const bool rows = fewest_rows > 0;
  if (rows) {
    worth = std::clamp(extent.height / fewest_rows, 1, worth);
  }
  const auto cut_with = [&](int count, int width) {
    return rows ? cut_rows(extent, count, width) : cut_image(extent, count, width);
  };
  Cut cut;
  for (int count = worth; cut.pieces.empty(); --count) {
    cut = cut_with(count, halo);
  }
  if (costs && halo == 0 && cut.pieces.size() > 1) {
    cut = with_cheapest_halo(*costs, extent, std::move(cut), cut_with);
  }
  return by_rank(std::move(cut), ranks);
}

Sharing sharing_for(const Schedule& schedule, Sharing sharing) {
  const bool is_default = sharing.fewest_sites == Sharing{}.fewest_sites;
  if (schedule.mean_modulus || schedule.rule == Rule::annealing) {
    sharing.fewest_rows = 1;
  }
  if (sharing.fewest_rows > 0 && is_default) { // below, a piece is mostly halo
    sharing.fewest_rows = 48;
  }
  return sharing;
}

void require_shareable(const Scene& scene) {
  const auto refuse = [&](std::string_view what) {
    throw InputError(fmt::format("{} runs on one rank", what));
  };
  if (scene.energy == EnergyModel::elastic) {
    if (scene.robust) {
      refuse("--robust, which solves again and again,");
    }
    if (scene.schedule.stride > 1) {
      refuse("--stride, which makes a small image,");
    }
    return;
  }
  if (scene.full.update == Update::sequential) {
    refuse("sequential, each of whose sweeps crosses the image site by site,");
  }
  if (scene.schedule.stop == Stop::energy) {
    refuse("a level that ends by its mean energy");
  }
}

RankedPyramid ranked_pyramid(ScenePart part) {
  const Scene& scene = part.scene;
  RankedPyramid pyramid{.extent = scene.extent(),
                        .part = std::move(part.full),
                        .start = std::move(part.start),
                        .alignment = scene.schedule.alignment,
                        .material = scene.schedule.mean_modulus ? Material::mean : Material::nearest,
                        .levels = {},
                        .until_still = scene.schedule.stop == Stop::still};
  pyramid.part.penalty = scene.full.penalty; // what the command line may have changed
  pyramid.part.steps = scene.full.steps;
  pyramid.part.update = scene.full.update;
  pyramid.part.rule = scene.schedule.rule;
  pyramid.part.seed = scene.full.seed;
  const LevelSequence levels(scene);
  for (const int level : levels.order()) {
    pyramid.levels.push_back({.extent = levels.extent(level),
                              .sweeps = levels.iterations(level) * sweeps_per_iteration(scene.full),
                              .strengths = levels.strengths(level)});
  }
  return pyramid;
}

RankedSolution solve_on_ranks(RankedPyramid pyramid, const Sharing& sharing, Ranks& ranks, Exchange& halos,
                              Session& session, bool counted, const Session::Advance& advance) {
  const std::vector<PyramidLevel> levels = pyramid.levels;
  RankedSolver solver(std::move(pyramid), sharing, ranks, halos, session);
  std::vector<RankedLevel> done;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    double seconds = 0.0;
    done.push_back(
        timed(seconds, [&] { return solver.compute(levels[i], i + 1 == levels.size(), counted); }));
    done.back().seconds = seconds;
    if (advance) {
      advance(static_cast<double>(levels[i].extent.sites()) * levels[i].sweeps);
    }
  }
  return solver.take(std::move(done));
}

} // namespace hdmbench
