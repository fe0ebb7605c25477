#include "backends/pieces/elastic_pieces.hpp"

#include "backends/shared/stopwatch.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

namespace hdmbench {

namespace {

/// What the levels of the sites `part` of a body are made of. The arrays are its own.
struct BodyPart {
  BodyPart(const ElasticBody& whole, const Box& part)
      : level(without_fields(whole.level)), model(whole.model), kind(whole.springs),
        whole_modulus(whole.level.modulus), first(part.first) {
    level.extent = part.extent();
    level.modulus = hdmbench::part_of(whole.level.modulus, part);
    level.confidence = hdmbench::part_of(whole.level.confidence, part);
    for (const auto& [from, to] :
         {std::pair{&whole.level.springs, &level.springs}, {&whole.level.walls, &level.walls}}) {
      *to = entries_of(*from, whole.level.extent, part);
    }
    if (whole.site_springs != nullptr) {
      springs.emplace().entries = entries_of(whole.site_springs->entries, whole.level.extent, part);
    }
  }

  [[nodiscard]] ElasticBody body() const {
    return {.level = level,
            .model = model,
            .springs = kind,
            .site_springs = springs ? &*springs : nullptr,
            .whole_modulus = &whole_modulus,
            .first = first};
  }

  static std::vector<std::vector<float>> entries_of(const std::vector<std::vector<float>>& whole,
                                                    Extent sites, const Box& part) {
    std::vector<std::vector<float>> entries;
    for (const std::vector<float>& entry : whole) {
      copy(part, entry, all_of(sites), entries.emplace_back(part.extent().sites()), part);
    }
    return entries;
  }

  Level level;
  ElasticModel model;
  Springs kind;
  std::optional<SiteSprings> springs{};
  const ScalarField& whole_modulus;
  std::array<int, 3> first;
};

/// A field that a step reads up to `reach` sites around each site of its level.
struct Read {
  ElasticField field;
  int reach;
};

/// In the order in which they are wanted, without the corrections of the next level.
std::vector<Read> reads_of(const MethodStep& step) {
  switch (step.kind) {
  case MethodStep::Kind::relax:
  case MethodStep::Kind::restrict_residual:
    return step.from == ElasticField::correction ? std::vector<Read>{{step.from, 1}, {ElasticField::load, 0}}
                                                 : std::vector<Read>{{step.from, 1}};
  case MethodStep::Kind::forces:
    return {{step.from, 1}};
  case MethodStep::Kind::relax_from_zero: // how the outermost sites respond is not known here
    return {{ElasticField::load, 1}};
  case MethodStep::Kind::restrict_load:
    return {{ElasticField::load, 0}};
  case MethodStep::Kind::correct:
    return {{step.from, 0}};
  case MethodStep::Kind::advance:
    return {{step.from, 0}, {step.direction, 0}};
  default:
    return {};
  }
}

/// Squares of the tree of a dot product, 2^height sites a side, that meet a part of the image.
Box squares_of(const Box& part, int height) {
  const auto up = [&](int side) { return (side + (1 << height) - 1) >> height; };
  Box result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.first[axis] = part.first[axis] >> height;
    result.end[axis] = up(part.end[axis]);
  }
  return result;
}

} // namespace

std::vector<Extent> sites_of(const ElasticHierarchy& hierarchy) {
  std::vector<Extent> levels;
  std::ranges::transform(hierarchy.levels, std::back_inserter(levels),
                         [](const ElasticLevel& level) { return level.grid.sites; });
  return levels;
}

template <typename Call>
void ElasticPieces::on_pieces(const Call& call) const {
  exchange_->compute([&] {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (pieces_[i] != nullptr) {
        call(*pieces_[i], here().first + i);
      }
    }
  });
}

template <typename Call>
void ElasticPieces::on_coarse(const Call& call) const {
  if (is_first()) {
    exchange_->compute([&] { call(*coarse_); });
  }
}

/// Renews the halos that the step needs, and notes how far what it makes is right beyond what is owned. A
/// coarse site takes what is around a fine one, so restricting wants one site more.
void ElasticPieces::take(const MethodStep& step) {
  if (!share_.is_cut(step.level)) {
    on_coarse([&](ElasticSession& session) { session.take(step); });
    return;
  }
  if (step.kind == MethodStep::Kind::write) {
    write_pieces(step);
    return;
  }
  const int more = step.restricts() ? 1 : 0;
  int right = halo(step.level) - more;
  if (step.kind == MethodStep::Kind::interpolate || step.kind == MethodStep::Kind::correct) {
    right = bring_correction(step.level);
  }
  for (const Read& read : reads_of(step)) {
    want(step.level, read.field, read.reach + more);
    right = std::min(right, valid(step.level, read.field) - read.reach);
  }
  on_pieces([&](ElasticSession& session, std::size_t) { session.take(step); });
  if (share_.is_cut(step.made_on())) {
    valid(step.made_on(), step.to) = more > 0 ? (right - 1) / 2 : right;
  } else {
    send_load();
  }
}

