#include "harness/check/verify.hpp"

#include "harness/check/follower.hpp"
#include "harness/check/why.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace hdmbench {

namespace {

/// What the reference did in one sweep of one level.
struct ReferenceStep {
  const Level& level;
  FirstDifference place;
  int number; ///< of the sweep, since the level was loaded
  const VectorField& before;
  const VectorField& after;
  std::int64_t changed; ///< sites that differ between the two
};

/// The specification's answer to `before`.
VectorField specified(const ReferenceStep& step, const VectorField& before) {
  VectorField answers(before.extent);
  for_each_site(before.extent, [&](int x, int y, int z) {
    set_site(answers, before.extent.index(x, y, z),
             proofs_of(step.level).specified_answer(step.level, before, step.number, x, y, z));
  });
  return answers;
}

/// One backend that follows the reference sweep by sweep in one mode, and all that is found about it. In free
/// and active it is on its own.
struct Follower {
  FirstStep first{false};
  std::unique_ptr<Session> session{}; ///< null: skipped
  Comparison comparison{};
  VectorField field{};           ///< what the backend has
  std::int64_t last_changed = 0; ///< sites that its last sweep on this level really changed
  VectorField begin{};           ///< of the level
  bool explains = false;
  Evidence evidence{};  ///< where it explains, in resync
  bool drifted = false; ///< on its own: `field` is another one than the reference's

  /// From `begin`.
  void begin_level(const Level& level) {
    session->load(level);
    session->write(begin);
    field = begin;
    last_changed = 0;
    drifted = comparison.mode != Mode::resync && comparison.sites_drifted > 0;
  }

  void follow(const ReferenceStep& step, bool exact) {
    const bool alone = comparison.mode != Mode::resync;
    if (!alone) {
      session->write(step.before);
    }
    const VectorField before = alone ? field : step.before;
    first.record(comparison, [&] {
      session->step(1);
      session->read(field);
    });
    const FieldDifference drift = compare(step.after, field);
    const bool as_reference = !drifted && drift.sites == 0;
    bool is_first = false;
    if (!as_reference) {
      is_first =
          judge_step(comparison, drifted ? specified(step, before) : step.after, field, step.place,
                     [&](int x, int y, int z) {
                       Certificate certificate = proofs_of(step.level)
                                                     .certify(step.level, before, step.number, x, y, z,
                                                              site_of(field, field.extent.index(x, y, z)));
                       certificate.holds = certificate.holds && !exact; // there is no rounding to explain it
                       return certificate;
                     });
    }
    if (explains && !alone && drift.sites > 0) {
      keep_evidence(step);
    }
    drifted = alone && drift.sites > 0;
    last_changed = as_reference ? step.changed : compare(before, field).sites;
    ++comparison.sweeps;
    comparison.iterations = comparison.sweeps / sweeps_per_iteration(step.level);
    comparison.counts_differing += session->changed() == last_changed ? 0 : 1;
    count_field(comparison, field, drift);
    if (is_first) { // when changed() has been asked: the session has to be written to after this
      const auto read = [&](VectorField& values) { session->read(values); };
      first.keep(comparison, step.after, field, read,
                 [&](const VectorField& values) { session->write(values); });
    }
  }

  void keep_evidence(const ReferenceStep& step) {
    const Evidence::Step of{.level = step.place.level, .sites_kept = field.extent.sites()};
    // Sequential sites see others that have moved: nobody can compute one alone.
    if (step.level.update == Update::sequential || !evidence.wants(of)) {
      return;
    }
    // Copies: levels come and go.
    evidence.add(of, step.after, field,
                 [level = std::make_shared<const Level>(step.level), number = step.number,
                  before = std::make_shared<const VectorField>(step.before)](int x, int y, int z) {
                   return proofs_of(*level).replayed_answer(*level, *before, number, x, y, z);
                 });
  }
};

/// The reference and all that follow it.
class ReferenceRun {
public:
  ReferenceRun(const Scene& scene, const Backend& reference, std::span<const Backend* const> backends,
               const VerifyOptions& options, Progress& progress)
      : scene_(scene), levels_(scene), backends_(backends), options_(options.session),
        limit_(options.iteration_limit), session_(reference.open(options.session)), progress_(progress) {
    for (const Mode mode : {Mode::resync, Mode::free, Mode::active}) {
      if (why_left_out(mode, scene).empty()) {
        modes_.push_back(mode);
      }
    }
    for (const Backend* backend : backends) {
      for (const Mode mode : modes_) {
        Follower& follower = followers_.emplace_back();
        follower.explains = options.explains;
        follower.first = FirstStep(options.records && mode == Mode::resync);
        SessionOptions of_mode = options_of(mode);
        of_mode.recording = follower.first.recording();
        follower.comparison =
            begun(scene, *backend, of_mode, mode, [&] { follower.session = backend->open(of_mode); });
      }
    }
  }

