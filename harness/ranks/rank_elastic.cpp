#include "harness/ranks/rank_backend.hpp"

#include "kernels/data/input_error.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// The sites `part` of a level and the cells between them. What is not an array stays as it is; a new member
/// has to be named here, or this does not compile.
ElasticLevel part_of(ElasticLevel level, const Box& part) {
  auto& [grid, moments, bend, response, masked] = level;
  const RingedGrid whole = std::exchange(grid, RingedGrid(part.extent()));
  const auto cut = [&](std::vector<std::vector<float>>& arrays, Extent extent) {
    for (std::vector<float>& values : arrays) {
      const std::vector<float> from = std::exchange(values, std::vector<float>(grid.size()));
      for (int row = 0; row < extent.rows(); ++row) {
        const int y = row % extent.height;
        const int z = row / extent.height;
        const std::size_t first = whole.index(part.first[0], part.first[1] + y, part.first[2] + z);
        std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(first), extent.width,
                    values.begin() + static_cast<std::ptrdiff_t>(grid.index(0, y, z)));
      }
    }
  };
  const Extent cells = grid.cells();
  cut(response, part.extent());
  const bool has_site_moduli = moments.size() == 1; // of the image of a volume
  cut(moments, has_site_moduli ? part.extent() : cells);
  const MaskedCells from = std::exchange(masked, {});
  masked.components = from.components;
  masked.rows = static_cast<std::size_t>(cells.height);
  for (int row = 0; row < cells.rows(); ++row) {
    masked.begin.push_back(masked.x.size());
    const auto [begin, end] =
        from.row(part.first[1] + row % cells.height, part.first[2] + row / cells.height);
    for (std::size_t i = begin; i < end; ++i) {
      const int x = from.x[i] - part.first[0];
      if (x >= 0 && x < cells.width) {
        masked.x.push_back(x);
        const float* const matrix = from.matrix(i);
        masked.stiffness.insert(masked.stiffness.end(), matrix,
                                matrix + masked.components * masked.components);
      }
    }
  }
  masked.begin.push_back(masked.x.size());
  return level;
}

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
  case MethodStep::Kind::relax_from_zero:
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

class RankElasticSession final : public ElasticSession {
public:
  using Open = std::function<std::unique_ptr<ElasticSession>()>;

  RankElasticSession(Ranks& ranks, const Sharing& sharing, const faults::RankFault& fault, Open open)
      : ranks_(ranks), rank_(static_cast<std::size_t>(ranks.rank())), sharing_(sharing), fault_(fault),
        halos_(ranks, fault, rank_), open_(std::move(open)) {}

  /// Renews the halos that the step needs, and notes how far what it makes is right beyond what is owned. A
  /// coarse site takes what is around a fine one, so restricting wants one site more.
  void take(const MethodStep& step) override {
    if (step.kind == MethodStep::Kind::write) {
      write_piece(step);
      return;
    }
    const bool is_cut = share_.is_cut(step.level);
    const int more = step.restricts() ? 1 : 0;
    int right = is_cut ? halo(step.level) - more : 0;
    if (is_cut && (step.kind == MethodStep::Kind::interpolate || step.kind == MethodStep::Kind::correct)) {
      right = bring_correction(step.level);
    }
    for (const Read& read : reads_of(step)) {
      if (is_cut) {
        want(step.level, read.field, read.reach + more);
        right = std::min(right, valid(step.level, read.field) - read.reach);
      }
    }
    compute(step.level, [&](ElasticSession& session) { session.take(step); });
    if (share_.is_cut(step.made_on())) {
      valid(step.made_on(), step.to) = more > 0 ? (right - 1) / 2 : right;
    } else if (is_cut) {
      send_load();
    }
  }

  void read(int level, ElasticField field, VectorField& values) const override {
    const std::vector<Box> held =
        share_.is_cut(level) ? share_.share(level).owned : all_on_first(sites(level), ranks_.size());
    VectorField own(held[rank_].extent());
    if (share_.is_cut(level)) {
      own = owned(level, field);
    } else {
      on(coarse_.get(), [&](const ElasticSession& coarse) { coarse.read(level, field, own); });
    }
    values = redistribute(ranks_, rank_, held, all_on_each(sites(level), ranks_.size()), own);
  }

