#include "backends/cpu/elastic_answers.hpp"
#include "harness/check/bounded_real.hpp"
#include "harness/check/follower.hpp"
#include "harness/check/why.hpp"
#include "harness/solve/methods/elastic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace hdmbench {

namespace {

/// What a session makes of a site, each number with a bound of its rounding error.
using Bounded = ElasticAnswers<bounded::real>;
/// The same with the rewrites of a rewritten::Replay.
using Replayed = ElasticAnswers<rewritten::real>;

/// One backend in one mode.
struct ElasticFollower {
  FirstStep first;
  std::unique_ptr<ElasticSession> session{}; ///< null: skipped
  Comparison comparison{};
  Evidence evidence{};
};

/// How far `found` is from the bounded number, in units of the bound. 0 of 0 is 0.
double gap_over_bound(const bounded::real& expected, float found) {
  const double gap = std::abs(static_cast<double>(found) - expected.exact());
  return gap == 0.0 ? 0.0 : gap / expected.error();
}

/// The reference, led by a method, and those that follow it. Fields of a hierarchy are compared as they are
/// made, so that all sessions have the reference's before every step.
class ElasticReferenceRun final : public ElasticSession {
public:
  ElasticReferenceRun(ElasticSession& reference, std::span<ElasticFollower> followers, bool explains)
      : reference_(reference), followers_(followers), explains_(explains) {}

  void take(const MethodStep& step) override {
    VectorField before;
    VectorField expected;
    reference_.read(step.made_on(), step.to, before);
    reference_.take(step);
    reference_.read(step.made_on(), step.to, expected);
    ++steps_;
    each_present(followers_, [&](ElasticFollower& follower) {
      VectorField found;
      ElasticSession& session = *follower.session;
      const auto read = [&](VectorField& values) { session.read(step.made_on(), step.to, values); };
      const auto write = [&](const VectorField& values) { session.write(step.made_on(), step.to, values); };
      follower.first.record(follower.comparison, [&] {
        session.take(step);
        read(found);
      });
      const FieldDifference difference = compare(expected, found);
      ++follower.comparison.sweeps;
      count_field(follower.comparison, expected, difference);
      if (difference.sites > 0) {
        if (judge(step, before, expected, found, follower)) {
          follower.first.keep(follower.comparison, expected, found, read, write);
        }
        write(expected);
      }
    });
  }

  /// All that compute these do, whether or not solutions want them to.
  bool has_own_laws() const override { return true; }
  /// No bound of rounding is derived for laws: their bits are the host's, or it is a mistake.
  std::optional<LeastVolume> law_forces(const LawForces& tissues, const VectorField& displacement,
                                        VectorField& force) override {
    const LeastVolume least = tissues(displacement, force);
    ++steps_;
    each_present(followers_, [&](ElasticFollower& follower) {
      VectorField found;
      std::optional<LeastVolume> own;
      ElasticSession& session = *follower.session;
      follower.first.record(follower.comparison,
                            [&] { own = session.law_forces(tissues, displacement, found); });
      if (!own) {
        follower.comparison.has_hosts_laws = true;
        return;
      }
      ++follower.comparison.sweeps;
      const FieldDifference difference = compare(force, found);
      count_field(follower.comparison, force, difference);
      const bool is_least = own->share == least.share && own->site == least.site;
      follower.comparison.counts_differing += difference.sites == 0 && !is_least ? 1 : 0;
      const FirstDifference place{
          .level = 0, .iteration = static_cast<int>(steps_), .step = "forces of laws"};
      if (difference.sites > 0 &&
          judge_step(follower.comparison, force, found, place, [](int, int, int) { return Certificate{}; })) {
        follower.first.keep(
            follower.comparison, force, found,
            [&](VectorField& values) { session.read(0, ElasticField::image, values); },
            [&](const VectorField& values) { session.write(0, ElasticField::image, values); });
      }
    });
    return least;
  }