  std::vector<Comparison> compare_all() {
    for (const int index : levels_.order()) {
      progress_.describe(fmt::format("verify {}, {}: level {} of {}, {}", scene_.name, method_name(scene_),
                                     index, levels_.order().size(), levels_.extent(index).text()));
      compute(index);
    }
    const Conditions conditions{
        .exact = scene_.exact,
        .why_mistrusted = inexact_.empty() ? why_mistrusted(scene_, changes_ > 0)
                                           : fmt::format("the scene is declared exact, but {}", inexact_),
        .sites_at_rest = sites_at_rest_};
    std::optional<Pyramid> pyramid = levels_.pyramid();
    for (std::size_t i = 0; pyramid && i < pyramid->levels.size(); ++i) { // as the levels were computed
      const int sweeps = sweeps_per_iteration(scene_.full);
      int& planned = pyramid->levels[i].sweeps;
      planned = std::min(planned, limit_.value_or(planned / sweeps) * sweeps);
    }
    std::vector<Comparison> comparisons;
    for (std::size_t i = 0; i < backends_.size(); ++i) {
      const std::span<Follower> modes = std::span(followers_).subspan(i * modes_.size(), modes_.size());
      for (Follower& follower : modes) {
        if (follower.session != nullptr) {
          conclude(follower.comparison, conditions);
        }
        follower.comparison.why = follower.evidence.explain().text();
        comparisons.push_back(follower.comparison);
      }
      if (pyramid) {
        progress_.describe(fmt::format("verify {}, {}: in one piece on {}", scene_.name, method_name(scene_),
                                       backends_[i]->name()));
        comparisons.push_back(in_one_piece(*pyramid, modes.subspan(1)));
        if (comparisons.back().reason.empty()) {
          conclude(comparisons.back(), conditions);
        }
      }
    }
    return comparisons;
  }

private:
  [[nodiscard]] SessionOptions options_of(Mode mode) const {
    SessionOptions options = options_;
    options.work = mode == Mode::active ? Work::active : Work::dense;
    return options;
  }

  void compute(int index) {
    const Level& level = levels_.sample(index);
    const VectorField begin = levels_.begin(index, field_);
    iterations_ = 0;
    last_changed_ = 0;
    each_present(followers_, [&](Follower& follower) {
      follower.begin = levels_.begin(index, follower.field);
      ++follower.comparison.levels;
    });
    iterate(level, index, begin);
    if (has_diverged(level, begin, field_)) {
      iterate(levels_.sample_without_acceleration(index), index, begin);
    }
  }

  void iterate(const Level& level, int index, const VectorField& begin) {
    session_->load(level);
    session_->write(begin);
    field_ = begin;
    tiles_.begin_level(level.extent);
    each_present(followers_, [&](Follower& follower) { follower.begin_level(level); });
    int number = 0;
    StopRule rule(scene_.schedule,
                  std::min(levels_.iterations(index), limit_.value_or(levels_.iterations(index))));
    for (int iteration = 1; rule.may_continue(iteration - 1); ++iteration) {
      std::int64_t changed_by_iteration = 0;
      for (int sweep = 0; sweep < sweeps_per_iteration(level); ++sweep, ++number) {
        if (scene_.exact && inexact_.empty()) {
          if (const auto found = proofs_of(level).first_inexact(level, field_, number)) {
            inexact_ = fmt::format("level {}, {}", index, found->text());
          }
        }
        VectorField after;
        session_->step(1);
        session_->read(after);
        last_changed_ = compare(field_, after).sites;
        changed_by_iteration += last_changed_;
        sites_at_rest_ += tiles_.sweep(field_, after);
        const FirstDifference place{.level = index, .iteration = iteration};
        each_present(followers_, [&](Follower& follower) {
          follower.follow({level, place, number, field_, after, last_changed_}, scene_.exact);
        });
        field_ = std::move(after);
      }
      iterations_ = iteration;
      changes_ += changed_by_iteration;
      rule.report(changed_by_iteration, level, field_);
      progress_.advance(static_cast<double>(level.extent.sites()));
    }
  }

