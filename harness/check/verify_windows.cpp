#include "harness/check/verify_windows.hpp"

#include "harness/check/compare.hpp"
#include "harness/check/state_hash.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/solve/solve.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

void require_comparable(const Scene& scene) {
  const Schedule& schedule = scene.schedule;
  const char* const reason =
      schedule.cycle != Cycle::one_way          ? "a method that goes to and fro between the levels"
      : schedule.stop != Stop::fixed            ? "another stop than a fixed number of iterations"
      : scene.full.update == Update::sequential ? "sequential updates, which carry a change through the image"
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
        iterations_of(levels, levels.order()[i], options) * sweeps_per_iteration(*pyramid->full);
  }
  return pyramid;
}

std::vector<Work> works_in_one_piece(const Scene& scene, const WindowOptions& options) {
  std::vector<Work> works;
  if (options.last_level != LastLevel::levels_only && why_left_out(Mode::pyramid, scene).empty()) {
    works.push_back(Work::dense);
    if (why_left_out(Mode::active, scene).empty()) {
      works.push_back(Work::active);
    }
  }
  return works;
}

bool is_finite(const VectorField& field) {
  const auto finite = [](float value) { return std::isfinite(value); };
  return std::ranges::all_of(field.x, finite) && std::ranges::all_of(field.y, finite);
}

/// What is kept of a field in one piece.
struct Piece {
  Work work;
  std::optional<std::uint64_t> hash; ///< state_hash(); none where the field is not finite
  std::int64_t changed;
  std::vector<VectorField> seen; ///< by window
};

class Examination {
public:
  Examination(Scene scene, const Backend& reference, const Backend& backend, const WindowOptions& options,
              Progress& progress)
      : scene_(std::move(scene)), reference_(reference), backend_(backend), options_(options),
        progress_(progress), levels_(scene_) {}

  [[nodiscard]] WindowedComparison examine() {
    comparison_.backend = backend_.name();
    std::unique_ptr<Session> session;
    try {
      comparison_.device = backend_.device(options_.session);
      session = backend_.open(options_.session);
    } catch (const DeviceError& error) {
      comparison_.reason = error.what();
      return comparison_;
    }
    const std::vector<Work> works = works_in_one_piece(scene_, options_);
    field_ = levels_.begin(levels_.order().front(), {});
    if (why_left_out(Mode::pyramid, scene_).empty()) {
      scene_.start = {}; // null, and not asked for any more
    }
    VectorField first = std::move(field_);
    for (const Work work : works) {
      pieces_.push_back(solve_in_one_piece(work));
      comparison_.pyramids.push_back({.work = work});
    }
    field_ = std::move(first);
    for (const int index : levels_.order()) {
      comparison_.levels.push_back(examine_level(*session, index));
    }
    if (comparison_.levels.back().level_by_level) {
      const std::int64_t changed = session->changed();
      session.reset();
      compare_pieces(changed);
    }
    comparison_.verdict = agrees() ? Verdict::agree : Verdict::disagree;
    return comparison_;
  }

private:
  [[nodiscard]] bool is_last(int index) const { return index == levels_.order().back(); }

  [[nodiscard]] std::vector<Window> windows_of(const Level& level) const {
    return is_whole(level.extent) ? std::vector<Window>{{.extent = level.extent}}
                                  : choose_windows(level, options_.plan);
  }
  [[nodiscard]] bool is_whole(Extent extent) const { return extent.sites() <= options_.whole; }

  [[nodiscard]] Piece solve_in_one_piece(Work work) {
    SessionOptions options = options_.session;
    options.work = work;
    const std::unique_ptr<Session> session = backend_.open(options);
    describe(fmt::format("in one piece, {}", work_names[static_cast<std::size_t>(work)]));
    const std::optional<Pyramid> pyramid = capped_pyramid(levels_, options_);
    session->load(*pyramid);
    session->solve([&](double site_updates) { progress_.advance(site_updates); });
    session->read(field_);
    Piece piece{.work = work, .hash = {}, .changed = session->changed(), .seen = {}};
    if (is_finite(field_)) {
      piece.hash = state_hash(field_);
    }
    for (const Window& window : windows_of(scene_.full)) {
      piece.seen.push_back(crop(field_, window));
    }
    return piece;
  }

