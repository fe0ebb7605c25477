#include "harness/ranks/elastic_solution.hpp"

#include "harness/ranks/redistribution.hpp"
#include "harness/solve/field_norms.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace hdmbench {

namespace {

/// Of what this rank owns, in image coordinates; then of all.
class Conditions {
public:
  Conditions(const Level& part, const Rectangle& owned, const Rectangle& loaded) {
    for (int y = owned.top; y < owned.top + owned.height; ++y) {
      for (int x = owned.left; x < owned.left + owned.width; ++x) {
        const std::size_t at = part.extent.index(x - loaded.left, y - loaded.top);
        rows_.add(y, part.confidence.x[at]);
        columns_.add(x, part.confidence.y[at]);
        softest_ = std::min(softest_, static_cast<double>(part.modulus.values[at]));
        stiffest_ = std::max(stiffest_, static_cast<double>(part.modulus.values[at]));
        sprung_ = sprung_ || is_spring(part.confidence.x[at]) || is_spring(part.confidence.y[at]);
      }
    }
  }

  /// Collective. Throws InputError.
  void require_held(Extent image, Ranks& ranks) const {
    hdmbench::require_held(image, hold_of(&Known::by_any, ranks));
    const ModulusRange moduli = range(ranks);
    if (moduli.softest < static_cast<double>(void_share) * moduli.stiffest) {
      throw InputError(
          "there is void in the tissue (pixels with next to no modulus), which may cut off a part "
          "that no condition holds: that is judged on one rank only; leave out mpirun");
    }
  }
  /// Collective: of the moduli of all ranks.
  [[nodiscard]] ModulusRange range(Ranks& ranks) const {
    return {.softest = -ranks.largest(-softest_), .stiffest = ranks.largest(stiffest_)};
  }
  /// Collective: what prescribed components leave to the image.
  [[nodiscard]] std::vector<RigidMotion> motions(Extent image, Ranks& ranks) const {
    return hold_of(&Known::for_good, ranks).motions(image);
  }
  /// Collective.
  [[nodiscard]] bool sprung(Ranks& ranks) const { return ranks.largest(sprung_ ? 1.0 : 0.0) > 0.0; }

private:
  /// The smallest and the largest of some numbers.
  struct Between {
    static constexpr double none = -std::numeric_limits<double>::infinity();
    double minus_least = none;
    double most = none;

    void add(int number) {
      minus_least = std::max(minus_least, -static_cast<double>(number));
      most = std::max(most, static_cast<double>(number));
    }
    [[nodiscard]] std::vector<double> of_all(Ranks& ranks) const {
      const double least = -ranks.largest(minus_least);
      const double last = ranks.largest(most);
      return last == none ? std::vector<double>{} : std::vector{least, last};
    }
  };

  /// Rows or columns with a condition.
  struct Known {
    Between by_any;
    Between for_good; ///< prescribed

    void add(int number, float confidence) {
      if (confidence > 0.0F) {
        by_any.add(number);
      }
      if (confidence >= 1.0F) {
        for_good.add(number);
      }
    }
  };

  [[nodiscard]] Hold hold_of(Between Known::*which, Ranks& ranks) const {
    Hold hold;
    for (const double row : (rows_.*which).of_all(ranks)) {
      hold.know_x(static_cast<int>(row));
    }
    for (const double column : (columns_.*which).of_all(ranks)) {
      hold.know_y(static_cast<int>(column));
    }
    return hold;
  }

