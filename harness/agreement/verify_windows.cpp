#include "harness/agreement/verify_windows.hpp"

#include "harness/agreement/state_hash.hpp"
#include "harness/level_sequence.hpp"
#include "harness/solve.hpp"
#include "harness/stopwatch.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

void require_comparable(const Schedule& schedule) {
  const char* const reason =
      schedule.cycle != Cycle::one_way        ? "a method that goes to and fro between the levels"
      : schedule.stop != Stop::fixed          ? "another stop than a fixed number of iterations"
      : schedule.update == Update::sequential ? "sequential updates, which carry a change through the image"
      : schedule.rule == Rule::annealing ? "annealing, whose random numbers belong to places in the image"
                                         : nullptr;
  if (reason != nullptr) {
    throw InputError(fmt::format("windows cannot be compared for {}", reason));
  }
}

/// What scalar needs of a level to make a part of it.
struct Excerpt {
  Window inner;
  Window outer;
  Level level;
  VectorField begin{};
};

int iterations_of(const LevelSequence& levels, int index, const WindowOptions& options) {
  const int iterations = levels.iterations(index);
  return std::min(iterations, options.iteration_limit.value_or(iterations));
}

/// A pyramid that does as many iterations as the levels one by one.
std::optional<Pyramid> capped_pyramid(const LevelSequence& levels, const WindowOptions& options) {
  std::optional<Pyramid> pyramid = levels.pyramid();
  for (std::size_t i = 0; pyramid && i < pyramid->levels.size(); ++i) {
    pyramid->levels[i].sweeps =
        iterations_of(levels, levels.order()[i], options) * sweeps_per_iteration(pyramid->full->update);
  }
  return pyramid;
}

std::vector<Work> works_in_one_piece(const Scene& scene, const WindowOptions& options) {
  std::vector<Work> works;
  if (options.in_one_piece && why_left_out(Mode::pyramid, scene).empty()) {
    works.push_back(Work::dense);
    if (why_left_out(Mode::active, scene).empty()) {
      works.push_back(Work::active);
    }
  }
  return works;
}

/// The last field and the last count of a solution.
struct End {
  std::uint64_t field = 0; ///< state_hash()
  std::int64_t changed = 0;
};

class Examination {
public:
  Examination(Scene scene, const Backend& reference, const Backend& backend, const WindowOptions& options,
              Progress& progress)
      : scene_(std::move(scene)), reference_(reference), backend_(backend), options_(options),
        progress_(progress), levels_(scene_) {}

  [[nodiscard]] WindowedComparison examine() {
    WindowedComparison comparison;
    comparison.backend = backend_.name();
    std::unique_ptr<Session> session;
    try {
      comparison.device = backend_.device(options_.session);
      session = backend_.open(options_.session);
    } catch (const DeviceError& error) {
      comparison.reason = error.what();
      return comparison;
    }
    std::vector<std::pair<Work, End>> ends;
    for (const Work work : works_in_one_piece(scene_, options_)) {
      ends.emplace_back(work, solve_in_one_piece(work));
    }
    const bool starts_from_null = why_left_out(Mode::pyramid, scene_).empty();
    for (const int index : levels_.order()) {
      comparison.levels.push_back(examine_level(*session, index));
      if (starts_from_null) { // only the first level asks for it
        scene_.start = {};
      }
    }
    const std::int64_t changed = session->changed();
    session.reset();
    const bool finite = comparison.levels.back().not_finite == 0;
    const std::uint64_t field = finite && !ends.empty() ? state_hash(field_) : 0;
    for (const auto& [work, end] : ends) {
      comparison.pyramids.push_back(
          {.work = work, .same_field = finite && end.field == field, .same_count = end.changed == changed});
    }
    const bool agrees = std::ranges::all_of(comparison.levels,
                                            [](const WindowedLevel& level) {
                                              return level.sites_differing == 0 && !level.count_differs;
                                            }) &&
                        std::ranges::all_of(comparison.pyramids, [](const WindowedPyramid& pyramid) {
                          return pyramid.same_field && pyramid.same_count;
                        });
    comparison.verdict = agrees ? Verdict::agree : Verdict::disagree;
    return comparison;
  }

private:
  [[nodiscard]] End solve_in_one_piece(Work work) {
    SessionOptions options = options_.session;
    options.work = work;
    const std::unique_ptr<Session> session = backend_.open(options);
    describe(fmt::format("in one piece, {}", work_names[static_cast<std::size_t>(work)]));
    const std::optional<Pyramid> pyramid = capped_pyramid(levels_, options_);
    session->load(*pyramid);
    session->solve([&](double site_updates) { progress_.advance(site_updates); });
    session->read(field_);
    return {.field = state_hash(field_), .changed = session->changed()};
  }