  [[nodiscard]] WindowedLevel examine_level(Session& session, int index) {
    const Level& level = levels_.sample(index);
    WindowedLevel result{.level = index,
                         .extent = level.extent,
                         .iterations = iterations_of(levels_, index, options_),
                         .sweeps = 0,
                         .level_by_level = !is_last(index) || pieces_.empty() ||
                                           options_.last_level != LastLevel::in_one_piece_only,
                         .whole = is_whole(level.extent),
                         .windows = windows_of(level)};
    result.sweeps = result.iterations * sweeps_per_iteration(level);
    std::vector<Excerpt> excerpts;
    for (const Window& window : result.windows) {
      const Window outer = with_influence(window, result.sweeps, level.extent);
      excerpts.push_back({.inner = window, .outer = outer, .level = crop(level, outer)});
    }
    if (result.level_by_level) {
      session.load(level);
    }
    if (is_last(index)) {
      release_scene();
    }
    if (index != levels_.order().front()) {
      field_ = levels_.begin(index, field_);
    }
    for (Excerpt& excerpt : excerpts) {
      excerpt.begin = crop(field_, excerpt.outer);
    }
    if (result.level_by_level) {
      session.write(field_);
      step(session, result);
      session.read(field_);
    }
    for (std::size_t i = 0; i < excerpts.size(); ++i) {
      const std::int64_t changed = result.level_by_level ? session.changed() : pieces_.front().changed;
      compare_window(excerpts[i], i, changed, result);
    }
    return result;
  }

  /// The session has its own copy of the last level, or will not need it.
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

  /// Window `number` of the level, of which the backend says that the last sweep changed `changed` sites.
  void compare_window(const Excerpt& excerpt, std::size_t number, std::int64_t changed,
                      WindowedLevel& result) {
    const std::unique_ptr<Session> scalar = reference_.open({});
    scalar->load(excerpt.level);
    scalar->write(excerpt.begin);
    scalar->step(result.sweeps);
    VectorField expected;
    scalar->read(expected);
    const Window& inner = excerpt.inner;
    expected = crop(expected,
                    {.x = inner.x - excerpt.outer.x, .y = inner.y - excerpt.outer.y, .extent = inner.extent});
    const VectorField found = result.level_by_level ? crop(field_, inner) : pieces_.front().seen.at(number);
    const FieldDifference difference = compare(expected, found);
    result.count_differs = result.whole && scalar->changed() != changed;
    result.sites_compared += static_cast<std::int64_t>(inner.extent.sites());
    result.sites_differing += difference.sites;
    result.not_finite += difference.not_finite;
    result.largest_difference = std::max(result.largest_difference, difference.largest);
    if (difference.first && !result.first) {
      const std::size_t site = *difference.first;
      const auto width = static_cast<std::size_t>(inner.extent.width);
      result.first = {.x = inner.x + static_cast<int>(site % width),
                      .y = inner.y + static_cast<int>(site / width),
                      .expected = {expected.x[site], expected.y[site]},
                      .found = {found.x[site], found.y[site]}};
    }
    for (std::size_t i = 0; is_last(result.level) && i < pieces_.size(); ++i) {
      comparison_.pyramids[i].sites_differing += compare(expected, pieces_[i].seen.at(number)).sites;
    }
  }

  /// Against field_, the last level's.
  void compare_pieces(std::int64_t changed) {
    if (pieces_.empty()) {
      return;
    }
    const bool finite = is_finite(field_);
    const std::uint64_t hash = finite ? state_hash(field_) : 0;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      comparison_.pyramids[i].same_field = finite && pieces_[i].hash == hash;
      comparison_.pyramids[i].same_count = pieces_[i].changed == changed;
    }
  }

  [[nodiscard]] bool agrees() const {
    return std::ranges::all_of(comparison_.levels,
                               [](const WindowedLevel& level) {
                                 return level.sites_differing == 0 && !level.count_differs;
                               }) &&
           std::ranges::all_of(comparison_.pyramids, [](const WindowedPyramid& pyramid) {
             return pyramid.sites_differing == 0 && pyramid.same_field.value_or(true) &&
                    pyramid.same_count.value_or(true);
           });
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
  std::vector<Piece> pieces_;
  WindowedComparison comparison_;
};

} // namespace

WindowedComparison verify_windows(Scene scene, const Backend& reference, const Backend& backend,
                                  const WindowOptions& options, Progress& progress) {
  require_comparable(scene);
  if (!backend.supports(scene.full.update)) {
    return {.backend = std::string(backend.name()),
            .reason = fmt::format("cannot update as {} wants", method_name(scene))};
  }
  scene.picture = {};
  scene.labels = {};
  try {
    return Examination(std::move(scene), reference, backend, options, progress).examine();
  } catch (const TooLarge& error) {
    return {.backend = std::string(backend.name()), .reason = error.what()};
  }
}

double windowed_site_updates(const Scene& scene, const WindowOptions& options) {
  const auto solutions = static_cast<double>(1 + works_in_one_piece(scene, options).size());
  return solutions * sweeps_per_iteration(scene.full) * site_updates(scene, options.iteration_limit);
}

} // namespace hdmbench