  void read(int level, ElasticField field, VectorField& values) const override {
    reference_.read(level, field, values);
  }
  float dot(ElasticField first, ElasticField second) const override {
    const float expected = reference_.dot(first, second);
    each_present(followers_, [&](ElasticFollower& follower) {
      Comparison& comparison = follower.comparison;
      const float found = follower.session->dot(first, second);
      if (found == expected) {
        return;
      }
      const ElasticFields fields = fields_now();
      const double gap = gap_over_bound(Bounded(hierarchy(), fields).dot(first, second), found);
      if (!(gap <= 1.0)) {
        ++comparison.counts_differing;
      } else {
        ++comparison.sites_differing;
        ++comparison.certified_ties;
        comparison.largest_gap_over_bound = std::max(comparison.largest_gap_over_bound, gap);
      }
    });
    return expected;
  }

  [[nodiscard]] std::int64_t steps() const { return steps_; }

private:
  double do_load_body(const ElasticBody& body) override {
    double seconds = 0.0;
    load(timed(seconds, [&] { return make_elastic_hierarchy(body); }));
    reference_.load(body);
    each_present(followers_, [&](ElasticFollower& follower) {
      follower.session->load(body);
      follower.comparison.levels = static_cast<int>(hierarchy().levels.size());
    });
    return seconds;
  }
  void do_load(ElasticHierarchy& /*hierarchy*/) override { kept_.reset(); }

  /// All of the reference.
  [[nodiscard]] ElasticFields fields_now() const {
    ElasticFields fields;
    fields.load(hierarchy());
    VectorField values;
    for (int level = 0; level < static_cast<int>(hierarchy().levels.size()); ++level) {
      for (std::size_t i = 0; i < elastic_fields; ++i) {
        const auto field = static_cast<ElasticField>(i);
        if (has_field(level, field)) {
          reference_.read(level, field, values);
          fields.write(level, field, values);
        }
      }
    }
    return fields;
  }

  /// Returns what judge_step() does.
  bool judge(const MethodStep& step, const VectorField& before, const VectorField& expected,
             const VectorField& found, ElasticFollower& follower) const {
    const auto fields = std::make_shared<ElasticFields>(fields_now());
    fields->write(step.made_on(), step.to, before);
    keep_evidence(step, fields, expected, found, follower);
    const Bounded of(hierarchy(), *fields);
    return judge_step(
        follower.comparison, expected, found,
        {.level = step.made_on(), .iteration = static_cast<int>(steps_), .step = std::string(step.name())},
        [&](int x, int y, int z) {
          const std::size_t site = found.extent.index(x, y, z);
          const Bounded::Answer answer = of.of(step, x, y, z);
          double gap = 0.0;
          for (std::size_t axis = 0; axis < found.extent.axes(); ++axis) {
            gap = std::max(gap, gap_over_bound(answer[axis], found[axis][site]));
          }
          return Certificate{.holds = gap <= 1.0 && is_finite(found, site), .gap_over_bound = gap};
        });
  }

  /// A step that writes has no arithmetic, and what it wrote will be gone.
  void keep_evidence(const MethodStep& step, const std::shared_ptr<const ElasticFields>& fields,
                     const VectorField& expected, const VectorField& found, ElasticFollower& follower) const {
    const bool is_of_many = step.kind == MethodStep::Kind::restrict_residual;
    const Evidence::Step of{.level = step.level,
                            .kind = static_cast<int>(step.kind),
                            .sites_kept = grid(0).sites.sites(),
                            .cost = is_of_many ? 27 : 1};
    if (explains_ && step.kind != MethodStep::Kind::write && follower.evidence.wants(of)) {
      follower.evidence.add(of, expected, found,
                            [fields, step, hierarchy = kept_hierarchy()](int x, int y, int z) {
                              return replayed(*hierarchy, *fields, step, x, y, z);
                            });
    }
  }