  /// The tree of one rank: its squares, or cubes, of 2^cut_levels sites a side lie within pieces, and the
  /// first rank adds up the rest.
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    const int height = share_.cut_levels();
    float sum = 0.0F;
    if (height == 0) {
      on(coarse_.get(), [&](const ElasticSession& coarse) { sum = coarse.dot(first, second); });
      return value_of_first(sum);
    }
    const auto squares = [&](const Box& part) {
      const auto up = [&](int side) { return (side + (1 << height) - 1) >> height; };
      Box result;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        result.first[axis] = part.first[axis] >> height;
        result.end[axis] = up(part.end[axis]);
      }
      return result;
    };
    std::vector<Box> held;
    std::ranges::transform(share_.image().owned, std::back_inserter(held), squares);
    const Extent all = squares(all_of(sites(0))).extent();
    ScalarField own;
    on(piece_.get(), [&](const ElasticSession& piece) {
      own = hdmbench::part_of(piece.dot_squares(first, second, height),
                              squares(in_piece(0, share_.image().owned[rank_])));
    });
    ScalarField sums;
    sums.extent = all;
    sums.values = redistribute(halos_, rank_, held, all_on_first(all, ranks_.size()), own.values);
    while (ranks_.is_first() && sums.extent.sites() > 1) {
      sums = square_sums(sums, sites(0).axes());
    }
    return value_of_first(ranks_.is_first() ? sums.values.front() : 0.0F);
  }

