#include "harness/check/verify_elastic.hpp"

#include "harness/check/compare.hpp"
#include "harness/check/elastic_step.hpp"
#include "harness/check/follower.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

namespace hdmbench {

namespace {

using Bounded = BoundedElastic;

/// One backend in one mode.
struct ElasticFollower {
  std::unique_ptr<ElasticSession> session; ///< null: skipped
  Comparison comparison;
};

/// How far `found` is from the bounded number, in units of the bound. 0 of 0 is 0.
double gap_over_bound(const bounded::real& expected, float found) {
  const double gap = std::abs(static_cast<double>(found) - expected.exact());
  return gap == 0.0 ? 0.0 : gap / expected.error();
}

/// The reference, led by a method, and those that follow it. Fields of a hierarchy are compared as they are
/// made, so that all sessions have the reference's before every step.
class ElasticReferenceRun final : public SteppedElasticSession {
  /// ask(answers) of the reference's fields as they are, but for `replaced`, where there is one.
  template <typename Ask>
  auto with_bounds(const Ask& ask, const ElasticStep* step = nullptr,
                   const VectorField* replaced = nullptr) const {
    ElasticFields fields;
    fields.load(*hierarchy_);
    VectorField values;
    for (int level = 0; level < static_cast<int>(hierarchy_->levels.size()); ++level) {
      for (std::size_t field = 0; field < elastic_fields; ++field) {
        const auto which = static_cast<ElasticField>(field);
        if (!has_field(level, which)) {
          continue;
        }
        reference_.read(level, which, values);
        const bool is_replaced = step != nullptr && step->level == level && step->field == which;
        fields.write(level, which, all_of(values.extent), is_replaced ? *replaced : values);
      }
    }
    return ask(Bounded(*hierarchy_, fields));
  }

public:
  ElasticReferenceRun(ElasticSession& reference, std::span<ElasticFollower> followers)
      : reference_(reference), followers_(followers) {}

  void load(const ElasticHierarchy& hierarchy) override {
    hierarchy_ = &hierarchy;
    reference_.load(hierarchy);
    for (ElasticFollower& follower : running()) {
      try {
        follower.session->load(hierarchy);
        follower.comparison.levels = static_cast<int>(hierarchy.levels.size());
      } catch (const TooLarge& error) {
        follower.session.reset();
        follower.comparison.reason = error.what();
      }
    }
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    reference_.read(level, field, values);
  }
  float dot(ElasticField first, ElasticField second) const override {
    const float expected = reference_.dot(first, second);
    for (ElasticFollower& follower : running()) {
      Comparison& comparison = follower.comparison;
      const float found = follower.session->dot(first, second);
      if (!(found == expected)) {
        const double gap =
            gap_over_bound(with_bounds([&](const Bounded& of) { return of.dot(first, second); }), found);
        if (!(gap <= 1.0)) {
          ++comparison.counts_differing;
        } else {
          ++comparison.sites_differing;
          ++comparison.certified_ties;
          comparison.largest_gap_over_bound = std::max(comparison.largest_gap_over_bound, gap);
        }
      }
    }
    return expected;
  }

  [[nodiscard]] std::int64_t steps() const { return steps_; }

private:
  /// Those that are not skipped.
  [[nodiscard]] std::vector<std::reference_wrapper<ElasticFollower>> running() const {
    std::vector<std::reference_wrapper<ElasticFollower>> all;
    for (ElasticFollower& follower : followers_) {
      if (follower.session != nullptr) {
        all.emplace_back(follower);
      }
    }
    return all;
  }

  [[nodiscard]] Extent extent(int level) const {
    return hierarchy_->levels.at(static_cast<std::size_t>(level)).grid.sites;
  }

  [[nodiscard]] const ElasticHierarchy& hierarchy() const override { return *hierarchy_; }

  void take(const ElasticStep& step) override {
    VectorField before;
    VectorField expected;
    reference_.read(step.level, step.field, before);
    step.take(reference_);
    reference_.read(step.level, step.field, expected);
    ++steps_;
    VectorField found;
    for (ElasticFollower& follower : running()) {
      step.take(*follower.session);
      follower.session->read(step.level, step.field, found);
      const FieldDifference difference = compare(expected, found);
      Comparison& comparison = follower.comparison;
      ++comparison.sweeps;
      comparison.sites_compared += static_cast<std::int64_t>(extent(step.level).sites());
      if (difference.sites > 0) {
        comparison.sites_drifted += difference.sites;
        comparison.not_finite += difference.not_finite;
        comparison.largest_difference = std::max(comparison.largest_difference, difference.largest);
        judge(step, before, expected, found, comparison);
        follower.session->write(step.level, step.field, expected);
      }
    }
  }

  void judge(const ElasticStep& step, const VectorField& before, const VectorField& expected,
             const VectorField& found, Comparison& comparison) const {
    with_bounds(
        [&](const Bounded& of) {
          for (std::size_t site = 0; site < expected.x.size(); ++site) {
            if (!(expected.x[site] == found.x[site] && expected.y[site] == found.y[site])) {
              judge_site(step, of, expected, found, site, comparison);
            }
          }
          return 0;
        },
        &step, &before);
  }