  /// Mode::pyramid, after all levels have been followed: by the sessions of `followers`, one backend's free
  /// one and, where active is not left out, its active one. Without a verdict as yet, or skipped.
  [[nodiscard]] Comparison in_one_piece(const Pyramid& pyramid, std::span<Follower> followers) const {
    const Comparison& followed = followers.front().comparison;
    Comparison comparison{.backend = followed.backend,
                          .device = followed.device,
                          .mode = Mode::pyramid,
                          .levels = followed.levels,
                          .iterations = followed.iterations,
                          .sweeps = followed.sweeps,
                          .reason = {}};
    if (followers.front().session == nullptr) {
      comparison.reason = followed.reason;
      comparison.failed = followed.failed;
      comparison.was_not_opened = followed.was_not_opened;
      return comparison;
    }
    try {
      const Stopwatch watch(comparison.seconds);
      for (Follower& follower : followers) {
        if (follower.session != nullptr) {
          solve(pyramid, *follower.session, follower, comparison, &follower == &followers.back() ? 2 : 1);
        }
      }
    } catch (const DeviceError& error) {
      return broken_off(comparison, error);
    }
    return comparison;
  }

  void solve(const Pyramid& pyramid, Session& session, const Follower& follower, Comparison& comparison,
             int solutions = 1) const {
    VectorField found;
    session.load(pyramid);
    for (int i = 0; i < solutions; ++i) {
      session.solve();
      session.read(found);
      const bool is_other = compare(field_, found).sites > 0;
      const bool explained = is_other && follower.comparison.uncertified == 0 &&
                             follower.comparison.not_finite == 0 && compare(follower.field, found).sites == 0;
      if (explained) {
        comparison.largest_gap_over_bound =
            std::max(comparison.largest_gap_over_bound, follower.comparison.largest_gap_over_bound);
      }
      if (explained || !is_other) {
        const std::int64_t expected = explained ? follower.last_changed : last_changed_;
        comparison.counts_differing += session.changed() == expected ? 0 : 1;
      }
      judge_end(comparison, field_, found, {.level = levels_.order().back(), .iteration = iterations_},
                explained);
    }
  }

  const Scene& scene_;
  LevelSequence levels_;
  std::span<const Backend* const> backends_;
  SessionOptions options_;
  std::optional<int> limit_;
  std::unique_ptr<Session> session_;
  Progress& progress_;
  std::vector<Mode> modes_; ///< that go sweep by sweep and are not left out
  std::vector<Follower> followers_;
  VectorField field_;             ///< the reference's newest
  std::string inexact_;           ///< the first operation that is not, of a scene that is declared exact
  std::int64_t changes_ = 0;      ///< by the reference, over all sweeps
  int iterations_ = 0;            ///< of this level
  std::int64_t last_changed_ = 0; ///< by the last sweep of this level
  RestingTiles tiles_;
  std::int64_t sites_at_rest_ = 0; ///< over all sweeps
};

} // namespace

std::string why_left_out(Mode mode, const Scene& scene) {
  if (scene.energy->is_of_cells()) {
    return mode == Mode::active
               ? fmt::format("the methods of the {} energy visit all sites", scene.energy->name)
               : "";
  }
  if (mode == Mode::active) {
    Level level = without_fields(scene.full);
    level.rule = scene.schedule.rule;
    return changes_spread_by_contact(level)
               ? ""
               : "by this method any site can change in any sweep, so nothing can "
                 "be left out";
  }
  if (mode == Mode::pyramid) {
    return LevelSequence(scene).pyramid() ? ""
                                          : "a stop rule, a start, mean moduli or 1 / A want the host "
                                            "between the levels";
  }
  return {};
}

void excuse_nothing(Comparison& comparison) {
  if (comparison.verdict == Verdict::certified) {
    comparison.uncertified += std::exchange(comparison.certified_ties, 0);
    comparison.verdict = Verdict::disagree;
    comparison.tier = Tier::none;
  }
}

std::vector<Comparison> verify(const Scene& scene, const Backend& reference,
                               std::span<const Backend* const> backends, const VerifyOptions& options,
                               Progress& progress) {
  return scene.energy->is_of_cells()
             ? verify_elastic(scene, reference, backends, options, progress)
             : ReferenceRun(scene, reference, backends, options, progress).compare_all();
}

void find_lost(std::span<Comparison> now, std::span<const Comparison> before) {
  for (Comparison& one : now) {
    const bool was_there = std::ranges::any_of(before, [&](const Comparison& earlier) {
      return earlier.backend == one.backend && !earlier.was_not_opened;
    });
    if (one.was_not_opened && was_there) {
      one.failed = true;
      one.reason = "it was opened before and cannot be opened any more: " + one.reason;
    }
  }
}

} // namespace hdmbench