  [[nodiscard]] WindowedLevel examine_level(Session& session, int index) {
    const Level& level = levels_.sample(index);
    WindowedLevel result{.level = index,
                         .extent = level.extent,
                         .iterations = iterations_of(levels_, index, options_),
                         .sweeps = 0,
                         .whole = level.extent.sites() <= options_.whole,
                         .windows = {}};
    result.sweeps = result.iterations * sweeps_per_iteration(level.update);
    result.windows =
        result.whole ? std::vector<Window>{{.extent = level.extent}} : choose_windows(level, options_.plan);
    std::vector<Excerpt> excerpts;
    for (const Window& window : result.windows) {
      const Window outer = with_influence(window, result.sweeps, level.extent);
      excerpts.push_back({.inner = window, .outer = outer, .level = crop(level, outer)});
    }
    session.load(level);
    if (index == levels_.order().back()) {
      release_scene();
    }
    field_ = levels_.begin(index, field_);
    for (Excerpt& excerpt : excerpts) {
      excerpt.begin = crop(field_, excerpt.outer);
    }
    session.write(field_);
    step(session, result);
    session.read(field_);
    for (const Excerpt& excerpt : excerpts) {
      compare_with(excerpt, session, result);
    }
    return result;
  }

  /// The session has its own copy of the last level.
  void release_scene() {
    Level& full = scene_.full;
    for (VectorField* const field : {&full.target, &full.confidence, &full.inverse_curvature}) {
      *field = {};
    }
    full.modulus = {};
    full.inverse_modulus = {};
  }

  void step(Session& session, const WindowedLevel& level) {
    constexpr int at_once = 8; // so that there is something to tell now and then
    const auto sites = static_cast<double>(level.extent.sites());
    const std::string what = fmt::format("level {} of {}, {} x {}", level.level, levels_.order().size(),
                                         level.extent.width, level.extent.height);
    describe(what);
    double seconds = 0.0;
    for (int done = 0; done < level.sweeps;) {
      const int sweeps = std::min(at_once, level.sweeps - done);
      {
        const Stopwatch watch(seconds);
        session.step(sweeps);
      }
      done += sweeps;
      describe(fmt::format("{}, {:.0f} Msites/s", what, 1e-6 * sites * done / seconds));
      progress_.advance(sites * sweeps);
    }
  }

  void compare_with(const Excerpt& excerpt, Session& session, WindowedLevel& result) {
    const std::unique_ptr<Session> scalar = reference_.open({});
    scalar->load(excerpt.level);
    scalar->write(excerpt.begin);
    scalar->step(result.sweeps);
    VectorField expected;
    scalar->read(expected);
    result.count_differs = result.whole && scalar->changed() != session.changed();
    result.sites_compared += static_cast<std::int64_t>(excerpt.inner.extent.sites());
    for (int y = excerpt.inner.y; y < excerpt.inner.y + excerpt.inner.extent.height; ++y) {
      for (int x = excerpt.inner.x; x < excerpt.inner.x + excerpt.inner.extent.width; ++x) {
        const std::size_t here = field_.extent.index(x, y);
        const std::size_t there = expected.extent.index(x - excerpt.outer.x, y - excerpt.outer.y);
        compare_site({.x = x,
                      .y = y,
                      .expected = {expected.x[there], expected.y[there]},
                      .found = {field_.x[here], field_.y[here]}},
                     result);
      }
    }
  }

  static void compare_site(const DifferingSite& site, WindowedLevel& result) {
    if (site.expected[0] == site.found[0] && site.expected[1] == site.found[1]) { // NaN equals nothing
      return;
    }
    ++result.sites_differing;
    if (std::isfinite(site.found[0]) && std::isfinite(site.found[1])) {
      for (const std::size_t component : {0U, 1U}) {
        result.largest_difference =
            std::max(result.largest_difference,
                     std::abs(static_cast<double>(site.expected[component]) - site.found[component]));
      }
    } else {
      ++result.not_finite;
    }
    result.first = result.first.value_or(site);
  }

  void describe(const std::string& what) {
    progress_.describe(fmt::format("windows of {}, {}: {}", scene_.name, backend_.name(), what));
  }

  Scene scene_;
  const Backend& reference_;
  const Backend& backend_;
  const WindowOptions& options_;
  Progress& progress_;
  LevelSequence levels_;
  VectorField field_; ///< the backend's newest
};

} // namespace

WindowedComparison verify_windows(Scene scene, const Backend& reference, const Backend& backend,
                                  const WindowOptions& options, Progress& progress) {
  require_comparable(scene.schedule);
  if (!backend.supports(scene.schedule.update)) {
    return {.backend = std::string(backend.name()),
            .reason = fmt::format("cannot update as {} wants", method_name(scene.schedule))};
  }
  scene.picture = {};
  scene.labels = {};
  return Examination(std::move(scene), reference, backend, options, progress).examine();
}

double windowed_site_updates(const Scene& scene, const WindowOptions& options) {
  const auto solutions = static_cast<double>(1 + works_in_one_piece(scene, options).size());
  return solutions * sweeps_per_iteration(scene.schedule.update) *
         site_updates(scene, options.iteration_limit);
}

} // namespace hdmbench