  void judge_site(const ElasticStep& step, const Bounded& of, const VectorField& expected,
                  const VectorField& found, std::size_t site, Comparison& comparison) const {
    FirstDifference difference = difference_at(site, expected, found);
    difference.level = step.level;
    difference.iteration = static_cast<int>(steps_);
    difference.step = step.name;
    const Bounded::Answer answer = step.answer(of, difference.x, difference.y);
    const double gap =
        std::max(gap_over_bound(answer.x, found.x[site]), gap_over_bound(answer.y, found.y[site]));
    const bool holds = gap <= 1.0 && std::isfinite(found.x[site]) && std::isfinite(found.y[site]);
    count_site(comparison, {.holds = holds, .gap_over_bound = gap}, [&] { return difference; });
  }

  ElasticSession& reference_;
  std::span<ElasticFollower> followers_;
  const ElasticHierarchy* hierarchy_ = nullptr;
  std::int64_t steps_ = 0;
};

ElasticFollower open(const Scene& scene, const Backend& backend, const SessionOptions& options, Mode mode) {
  ElasticFollower follower;
  follower.comparison.backend = backend.name();
  follower.comparison.mode = mode;
  try {
    follower.comparison.device = backend.device(options);
    follower.comparison.reason = why_not_solved(scene, backend);
    if (follower.comparison.reason.empty()) {
      follower.session = backend.open_elastic(options);
    }
  } catch (const DeviceError& error) {
    follower.comparison.reason = error.what();
  }
  return follower;
}

/// What the reference made of the scene.
struct Followed {
  const Scene& scene;
  VectorField displacement;
  std::int64_t steps;
  std::string why_mistrusted;
};

/// The whole method on the backend alone, against the reference's end.
void run_alone(const Followed& reference, const ElasticFollower& led, ElasticFollower& alone) {
  if (led.session == nullptr) {
    alone.session.reset();
    alone.comparison.reason = led.comparison.reason;
    return;
  }
  Progress silent(false);
  const VectorField found = solve_elastic(reference.scene, *alone.session, silent).displacement;
  const FieldDifference difference = compare(reference.displacement, found);
  Comparison& comparison = alone.comparison;
  comparison.levels = led.comparison.levels;
  comparison.iterations = led.comparison.iterations;
  comparison.sweeps = reference.steps;
  const auto as_if_waited_for = [&] {
    ElasticReferenceRun waited_for(*alone.session, {}); // it reads after every step
    return solve_elastic(reference.scene, waited_for, silent).displacement;
  };
  const bool explained = difference.sites > 0 && led.comparison.uncertified == 0 &&
                         led.comparison.counts_differing == 0 && led.comparison.certified_ties > 0 &&
                         compare(found, as_if_waited_for()).sites == 0;
  count_end(comparison, difference, found.extent, explained, [&](std::size_t site) {
    FirstDifference first = difference_at(site, reference.displacement, found);
    first.iteration = static_cast<int>(reference.steps);
    first.step = "end";
    return first;
  });
}

} // namespace

std::vector<Comparison> verify_elastic(const Scene& scene_, const Backend& reference,
                                       std::span<const Backend* const> backends, const VerifyOptions& options,
                                       Progress& progress) {
  Scene scene = scene_;
  scene.schedule.iterations =
      std::min(scene.schedule.iterations, options.iteration_limit.value_or(scene.schedule.iterations));
  std::vector<ElasticFollower> led;
  for (const Backend* backend : backends) {
    led.push_back(open(scene, *backend, options.session, Mode::resync));
  }
  const std::unique_ptr<ElasticSession> session = reference.open_elastic(options.session);
  ElasticReferenceRun run(*session, led);
  progress.describe(fmt::format("verify {}, {}", scene.name, scene.schedule.method));
  const Solution solution = solve_elastic(scene, run, progress);
  Followed followed{scene, solution.displacement, run.steps(),
                    why_mistrusted(scene, largest_magnitude(solution.displacement) > 0.0)};
  std::vector<Comparison> comparisons;
  for (std::size_t i = 0; i < backends.size(); ++i) {
    led[i].comparison.iterations = scene.schedule.iterations;
    ElasticFollower alone = open(scene, *backends[i], options.session, Mode::pyramid);
    progress.describe(fmt::format("verify {}, {}: in one piece on {}", scene.name, scene.schedule.method,
                                  backends[i]->name()));
    run_alone(followed, led[i], alone);
    for (ElasticFollower* follower : {&led[i], &alone}) {
      if (follower->session != nullptr) {
        conclude(follower->comparison, {.exact = false, .why_mistrusted = followed.why_mistrusted});
      }
      comparisons.push_back(follower->comparison);
    }
  }
  return comparisons;
}

} // namespace hdmbench