  Known rows_;    ///< with an x
  Known columns_; ///< with a y
  double softest_ = std::numeric_limits<double>::infinity();
  double stiffest_ = 0.0;
  bool sprung_ = false;
};

/// One component of the sites that this rank loads, right where it owns them.
std::vector<float> extended(const Level& part, const std::vector<float>& target,
                            const std::vector<float>& confidence, const ElasticShare& share, Ranks& ranks) {
  const auto rank = static_cast<std::size_t>(ranks.rank());
  const LevelShare& below = share.share(share.cut_levels());
  const Extent sites = share.levels[static_cast<std::size_t>(share.cut_levels())];
  const std::vector<Rectangle> first = all_on_first(sites, ranks.size());
  const bool has_piece = part.extent.sites() > 0;

  std::vector<Known> known{known_component(part.extent, target, confidence)};
  for (int level = 0; level < share.cut_levels() && has_piece; ++level) {
    known.push_back(averaged(known.back()));
  }
  const auto gather = [&](const std::vector<float>& values) {
    Rectangle own = below.owned[rank];
    ScalarField held;
    held.extent = own.extent();
    held.values.resize(held.extent.sites());
    copy(own, values, below.loaded[rank], held.values, own);
    return redistribute(ranks, rank, below.owned, first, held.values);
  };
  Known whole(ranks.is_first() ? sites : Extent{});
  whole.value = gather(known.back().value);
  whole.weight = gather(known.back().weight);
  if (ranks.is_first()) {
    extend(whole);
  }
  known.back().value = redistribute(ranks, rank, first, below.loaded, whole.value);
  for (std::size_t level = known.size() - 1; level > 0; --level) {
    fill(known[level - 1], known[level]);
  }
  return std::move(known.front().value);
}

} // namespace

VectorField extended_conditions_on_ranks(const Level& part, const ElasticShare& share, Ranks& ranks) {
  const auto rank = static_cast<std::size_t>(ranks.rank());
  VectorField loaded;
  loaded.extent = part.extent;
  loaded.x = extended(part, part.target.x, part.confidence.x, share, ranks);
  loaded.y = extended(part, part.target.y, part.confidence.y, share, ranks);
  VectorField own(share.image().owned[rank].extent());
  copy(share.image().owned[rank], loaded, share.image().loaded[rank], own, share.image().owned[rank]);
  return own;
}

namespace {

/// The moduli and conditions of the sites that a rank owns, of those that it loads.
Level owned_level(const Level& part, const Rectangle& owned, const Rectangle& loaded) {
  Level level{.extent = owned.extent(),
              .target = VectorField(owned.extent()),
              .confidence = VectorField(owned.extent()),
              .modulus = ScalarField(owned.extent())};
  copy(owned, part.target, loaded, level.target, owned);
  copy(owned, part.confidence, loaded, level.confidence, owned);
  copy(owned, part.modulus.values, loaded, level.modulus.values, owned);
  return level;
}

} // namespace

RankedSolution solve_elastic_on_ranks(const ScenePart& part, RankedElastic& steps, Ranks& ranks,
                                      Progress& progress) {
  const Clock clock;
  const ElasticShare& share = steps.share();
  const auto rank = static_cast<std::size_t>(ranks.rank());
  const Rectangle owned = share.image().owned[rank];
  const Rectangle loaded = share.image().loaded[rank];
  const Conditions conditions(part.full, owned, loaded);
  conditions.require_held(part.scene.extent(), ranks);
  const double largest = ranks.largest(static_cast<double>(largest_component(part.full.target)));
  std::optional<Level> scaled;
  if (const int exponent = exponent_to_safe_moduli(conditions.range(ranks)); exponent != 0) {
    scaled = part.full;
    scale_moduli(*scaled, exponent);
  }
  const Level& full = scaled ? *scaled : part.full;
  ElasticSolver solver(
      steps, [&](Springs springs) { steps.load(full, part.scene.poisson, springs); }, share.levels,
      extended_conditions_on_ranks(full, share, ranks), conditions.sprung(ranks));
  follow(elastic_method(part.scene.schedule, largest), solver,
         static_cast<double>(part.scene.extent().sites()), progress);
  solver.settle(owned_level(full, owned, loaded), owned.left, owned.top,
                conditions.motions(part.scene.extent(), ranks));

  RankedSolution solution{.owned = owned, .displacement = solver.displacement(), .levels = {}};
  for (const LevelResult& work : solver.work()) {
    RankedLevel& level = solution.levels.emplace_back();
    level.extent = work.extent;
    level.sweeps = work.iterations;
    if (share.is_cut(work.level)) {
      const Cut& cut = share.share(work.level).cut;
      level.pieces = cut.pieces.size();
      level.columns = cut.columns;
      level.halo = cut.halo;
    }
    if (work.level <= share.cut_levels()) {
      const RankedElastic::Sent& sent = steps.sent()[static_cast<std::size_t>(work.level)];
      level.renewals = sent.times;
      level.halos = sent.traffic;
    }
  }
  std::ranges::reverse(solution.levels);
  solution.levels.back().seconds = clock.seconds();
  return solution;
}

} // namespace hdmbench