void ElasticPieces::read(int level, ElasticField field, VectorField& values) const {
  if (share_.is_cut(level)) {
    values = whole_of(*exchange_, share_.share(level).owned, sites(level), owned(level, field));
    return;
  }
  std::vector<VectorField> own(here().end - here().first);
  on_coarse([&](const ElasticSession& coarse) { coarse.read(level, field, own.front()); });
  values = whole_of(*exchange_, all_on_first(sites(level), share_.image().owned.size()), sites(level), own);
}

float ElasticPieces::dot(ElasticField first, ElasticField second) const {
  const int height = share_.cut_levels();
  float sum = 0.0F;
  if (height == 0) {
    on_coarse([&](const ElasticSession& coarse) { sum = coarse.dot(first, second); });
    return value_of_first(sum);
  }
  const std::vector<Box>& parts = share_.image().owned;
  std::vector<Box> held;
  std::ranges::transform(parts, std::back_inserter(held),
                         [height](const Box& part) { return squares_of(part, height); });
  const Extent all = squares_of(all_of(sites(0)), height).extent();
  std::vector<std::vector<float>> own(here().end - here().first);
  on_pieces([&](const ElasticSession& session, std::size_t piece) {
    own[piece - here().first] = hdmbench::part_of(session.dot_squares(first, second, height),
                                                  squares_of(in_piece(0, piece, parts[piece]), height))
                                    .values;
  });
  const std::vector<std::vector<float>> squares =
      redistribute(*exchange_, Purpose::sums, held, all_on_first(all, held.size()), own);
  if (is_first()) {
    ScalarField sums;
    sums.extent = all;
    sums.values = squares.front();
    while (sums.extent.sites() > 1) {
      sums = square_sums(sums, sites(0).axes());
    }
    sum = sums.values.front();
  }
  return value_of_first(sum);
}

std::optional<double> ElasticPieces::device_seconds() {
  std::optional<double> sum;
  const auto add = [&](ElasticSession& session) {
    if (const std::optional<double> seconds = session.device_seconds()) {
      sum = sum.value_or(0.0) + *seconds;
    }
  };
  on_pieces([&](ElasticSession& session, std::size_t) { add(session); });
  on_coarse(add);
  return sum;
}

void ElasticPieces::do_load(ElasticHierarchy& /*hierarchy*/) {
  throw std::logic_error("pieces are made of a body, not of its levels");
}

double ElasticPieces::do_load_body(const ElasticBody& body) {
  set_outline(body);
  share_ = sharing_.elastic(sites_of(hierarchy()));
  const int cut_levels = share_.cut_levels();
  valid_.clear();
  for (int level = 0; level < cut_levels; ++level) {
    valid_.emplace_back().fill(halo(level)); // fields are 0 everywhere
  }
  const auto load_into = [&](std::unique_ptr<ElasticSession>& session, ElasticHierarchy part) {
    session = session != nullptr ? std::move(session) : open_();
    session->load(std::move(part));
  };
  const PieceRange own = here();
  const std::size_t pieces = cut_levels > 0 ? share_.image().cut.pieces.size() : 0;
  double seconds = 0.0;
  std::vector<OwnCells> cells(own.end - own.first);
  ElasticLevel shape; // of the first uncut level
  exchange_->compute([&] {
    pieces_.resize(std::min(own.end, std::max(pieces, own.first)) - own.first);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      ElasticHierarchy part = timed(seconds, [&] { return piece_of(body, own.first + i, cells[i]); });
      shape.ratio = part.levels[static_cast<std::size_t>(cut_levels)].ratio;
      load_into(pieces_[i], std::move(part));
    }
  });
  ParentLevel uncut;
  if (cut_levels > 0) {
    shape.grid = RingedGrid(sites(cut_levels));
    shape.stride = hierarchy().levels[static_cast<std::size_t>(cut_levels)].stride;
    uncut =
        timed(seconds, [&] { return uncut_level(*exchange_, shape, share_.share(cut_levels).owned, cells); });
  }
  if (is_first()) {
    exchange_->compute([&] {
      load_into(coarse_, timed(seconds, [&] {
                  return cut_levels == 0 ? make_elastic_hierarchy(body) : coarse_of(body, std::move(uncut));
                }));
    });
  }
  return seconds;
}

void ElasticPieces::do_end() {
  on_pieces([](ElasticSession& session, std::size_t) { session.end(); });
  on_coarse([](ElasticSession& session) { session.end(); });
}