private:
  void do_load(ElasticHierarchy& hierarchy) override {
    std::vector<Extent> levels;
    std::ranges::transform(hierarchy.levels, std::back_inserter(levels),
                           [](const ElasticLevel& level) { return level.grid.sites; });
    share_ = sharing_.elastic(std::move(levels));
    const int cut_levels = share_.cut_levels();
    valid_.clear();
    for (int level = 0; level < cut_levels; ++level) {
      valid_.emplace_back().fill(halo(level)); // fields are 0 everywhere
    }
    const auto load_into = [&](std::unique_ptr<ElasticSession>& session, ElasticHierarchy sheet) {
      ended_by_error_of_one([&] {
        session = session != nullptr ? std::move(session) : open_();
        session->load(std::move(sheet));
      });
    };
    if (cut_levels > 0 && rank_ < share_.image().cut.pieces.size()) {
      // A level without stiffness ends it, so that it is a hierarchy as any other.
      const std::size_t axes = hierarchy.levels.front().grid.axes();
      const Extent least{2, 2, axes == 3 ? 2 : 1};
      std::vector<ElasticLevel> whole = std::exchange(hierarchy.levels, {});
      ElasticHierarchy piece = hierarchy;
      piece.coarsest_inverse.assign(axes * least.sites() * axes * least.sites(), 0.0F);
      for (int level = 0; level <= cut_levels; ++level) {
        piece.levels.push_back(
            part_of(whole[static_cast<std::size_t>(level)], share_.share(level).loaded[rank_]));
      }
      piece.levels.push_back(empty_level(least, whole[1].moments.size()));
      if (fault_.in_sheet) {
        fault_.in_sheet(piece, rank_);
      }
      hierarchy.levels = std::move(whole);
      load_into(piece_, std::move(piece));
    } else {
      piece_.reset();
    }
    if (ranks_.is_first()) {
      const auto first = hierarchy.levels.begin() + cut_levels;
      for (auto level = hierarchy.levels.begin(); level != first; ++level) { // nothing is asked of them
        *level = part_of(std::move(*level), all_of(first->grid.sites));
      }
      load_into(coarse_, hierarchy);
    }
  }

  void write_piece(const MethodStep& step) {
    const bool is_cut = share_.is_cut(step.level);
    if (is_cut) {
      valid(step.level, step.to) = halo(step.level);
    }
    compute(step.level, [&](ElasticSession& session) {
      session.write(step.level, step.to,
                    is_cut ? hdmbench::part_of(*step.values, share_.share(step.level).loaded[rank_])
                           : *step.values);
    });
  }

  /// How far beyond what a rank owns a field of a level is right, in sites.
  [[nodiscard]] int& valid(int level, ElasticField field) {
    return valid_.at(static_cast<std::size_t>(level)).at(static_cast<std::size_t>(field));
  }
  [[nodiscard]] int halo(int level) const { return share_.share(level).cut.halo; }
  [[nodiscard]] Extent sites(int level) const { return share_.levels.at(static_cast<std::size_t>(level)); }
  /// What this rank owns of a cut level, or of the one below.
  [[nodiscard]] VectorField owned(int level, ElasticField field) const {
    const Box& sites = share_.share(level).owned[rank_];
    VectorField own(sites.extent());
    on(piece_.get(), [&](const ElasticSession& piece) {
      VectorField loaded;
      piece.read(level, field, loaded);
      own = hdmbench::part_of(loaded, in_piece(level, sites));
    });
    return own;
  }
  /// Sites of a cut level, or of the one below, as the session of the piece numbers them.
  [[nodiscard]] Box in_piece(int level, Box part) const {
    const Box& loaded = share_.share(level).loaded[rank_];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      part.first[axis] -= loaded.first[axis];
      part.end[axis] -= loaded.first[axis];
    }
    return part;
  }
  /// call(session), where this rank has one.
  template <typename Call>
  static void on(ElasticSession* session, const Call& call) {
    if (session != nullptr) {
      ended_by_error_of_one([&] { call(*session); });
    }
  }
  /// The same with the one that computes the level.
  template <typename Call>
  void compute(int level, const Call& call) const {
    on(share_.is_cut(level) ? piece_.get() : coarse_.get(), call);
  }
  /// Renews the halo unless it is right that far.
  void want(int level, ElasticField field, int sites) {
    if (valid(level, field) >= sites) {
      return;
    }
    valid(level, field) = halo(level);
    const LevelShare& share = share_.share(level);
    const VectorField loaded = redistribute(halos_, rank_, share.owned, share.loaded, owned(level, field));
    on(piece_.get(), [&](ElasticSession& piece) { piece.write(level, field, loaded); });
  }

  void send_load() {
    const int level = share_.cut_levels();
    const std::vector<Box>& held = share_.share(level).owned;
    const VectorField whole = redistribute(halos_, rank_, held, all_on_first(sites(level), ranks_.size()),
                                           owned(level, ElasticField::load));
    on(coarse_.get(), [&](ElasticSession& coarse) { coarse.write(level, ElasticField::load, whole); });
  }

  /// How far corrections of the next level hold on this one.
  [[nodiscard]] int bring_correction(int level) {
    if (share_.is_cut(level + 1)) {
      want(level + 1, ElasticField::correction, 1);
      return 2 * valid(level + 1, ElasticField::correction) - 1;
    }
    const LevelShare& share = share_.share(level + 1);
    VectorField whole;
    on(coarse_.get(),
       [&](const ElasticSession& coarse) { coarse.read(level + 1, ElasticField::correction, whole); });
    const VectorField part =
        redistribute(halos_, rank_, all_on_first(sites(level + 1), ranks_.size()), share.loaded, whole);
    on(piece_.get(), [&](ElasticSession& piece) { piece.write(level + 1, ElasticField::correction, part); });
    return 2 * share.cut.halo - 1;
  }

  [[nodiscard]] float value_of_first(float value) const {
    const std::int64_t bits = ranks_.is_first() ? std::bit_cast<std::uint32_t>(value) : 0;
    return std::bit_cast<float>(static_cast<std::uint32_t>(halos_.sum(bits)));
  }

  Ranks& ranks_;
  std::size_t rank_;
  Sharing sharing_;
  faults::RankFault fault_;
  mutable faults::FaultyExchange halos_; ///< for halos, sums and coarse levels
  Open open_;
  ElasticShare share_;
  std::unique_ptr<ElasticSession> piece_;              ///< null where this rank has no piece
  std::unique_ptr<ElasticSession> coarse_;             ///< on the first rank
  std::vector<std::array<int, elastic_fields>> valid_; ///< of cut levels
};

} // namespace

std::unique_ptr<ElasticSession> open_elastic_on_ranks(Ranks& ranks, const Sharing& sharing,
                                                      const faults::RankFault& fault,
                                                      std::function<std::unique_ptr<ElasticSession>()> open) {
  return std::make_unique<RankElasticSession>(ranks, sharing, fault, std::move(open));
}

} // namespace hdmbench