  /// What is stored on the way is a number, whatever it was made by.
  [[nodiscard]] static SiteAnswer replayed(const ElasticHierarchy& hierarchy, const ElasticFields& fields,
                                           const MethodStep& step, int x, int y, int z) {
    const Replayed of(hierarchy, fields);
    const auto as_stored = [](Replayed::Answer answer) {
      for (rewritten::real& number : answer) {
        number = stored(number);
      }
      return answer;
    };
    const Replayed::Answer answer =
        step.restricts()
            ? of.restricted(step.level, x, y, z,
                            [&](int i, int j, int k) { return as_stored(of.handed_down(step, i, j, k)); })
            : of.of(step, x, y, z);
    return {stored(answer[0]), stored(answer[1]), stored(answer[2])};
  }

  /// A copy for the time after the method has ended.
  [[nodiscard]] std::shared_ptr<const ElasticHierarchy> kept_hierarchy() const {
    if (kept_ == nullptr) {
      kept_ = std::make_shared<const ElasticHierarchy>(hierarchy());
    }
    return kept_;
  }

  ElasticSession& reference_;
  std::span<ElasticFollower> followers_;
  bool explains_;
  mutable std::shared_ptr<const ElasticHierarchy> kept_;
  std::int64_t steps_ = 0;
};

} // namespace

std::vector<Comparison> verify_elastic(const Scene& scene_, const Backend& reference,
                                       std::span<const Backend* const> backends, const VerifyOptions& options,
                                       Progress& progress) {
  Scene scene = scene_;
  int& iterations = scene.schedule.iterations;
  iterations = std::min(iterations, options.iteration_limit.value_or(iterations));
  std::vector<ElasticFollower> followers;
  for (const Backend* const backend : backends) {
    followers.push_back({.first = FirstStep(options.records)});
    ElasticFollower& follower = followers.back();
    SessionOptions own = options.session;
    own.recording = follower.first.recording();
    follower.comparison =
        begun(scene, *backend, own, Mode::resync, [&] { follower.session = backend->open_elastic(own); });
  }
  const std::unique_ptr<ElasticSession> session = reference.open_elastic(options.session);
  ElasticReferenceRun run(*session, followers, options.explains);
  progress.describe(fmt::format("verify {}, {}", scene.name, scene.schedule.method));
  const VectorField expected = solve_elastic(scene, run, progress).displacement;
  const FirstDifference end{.iteration = static_cast<int>(run.steps()), .step = "end"};
  Progress silent(false);
  std::vector<Comparison> comparisons;
  for (std::size_t i = 0; i < backends.size(); ++i) {
    Comparison& led = followers[i].comparison;
    led.iterations = iterations;
    led.why = followers[i].evidence.explain().text();
    Comparison alone{.backend = led.backend,
                     .device = led.device,
                     .mode = Mode::pyramid,
                     .levels = led.levels,
                     .iterations = iterations,
                     .sweeps = run.steps(),
                     .reason = led.reason};
    alone.failed = led.failed;
    alone.was_not_opened = led.was_not_opened;
    if (followers[i].session != nullptr) {
      progress.describe(
          fmt::format("verify {}, {}: in one piece on {}", scene.name, scene.schedule.method, led.backend));
      const Conditions conditions{.why_mistrusted = why_mistrusted(scene, largest_magnitude(expected) > 0.0)};
      conclude(led, conditions);
      try {
        const Stopwatch watch(alone.seconds);
        const std::unique_ptr<ElasticSession> own = backends[i]->open_elastic(options.session);
        const VectorField found = solve_elastic(scene, *own, silent).displacement;
        const bool is_certified = led.uncertified == 0 && led.counts_differing == 0 && led.certified_ties > 0;
        ElasticReferenceRun waited_for(*own, {}, false); // it reads after every step
        const bool explained =
            is_certified && compare(expected, found).sites > 0 &&
            compare(found, solve_elastic(scene, waited_for, silent).displacement).sites == 0;
        judge_end(alone, expected, found, end, explained);
        conclude(alone, conditions);
      } catch (const DeviceError& error) {
        alone = broken_off(alone, error);
      }
    }
    comparisons.insert(comparisons.end(), {led, alone});
  }
  return comparisons;
}

} // namespace hdmbench