/// A level without stiffness ends it, so that it is a hierarchy as any other.
ElasticHierarchy ElasticPieces::piece_of(const ElasticBody& whole, std::size_t piece, OwnCells& cells) const {
  const std::size_t axes = whole.level.extent.axes();
  const Extent least{2, 2, axes == 3 ? 2 : 1};
  const int uncut = share_.cut_levels();
  const BodyPart own(whole, share_.image().loaded[piece]);
  auto [levels, coarsening] = make_fine_levels(own.body(), uncut);
  cells = OwnCells(levels.back(), coarsening, in_piece(uncut, piece, share_.share(uncut).owned[piece]));
  ElasticHierarchy part{.levels = std::move(levels), .coarsest_inverse = {}};
  part.levels.push_back(empty_level(least, part.levels[1].moments.size()));
  part.coarsest_inverse.assign(axes * least.sites() * axes * least.sites(), 0.0F);
  return part;
}

/// Nothing is asked of cut levels, so each is as small as the first one that is not cut.
ElasticHierarchy ElasticPieces::coarse_of(const ElasticBody& whole, ParentLevel uncut) const {
  const auto first = static_cast<std::size_t>(share_.cut_levels());
  const Extent sites = uncut.level.grid.sites;
  ElasticHierarchy part =
      make_coarse_levels(whole, share_.cut_levels(), std::move(uncut.level), std::move(uncut.coarsening));
  for (std::size_t level = 0; level < first; ++level) {
    const bool has_site_moduli = level == 0 && sites.axes() == 3;
    ElasticLevel small = empty_level(sites, has_site_moduli ? 1 : part.levels[first].moments.size());
    small.ratio = part.levels[first].ratio;
    small.stride = part.levels[level].stride;
    part.levels[level] = std::move(small);
  }
  return part;
}

void ElasticPieces::write_pieces(const MethodStep& step) {
  valid(step.level, step.to) = halo(step.level);
  on_pieces([&](ElasticSession& session, std::size_t piece) {
    session.write(step.level, step.to,
                  hdmbench::part_of(*step.values, share_.share(step.level).loaded[piece]));
  });
}

std::vector<VectorField> ElasticPieces::owned(int level, ElasticField field) const {
  std::vector<VectorField> own(here().end - here().first);
  on_pieces([&](const ElasticSession& session, std::size_t piece) {
    VectorField loaded;
    session.read(level, field, loaded);
    own[piece - here().first] =
        hdmbench::part_of(loaded, in_piece(level, piece, share_.share(level).owned[piece]));
  });
  return own;
}

Box ElasticPieces::in_piece(int level, std::size_t piece, Box part) const {
  const Box& loaded = share_.share(level).loaded[piece];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part.first[axis] -= loaded.first[axis];
    part.end[axis] -= loaded.first[axis];
  }
  return part;
}

void ElasticPieces::want(int level, ElasticField field, int sites) {
  if (valid(level, field) >= sites) {
    return;
  }
  valid(level, field) = halo(level);
  const LevelShare& share = share_.share(level);
  const std::vector<VectorField> loaded =
      redistribute(*exchange_, Purpose::halos, share.owned, share.loaded, owned(level, field));
  on_pieces([&](ElasticSession& session, std::size_t piece) {
    session.write(level, field, loaded[piece - here().first]);
  });
}

void ElasticPieces::send_load() {
  const int level = share_.cut_levels();
  const std::vector<Box>& held = share_.share(level).owned;
  const std::vector<VectorField> whole =
      redistribute(*exchange_, Purpose::halos, held, all_on_first(sites(level), held.size()),
                   owned(level, ElasticField::load));
  on_coarse([&](ElasticSession& coarse) { coarse.write(level, ElasticField::load, whole.front()); });
}

int ElasticPieces::bring_correction(int level) {
  if (share_.is_cut(level + 1)) {
    want(level + 1, ElasticField::correction, 1);
    return 2 * valid(level + 1, ElasticField::correction) - 1;
  }
  const LevelShare& share = share_.share(level + 1);
  std::vector<VectorField> whole(here().end - here().first);
  on_coarse(
      [&](const ElasticSession& coarse) { coarse.read(level + 1, ElasticField::correction, whole.front()); });
  const std::vector<VectorField> parts = redistribute(
      *exchange_, Purpose::halos, all_on_first(sites(level + 1), share.owned.size()), share.loaded, whole);
  on_pieces([&](ElasticSession& session, std::size_t piece) {
    session.write(level + 1, ElasticField::correction, parts[piece - here().first]);
  });
  return 2 * share.cut.halo - 1;
}

float ElasticPieces::value_of_first(float value) const {
  const std::int64_t bits = is_first() ? std::bit_cast<std::uint32_t>(value) : 0;
  return std::bit_cast<float>(static_cast<std::uint32_t>(exchange_->sum(bits)));
}

} // namespace hdmbench
