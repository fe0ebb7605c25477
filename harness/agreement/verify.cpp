#include "harness/agreement/verify.hpp"

#include "harness/agreement/compare.hpp"
#include "harness/agreement/exactness.hpp"
#include "harness/agreement/follower.hpp"
#include "harness/level_sequence.hpp"
#include "harness/solve.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace hdmbench {

namespace {

/// A scene that prescribes more than all but this leaves backends next to nothing to get wrong.
constexpr double least_free_share = 0.01;

/// Of the components, those without any observation.
double free_share(const VectorField& confidence) {
  const auto free = std::ranges::count(confidence.x, 0.0F) + std::ranges::count(confidence.y, 0.0F);
  return static_cast<double>(free) / (2.0 * static_cast<double>(confidence.x.size()));
}

/// The reference and all that follow it.
class Procession {
public:
  Procession(const Scene& scene, const Backend& reference, std::span<const Backend* const> backends,
             const VerifyOptions& options, Progress& progress)
      : scene_(scene), schedule_(scene.schedule), limit_(options.iteration_limit),
        session_(reference.open(options.session)), progress_(progress) {
    for (const Backend* backend : backends) {
      for (const Mode mode : {Mode::resync, Mode::free}) {
        followers_.emplace_back(*backend, options.session, scene, mode);
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
      comparisons.push_back(follower.finish(why_mistrusted()));
    }
    return comparisons;
  }

private:
  /// Why agreement on this scene would say nothing; empty where it does.
  [[nodiscard]] std::string why_mistrusted() const {
    if (!inexact_.empty()) {
      return fmt::format("the scene is declared exact, but {}", inexact_);
    }
    if (changes_ == 0) {
      return "no site ever moved, so a backend that does nothing would pass";
    }
    const double free = free_share(scene_.full.confidence);
    if (free < least_free_share) {
      return fmt::format("only {:.2g} % of the components are free, so almost nothing was computed",
                         100.0 * free);
    }
    return {};
  }

  void iterate(const Level& level, int index, const VectorField& begin, int limit) {
    session_->load(level);
    session_->write(begin);
    field_ = begin;
    int number = 0;
    StopRule rule(schedule_, limit);
    for (int iteration = 1; rule.may_continue(iteration - 1); ++iteration) {
      std::int64_t changed_by_iteration = 0;
      for (int sweep = 0; sweep < sweeps_per_iteration(level.update); ++sweep) {
        require_exact(level, index, number);
        session_->step(1);
        session_->read(after_);
        const std::int64_t changed = compare(field_, after_).sites;
        changed_by_iteration += changed;
        for (Follower& follower : followers_) {
          follower.follow({level, index, iteration, number, field_, after_, changed});
        }
        std::swap(field_, after_);
        ++number;
      }
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
  std::optional<int> limit_;
  std::unique_ptr<Session> session_;
  Progress& progress_;
  std::vector<Follower> followers_;
  VectorField field_; ///< the reference's newest
  VectorField after_;
  std::string inexact_;      ///< the first operation that is not, of a scene that is declared exact
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
