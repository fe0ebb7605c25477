#include "harness/check/verify.hpp"

#include "harness/check/compare.hpp"
#include "harness/check/follower.hpp"
#include "harness/check/one_piece.hpp"
#include "harness/check/resting_tiles.hpp"
#include "harness/check/verify_elastic.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace hdmbench {

namespace {

/// Those that go sweep by sweep and are not left out.
std::vector<Mode> followed_modes(const Scene& scene) {
  std::vector<Mode> modes{Mode::resync, Mode::free};
  if (why_left_out(Mode::active, scene).empty()) {
    modes.push_back(Mode::active);
  }
  return modes;
}

/// The reference and all that follow it.
class ReferenceRun {
public:
  ReferenceRun(const Scene& scene, const Backend& reference, std::span<const Backend* const> backends,
               const VerifyOptions& options, Progress& progress)
      : scene_(scene), schedule_(scene.schedule), backends_(backends), options_(options.session),
        limit_(options.iteration_limit), session_(reference.open(options.session)), progress_(progress) {
    SessionOptions of_followers = options_;
    of_followers.variant = options_.variant.value_or(0); // nothing is measured
    for (const Backend* backend : backends) {
      for (const Mode mode : followed_modes(scene)) {
        followers_.emplace_back(*backend, of_followers, scene, mode);
      }
    }
  }

  void compute(LevelSequence& levels, int index) {
    const Level& level = levels.sample(index);
    const VectorField begin = levels.begin(index, field_);
    iterations_ = 0;
    last_changed_ = 0;
    for (Follower& follower : followers_) {
      follower.begin_level(levels, level, index);
    }
    const int iterations = levels.iterations(index);
    const int limit = std::min(iterations, limit_.value_or(iterations));
    iterate(level, index, begin, limit);
    if (has_diverged(level, begin, field_)) {
      const Level& slower = levels.sample_without_acceleration(index);
      for (Follower& follower : followers_) {
        follower.begin_again(slower);
      }
      iterate(slower, index, begin, limit);
    }
    for (Follower& follower : followers_) {
      follower.end_level();
    }
  }

  /// Of each backend its modes; `levels` have all been computed.
  [[nodiscard]] std::vector<Comparison> finish(LevelSequence& levels) {
    const Conditions conditions{
        .exact = scene_.exact, .why_mistrusted = why_nothing_is_shown(), .sites_at_rest = sites_at_rest_};
    std::optional<Pyramid> pyramid = levels.pyramid();
    if (pyramid) {
      cap_sweeps(*pyramid);
    }
    std::vector<Comparison> comparisons;
    const std::size_t modes = followed_modes(scene_).size();
    for (std::size_t i = 0; i < followers_.size(); i += modes) {
      const std::span<Follower> of_backend = std::span(followers_).subspan(i, modes);
      for (Follower& follower : of_backend) {
        comparisons.push_back(follower.finish(conditions));
      }
      if (pyramid) {
        progress_.describe(fmt::format("verify {}, {}: in one piece on {}", scene_.name, method_name(scene_),
                                       comparisons.back().backend));
        comparisons.push_back(in_one_piece(levels, *pyramid, of_backend.subspan(1), *backends_[i / modes]));
        if (of_backend.front().session() != nullptr) {
          conclude(comparisons.back(), conditions);
        }
      }
    }
    return comparisons;
  }

private:
  [[nodiscard]] std::string why_nothing_is_shown() const {
    return inexact_.empty() ? why_mistrusted(scene_, changes_ > 0)
                            : fmt::format("the scene is declared exact, but {}", inexact_);
  }

  /// As the levels were computed.
  void cap_sweeps(Pyramid& pyramid) const {
    const int sweeps = sweeps_per_iteration(*pyramid.full);
    for (PyramidLevel& level : pyramid.levels) {
      level.sweeps = std::min(level.sweeps, limit_.value_or(level.sweeps / sweeps) * sweeps);
    }
  }

  [[nodiscard]] Comparison in_one_piece(LevelSequence& levels, const Pyramid& pyramid,
                                        std::span<Follower> followers, const Backend& backend) {
    const int index = levels.order().back();
    const ReferenceStep end{.level = levels.sample(index),
                            .level_index = index,
                            .iteration = iterations_,
                            .number = pyramid.levels.back().sweeps - 1,
                            .before = field_,
                            .after = field_,
                            .changed = last_changed_};
    return compare_in_one_piece(pyramid, end, followers, backend, options_);
  }

  void iterate(const Level& level, int index, const VectorField& begin, int limit) {
    session_->load(level);
    session_->write(begin);
    field_ = begin;
    tiles_.begin_level(level.extent);
    int number = 0;
    StopRule rule(schedule_, limit);
    for (int iteration = 1; rule.may_continue(iteration - 1); ++iteration) {
      std::int64_t changed_by_iteration = 0;
      for (int sweep = 0; sweep < sweeps_per_iteration(level); ++sweep) {
        require_exact(level, index, number);
        session_->step(1);
        session_->read(after_);
        last_changed_ = compare(field_, after_).sites;
        changed_by_iteration += last_changed_;
        sites_at_rest_ += tiles_.sweep(field_, after_);
        for (Follower& follower : followers_) {
          follower.follow({level, index, iteration, number, field_, after_, last_changed_});
        }
        std::swap(field_, after_);
        ++number;
      }
      iterations_ = iteration;
      changes_ += changed_by_iteration;
      rule.report(changed_by_iteration, level, field_);
      progress_.advance(static_cast<double>(level.extent.sites()));
    }
  }

  /// What a scene declares of every sweep.
  void require_exact(const Level& level, int index, int number) {
    if (scene_.exact && inexact_.empty()) {
      if (const auto found = first_inexact(level, field_, number)) {
        inexact_ = fmt::format("level {}, {}", index, found->text());
      }
    }
  }

  const Scene& scene_;
  const Schedule& schedule_;
  std::span<const Backend* const> backends_;
  SessionOptions options_;
  std::optional<int> limit_;
  std::unique_ptr<Session> session_;
  Progress& progress_;
  std::vector<Follower> followers_;
  VectorField field_; ///< the reference's newest
  VectorField after_;
  std::string inexact_;           ///< the first operation that is not, of a scene that is declared exact
  std::int64_t changes_ = 0;      ///< by the reference, over all sweeps
  int iterations_ = 0;            ///< of this level
  std::int64_t last_changed_ = 0; ///< by the last sweep of this level
  RestingTiles tiles_;
  std::int64_t sites_at_rest_ = 0; ///< over all sweeps
};

} // namespace

std::string why_left_out(Mode mode, const Scene& scene) {
  if (scene.energy == EnergyModel::elastic) {
    return mode == Mode::active ? "the methods of the elastic energy visit all sites" : "";
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
  if (scene.energy == EnergyModel::elastic) {
    return verify_elastic(scene, reference, backends, options, progress);
  }
  ReferenceRun run(scene, reference, backends, options, progress);
  LevelSequence levels(scene);
  for (const int index : levels.order()) {
    progress.describe(fmt::format("verify {}, {}: level {} of {}, {} x {}", scene.name, method_name(scene),
                                  index, levels.order().size(), levels.extent(index).width,
                                  levels.extent(index).height));
    run.compute(levels, index);
  }
  return run.finish(levels);
}

} // namespace hdmbench
