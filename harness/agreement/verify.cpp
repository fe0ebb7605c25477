#include "harness/agreement/verify.hpp"

#include "harness/agreement/compare.hpp"
#include "harness/level_sequence.hpp"
#include "harness/solve.hpp"
#include "kernels/input_error.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace hdmbench {

namespace {

/// What the reference did in one iteration of one level.
struct ReferenceStep {
  const Level& level;
  int level_index;
  int iteration;
  const VectorField& before;
  const VectorField& after;
  std::int64_t changed;
};

/// The energies that the two answers give the site, all else being as the reference had it before the
/// iteration.
FirstDifference describe_difference(const ReferenceStep& step, const VectorField& found, std::size_t site) {
  const auto width = static_cast<std::size_t>(step.level.extent.width);
  FirstDifference first{.level = step.level_index,
                        .iteration = step.iteration,
                        .x = static_cast<int>(site % width),
                        .y = static_cast<int>(site / width),
                        .expected = {step.after.x[site], step.after.y[site]},
                        .found = {found.x[site], found.y[site]}};
  const ThesisEnergy energy(step.level, step.before);
  const auto total = [](ThesisEnergy::Value value) { return value.x + value.y; };
  first.energy_before = total(energy.at(first.x, first.y));
  first.energy_expected = total(energy.at(first.x, first.y, {first.expected[0], first.expected[1]}));
  first.energy_found = total(energy.at(first.x, first.y, {first.found[0], first.found[1]}));
  return first;
}

/// One backend that follows the reference in one mode.
class Follower {
public:
  Follower(const Backend& backend, const SessionOptions& options, const Schedule& schedule, Mode mode) {
    comparison_.backend = backend.name();
    comparison_.mode = mode;
    if (!backend.supports(schedule.update)) {
      comparison_.reason = fmt::format("cannot update as {} wants", method_name(schedule));
      return;
    }
    try {
      comparison_.device = backend.device(options);
      session_ = backend.open(options);
    } catch (const DeviceError& error) {
      comparison_.reason = error.what();
    }
  }

  void begin_level(const LevelSequence& levels, const Level& level, int index) {
    if (session_ != nullptr) {
      begin_ = levels.begin(index, displacement_);
      ++comparison_.levels;
      begin_again(level);
    }
  }

  /// From the field that the level began with.
  void begin_again(const Level& level) {
    if (session_ != nullptr) {
      session_->load(level);
      session_->write(begin_);
    }
  }

  void follow(const ReferenceStep& step) {
    if (session_ == nullptr) {
      return;
    }
    if (comparison_.mode == Mode::resync) {
      session_->write(step.before);
    }
    session_->step(1);
    session_->read(displacement_);
    const FieldDifference difference = compare(step.after, displacement_);
    ++comparison_.sweeps;
    comparison_.iterations = comparison_.sweeps / sweeps_per_iteration(step.level.update);
    comparison_.sites_compared += static_cast<std::int64_t>(step.level.extent.sites());
    comparison_.sites_differing += difference.sites;
    comparison_.not_finite += difference.not_finite;
    comparison_.counts_differing += session_->changed() == step.changed ? 0 : 1;
    comparison_.largest_difference = std::max(comparison_.largest_difference, difference.largest);
    if (difference.first && !comparison_.first) {
      comparison_.first = describe_difference(step, displacement_, *difference.first);
    }
  }

  /// A level without iterations still hands its field on.
  void end_level() {
    if (session_ != nullptr) {
      session_->read(displacement_);
    }
  }

  [[nodiscard]] Comparison finish(std::int64_t reference_changes) {
    if (session_ != nullptr) {
      const bool equal = comparison_.sites_differing == 0 && comparison_.counts_differing == 0;
      comparison_.verdict = equal ? Verdict::agree : Verdict::disagree;
      if (equal && reference_changes == 0) {
        comparison_.verdict = Verdict::mistrusted;
        comparison_.reason = "no site ever moved, so a backend that does nothing would pass";
      }
    }
    return comparison_;
  }

private:
  std::unique_ptr<Session> session_; ///< null: skipped
  VectorField displacement_;
  VectorField begin_; ///< of the level
  Comparison comparison_;
};

/// The reference and all that follow it.
class Procession {
public:
  Procession(const Scene& scene, const Backend& reference, std::span<const Backend* const> backends,
             const VerifyOptions& options, Progress& progress)
      : schedule_(scene.schedule), limit_(options.iteration_limit), session_(reference.open(options.session)),
        progress_(progress) {
    for (const Backend* backend : backends) {
      for (const Mode mode : {Mode::resync, Mode::free}) {
        followers_.emplace_back(*backend, options.session, schedule_, mode);
      }
    }
  }

  void compute(LevelSequence& levels, int index) {
    const Level& level = levels.sample(index);
    const VectorField begin = levels.begin(index, field_);
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

  [[nodiscard]] std::vector<Comparison> finish() {
    std::vector<Comparison> comparisons;
    comparisons.reserve(followers_.size());
    for (Follower& follower : followers_) {
      comparisons.push_back(follower.finish(changes_));
    }
    return comparisons;
  }

private:
  void iterate(const Level& level, int index, const VectorField& begin, int limit) {
    session_->load(level);
    session_->write(begin);
    field_ = begin;
    StopRule rule(schedule_, limit);
    for (int iteration = 1; rule.may_continue(iteration - 1); ++iteration) {
      std::int64_t changed_by_iteration = 0;
      for (int sweep = 0; sweep < sweeps_per_iteration(level.update); ++sweep) {
        session_->step(1);
        session_->read(after_);
        const std::int64_t changed = session_->changed();
        changed_by_iteration += changed;
        for (Follower& follower : followers_) {
          follower.follow({level, index, iteration, field_, after_, changed});
        }
        std::swap(field_, after_);
      }
      changes_ += changed_by_iteration;
      rule.report(changed_by_iteration, level, field_);
      progress_.advance(static_cast<double>(level.extent.sites()));
    }
  }

  const Schedule& schedule_;
  std::optional<int> limit_;
  std::unique_ptr<Session> session_;
  Progress& progress_;
  std::vector<Follower> followers_;
  VectorField field_; ///< the reference's newest
  VectorField after_;
  std::int64_t changes_ = 0; ///< by the reference, over all sweeps
};

} // namespace

std::vector<Comparison> verify(const Scene& scene, const Backend& reference,
                               std::span<const Backend* const> backends, const VerifyOptions& options,
                               Progress& progress) {
  if (scene.schedule.cycle != Cycle::one_way) {
    throw InputError(
        fmt::format("verify follows a method sweep by sweep along the pyramid, {} goes to and fro; "
                    "bench compares its fields",
                    scene.schedule.method));
  }
  Procession procession(scene, reference, backends, options, progress);
  LevelSequence levels(scene);
  for (const int index : levels.order()) {
    progress.describe(fmt::format("verify {}, {}: level {} of {}, {} x {}", scene.name,
                                  method_name(scene.schedule), index, levels.order().size(),
                                  levels.extent(index).width, levels.extent(index).height));
    procession.compute(levels, index);
  }
  return procession.finish();
}

} // namespace hdmbench
