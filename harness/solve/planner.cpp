#include "harness/solve/planner.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// First and last sites coincide on all sampled images: conditions are on borders.
constexpr Alignment alignment = Alignment::corner;

/// What became of observed components when they were put on their targets.
struct Imposed {
  double squares = 0.0;             ///< of the gaps, pixels^2
  std::size_t count = 0;            ///< components
  float largest_unknown_gap = 0.0F; ///< pixels: where none of the four coarse sites around is observed
  bool has_springs = false;         ///< a confidence is below 1

  void add(const Imposed& other) {
    squares += other.squares;
    count += other.count;
    largest_unknown_gap = std::max(largest_unknown_gap, other.largest_unknown_gap);
    has_springs = has_springs || other.has_springs;
  }
  /// RMS over sites, pixels: two components a site.
  [[nodiscard]] double gap() const {
    return count == 0 ? 0.0 : std::sqrt(2.0 * squares / static_cast<double>(count));
  }
};

/// The pixels of an axis that a sampled site stands for: first ... last, of the outer two a part only.
struct Share {
  int first = 0;
  int last = 0;
  float of_first = 1.0F;
  float of_last = 1.0F;

  [[nodiscard]] float of(int pixel) const {
    return pixel == first ? of_first : pixel == last ? of_last : 1.0F;
  }
  [[nodiscard]] float length() const {
    return first == last ? of_first : of_first + of_last + static_cast<float>(last - first - 1);
  }
};

std::vector<Share> shares(int sites, int pixels) {
  const double cell = static_cast<double>(pixels - 1) / std::max(sites - 1, 1);
  std::vector<Share> result;
  for (int i = 0; i < sites; ++i) { // pixel p covers p - 0.5 ... p + 0.5
    const double from = std::max(i * cell - 0.5 * cell, -0.5);
    const double to = std::min((i + 1) * cell - 0.5 * cell, pixels - 0.5);
    Share share{.first = static_cast<int>(std::floor(from + 0.5)),
                .last = static_cast<int>(std::ceil(to - 0.5))};
    share.of_first = static_cast<float>(std::min(share.first + 0.5, to) - from);
    share.of_last = static_cast<float>(to - (share.last - 0.5));
    result.push_back(share);
  }
  return result;
}

/// Means of the moduli of the pixels around each site of a sampled image, by the share of each pixel in the
/// area that the site stands for. An interface has its place in them to a fraction of a pixel, and a layer
/// thinner than a cell its share.
struct BlockModuli {
  ScalarField mean;         ///< MPa: of layers that are strained side by side
  ScalarField inverse_mean; ///< 1/MPa, of 1 / m: of layers that are loaded one after the other
};

/// Of an image with these moduli, or of a sampled one with these means.
BlockModuli block_moduli(const ScalarField& modulus, const ScalarField& inverse_modulus, Extent sampled) {
  const Extent full = modulus.extent;
  const std::vector<Share> columns = shares(sampled.width, full.width);
  const std::vector<Share> rows = shares(sampled.height, full.height);
  BlockModuli result{.mean = ScalarField(sampled), .inverse_mean = ScalarField(sampled)};
  const auto width = static_cast<std::size_t>(full.width);
#pragma omp parallel if (full.sites() > sites_worth_threads)
  {
    std::vector<float> sums(width);
#pragma omp for schedule(static)
    for (int y = 0; y < sampled.height; ++y) {
      const Share& row = rows[static_cast<std::size_t>(y)];
      const auto average = [&](const std::vector<float>& from, float* to) {
        std::ranges::fill(sums, 0.0F);
        for (int v = row.first; v <= row.last; ++v) {
          const float* values = from.data() + full.index(0, v);
          const float share = row.of(v);
#pragma omp simd
          for (std::size_t u = 0; u < width; ++u) {
            sums[u] += share * values[u];
          }
        }
        for (const Share& column : columns) {
          float sum = 0.0F;
          for (int u = column.first; u <= column.last; ++u) {
            sum += column.of(u) * sums[static_cast<std::size_t>(u)];
          }
          *to++ = sum / (row.length() * column.length());
        }
      };
      average(modulus.values, result.mean.values.data() + sampled.index(0, y));
      average(inverse_modulus.values, result.inverse_mean.values.data() + sampled.index(0, y));
    }
  }
  return result;
}

/// The upper over the lower bound, where it is the largest: 1 where no site stands for more than one modulus.
double largest_mixture(const BlockModuli& blocks) {
  const std::vector<float>& upper = blocks.mean.values;
  const std::vector<float>& inverse_lower = blocks.inverse_mean.values;
  float largest = 1.0F;
#pragma omp simd reduction(max : largest)
  for (std::size_t i = 0; i < upper.size(); ++i) {
    largest = std::max(largest, upper[i] * inverse_lower[i]);
  }
  return static_cast<double>(largest);
}

/// Half and half of moduli a hundred times apart have such a mixture. With more, what a stiff fibre is
/// fastened to decides, and a sampled image cannot know that.
constexpr double most_mixed = 25.0;

/// Which modulus between the two bounds a site of a sampled image has.
enum class BlockMean {
  geometric,  ///< of the bounds: the nearest to the truth where tissues meet
  arithmetic, ///< the upper bound: it keeps thin fibres and loses thin cuts
};

/// Conditions of `full` at the sampled sites and its moduli by blocks.
Level sampled_image(const Level& full, const BlockModuli& blocks, BlockMean mean) {
  Level level = sample_level(full, blocks.mean.extent, alignment);
  level.modulus = blocks.mean;
  if (mean == BlockMean::geometric) {
    std::ranges::transform(blocks.mean.values, blocks.inverse_mean.values, level.modulus.values.begin(),
                           [](float upper, float inverse_lower) { return std::sqrt(upper / inverse_lower); });
  }
  set_inverse_modulus(level);
  return level;
}

/// What the cells of a sampled image cost, pixels: differences between ever finer ones fall like a geometric
/// series, and this is what is left of it. `moved`: the last difference; `moved_before`: the one before it, 0
/// where there was none.
double error_of_cells(double moved, double moved_before) {
  const double ratio = moved_before > 0.0 ? std::clamp(moved / moved_before, 0.5, 0.8) : 0.5;
  return moved * ratio / (1.0 - ratio);
}

/// Of an image that samples `full` at about every stride-th pixel of both axes, so that its cells stay
/// squares; first and last sites coincide. stride >= 1.
Extent sampled_extent(Extent full, int stride) {
  const auto sites = [&](int of) { return (of - 1 + stride / 2) / stride + 1; };
  return {sites(full.width), sites(full.height)};
}

/// A coarse displacement on the full image.
struct Interpolated {
  VectorField field; ///< pixels; components with a confidence above 0 are on their targets
  Imposed imposed;
};

/// `sampled`: the conditions that the coarse displacement knew.
Interpolated interpolate_to_image(const VectorField& coarse, const Level& sampled, const Level& full) {
  const Extent extent = full.extent;
  const Extent sites = coarse.extent;
  const Projection projection({coarse[0].data(), coarse[1].data()}, sites, extent, alignment);
  const std::vector<Interpolation> columns = interpolations(sites.width, extent.width, alignment);
  const std::vector<Interpolation> rows = interpolations(sites.height, extent.height, alignment);
  Interpolated result;
  result.field.extent = extent;
#pragma omp parallel for if (extent.sites() >                                                                \
                             sites_worth_threads) // to fill them with 0 takes a third of the time
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    result.field[axis].resize(extent.sites());
  }
  std::vector<Imposed> of_rows(rows.size()); // added up in their order, so that threads do not change the sum
#pragma omp parallel if (extent.sites() > sites_worth_threads)
  {
    Projection::CoarseRows coarse_rows;
#pragma omp for schedule(static)
    for (int y = 0; y < extent.height; ++y) {
      Imposed& own = of_rows[static_cast<std::size_t>(y)];
      const Interpolation& row = rows[static_cast<std::size_t>(y)];
      projection.row(y, coarse_rows, {result.field[0].data(), result.field[1].data()});
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        const auto is_known = [&](int column) {
          return sampled.confidence[axis][sites.index(column, row.first)] > 0.0F ||
                 sampled.confidence[axis][sites.index(column, row.second)] > 0.0F;
        };
        for (std::size_t x = 0; x < columns.size(); ++x) {
          const std::size_t site = extent.index(0, y) + x;
          const float confidence = full.confidence[axis][site];
          if (!(confidence > 0.0F)) {
            continue;
          }
          const float gap = std::abs(full.target[axis][site] - result.field[axis][site]);
          own.squares += static_cast<double>(gap) * static_cast<double>(gap);
          ++own.count;
          own.has_springs = own.has_springs || confidence < 1.0F;
          if (!is_known(columns[x].first) && !is_known(columns[x].second)) {
            own.largest_unknown_gap = std::max(own.largest_unknown_gap, gap);
          }
          result.field[axis][site] = full.target[axis][site];
        }
      }
    }
  }
  for (const Imposed& row : of_rows) {
    result.imposed.add(row);
  }
  return result;
}

/// Thin stiff layers take most: 37 at a contrast of 1000 to 1e-4 px.
constexpr int most_steps = 100;

/// A sampled image has more sites a side than this.
constexpr int fewest_sites = 16;

/// The interpolation of a sampled image is taken when this many times its expected error is within the
/// request: between two levels there is one difference, and it can be small by chance.
constexpr double caution_before_interpolation = 2.0;

/// Of that error: what it turns out to be on most scenes. What is asked for is compared with the whole of it.
constexpr double likely_share = 0.5;

/// The full image, then those with 4, 8, ... pixels a cell.
std::vector<Extent> sampled_extents(Extent full) {
  std::vector<Extent> extents{full};
  if (full.axes() == 3) {
    return extents; // volumes are not sampled
  }
  for (int stride = 4;; stride *= 2) {
    const Extent extent = sampled_extent(full, stride);
    if (std::min(extent.width, extent.height) <= fewest_sites) {
      return extents;
    }
    extents.push_back(extent);
  }
}

/// Indices spread evenly over a fine axis, both ends among them, each with that which stands for it on the
/// coarse one.
std::vector<std::pair<int, int>> looked_at(int coarse, int fine) {
  constexpr int most = 33; // so that to judge a sampled image of a large one takes no longer
  const int count = std::min(fine, most);
  std::vector<std::pair<int, int>> indices;
  for (int i = 0; i < count; ++i) {
    const int index = count > 1 ? static_cast<int>(static_cast<long long>(i) * (fine - 1) / (count - 1)) : 0;
    const double position = fine > 1 ? static_cast<double>(index) * (coarse - 1) / (fine - 1) : 0.0;
    indices.emplace_back(index,
                         sampled_index(static_cast<int>(std::lround(position)), coarse, fine, alignment));
  }
  return indices;
}

/// Whether a solution of a sampled image is a fair start for finer ones (thesis 9.4): the nearest sampled
/// site has the modulus of nine in ten sites, and observes half of the observed components.
bool is_fair_start(const Level& full, Extent extent) {
  std::size_t sites = 0;
  std::size_t same_modulus = 0;
  std::size_t observed = 0;
  std::size_t still_observed = 0;
  for (const auto& [row, to_row] : looked_at(extent.height, full.extent.height)) {
    for (const auto& [column, to_column] : looked_at(extent.width, full.extent.width)) {
      const std::size_t at = full.extent.index(column, row);
      const std::size_t there = full.extent.index(to_column, to_row);
      ++sites;
      same_modulus += full.modulus.values[at] == full.modulus.values[there] ? 1 : 0;
      for (std::size_t axis = 0; axis < full.extent.axes(); ++axis) {
        const std::vector<float>& confidence = full.confidence[axis];
        observed += confidence[at] > 0.0F ? 1 : 0;
        still_observed += confidence[at] > 0.0F && confidence[there] > 0.0F ? 1 : 0;
      }
    }
  }
  return 10 * same_modulus >= 9 * sites && 2 * still_observed >= observed;
}

void require_positive(const std::optional<double>& value, const char* what) {
  if (value && !(*value > 0.0 && std::isfinite(*value))) {
    throw InputError(fmt::format("{} is {}, it must be above 0", what, *value));
  }
}

bool is_held(const Level& level) {
  try {
    require_held(level);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// Of two fields of one extent: the root of the mean square of the distance, pixels.
double rms_difference(const VectorField& a, const VectorField& b) {
  double squares = 0.0;
  for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
    for (std::size_t i = 0; i < a[axis].size(); ++i) {
      const auto difference = static_cast<double>(a[axis][i]) - static_cast<double>(b[axis][i]);
      squares += difference * difference;
    }
  }
  return std::sqrt(squares / static_cast<double>(a.extent.sites()));
}

class Planner {
public:
  Planner(const Scene& scene, const Request& request, ElasticSession& session, Progress& progress)
      : scene_(scene), request_(request), session_(session), progress_(progress),
        extents_(sampled_extents(scene.extent())) {}

  Plan run() {
    if (!solve_sampled()) {
      solve_image();
    }
    conclude(plan_, scene_, request_, clock_.seconds(), mistrust_);
    return std::move(plan_);
  }

private:
  void note(Extent extent, std::string action, std::string reason, double moved, double error) {
    plan_.steps.push_back({.extent = extent,
                           .action = std::move(action),
                           .reason = std::move(reason),
                           .moved = moved,
                           .expected_error = error,
                           .seconds = clock_.seconds()});
    progress_.describe(fmt::format("{} {}: {}", scene_.name, extent.text(), plan_.steps.back().action));
  }

  void add_work(const ElasticSolver& solver) {
    Solution& solution = plan_.solution;
    std::vector<LevelResult> levels = solver.work(); // the coarsest first, as other methods have them
    std::ranges::reverse(levels);
    solution.levels.insert(solution.levels.end(), levels.begin(), levels.end());
    solution.timings.add(solver.timings());
  }

  /// A coarse image of the scene.
  struct Sampled {
    BlockModuli blocks{};
    Level level{};
    VectorField field{}; ///< its displacement, pixels
  };

  /// Solves images that sample every fourth, eighth, ... pixel, from the coarsest that shows the scene, until
  /// their differences say that the next finer one would not move the field by more than what is asked for.
  /// False where none is good enough.
  bool solve_sampled() {
    std::size_t fair = 0; // the coarsest that is a fair start, all finer ones being fair too
    while (fair + 1 < extents_.size() && is_fair_start(scene_.full, extents_[fair + 1])) {
      ++fair;
    }
    if (fair == 0) {
      return false;
    }
    // One coarser than that says how fast differences fall, and blocks of moduli show more than sites.
    const std::size_t start = std::min(fair + 1, extents_.size() - 1);
    const BlockModuli finest = block_moduli(scene_.full.modulus, scene_.full.inverse_modulus, extents_[1]);
    if (largest_mixture(finest) > most_mixed) {
      return false;
    }
    std::optional<Sampled> before;
    double moved_before = 0.0;
    for (std::size_t at = start; at > 0; --at) {
      const Extent extent = extents_[at];
      Sampled now{.blocks = at == 1 ? finest : block_moduli(finest.mean, finest.inverse_mean, extent)};
      now.level = sampled_image(scene_.full, now.blocks, BlockMean::geometric);
      if (has_springs(now.level)) {
        return false; // a sampled spring would stand for as many as there are pixels a cell
      }
      if (!is_held(now.level)) {
        continue;
      }
      const double begin = clock_.seconds();
      now.field = solve(now.level);
      const double seconds = clock_.seconds() - begin;
      const double moved =
          before ? rms_difference(prolongate(before->field, extent, alignment), now.field) : 0.0;
      const double error = moved > 0.0 ? error_of_cells(moved, moved_before) : unknown;
      note(extent, "sampled image", before ? "the next finer one" : "one coarser than what shows the scene",
           moved, error);
      // Four times the sites, the work of a site being the same.
      const bool no_time = !has_time_for(4.0 * seconds);
      double in_all = unknown;
      if (before && (is_accurate(error) || no_time)) {
        in_all = with_hidden(error, *before); // cheaper there, and hardly ever less
        if (!is_accurate(in_all) && !no_time) {
          in_all = with_hidden(error, now);
        }
      }
      if ((is_accurate(in_all) || no_time) && take_interpolation(now, in_all, no_time)) {
        return true;
      }
      // The finest of them would halve the error at best, once for each level.
      const double best = error * std::ldexp(1.0, -static_cast<int>(at - 1));
      if (!request_.seconds && error < unknown && !is_accurate(best)) {
        return false;
      }
      before = std::move(now);
      moved_before = moved;
    }
    return false;
  }

  /// An error with what the field owes to layers that are thinner than the cells of a sampled image.
  double with_hidden(double error, const Sampled& sampled) {
    const double hidden = rms_difference(
        solve(sampled_image(scene_.full, sampled.blocks, BlockMean::arithmetic)), sampled.field);
    const double in_all = std::hypot(error, hidden);
    note(sampled.level.extent, "upper moduli", "how much depends on what is thinner than a cell", hidden,
         in_all);
    return in_all;
  }

  /// Full multigrid alone can be far off on a coarse image, too, so steps of conjugate gradients follow,
  /// until what is left matters little to the request.
  VectorField solve(const Level& sampled) {
    ElasticSolver solver(sampled, scene_.poisson, session_);
    const double enough = request_.accuracy ? share_of_steps * *request_.accuracy : unknown;
    solve_within(enough, most_steps, contrast_of(sampled.modulus), solver);
    add_work(solver);
    return solver.displacement();
  }

  [[nodiscard]] bool has_time_for(double seconds) const {
    return !request_.seconds || clock_.seconds() + seconds <= *request_.seconds;
  }

  [[nodiscard]] bool is_accurate(double error) const {
    return request_.accuracy && caution_before_interpolation * error <= *request_.accuracy;
  }

  /// False where the image has conditions that the sampled one does not know and that matter.
  bool take_interpolation(const Sampled& sampled, double error, bool no_time) {
    require_held(scene_.full);
    Interpolated interpolated = interpolate_to_image(sampled.field, sampled.level, scene_.full);
    if (interpolated.imposed.has_springs) {
      return false;
    }
    // Beside an outline the cells' size is in both; a condition between the sites is news, but only around
    // it.
    const double in_all = std::hypot(error, 0.5 * interpolated.imposed.gap(),
                                     0.25 * static_cast<double>(interpolated.imposed.largest_unknown_gap));
    if (!no_time && !is_accurate(in_all)) {
      return false;
    }
    plan_.solution.displacement = std::move(interpolated.field);
    if (in_all < unknown) {
      plan_.solution.estimated_error = likely_share * in_all;
    }
    note(scene_.extent(), "interpolation",
         no_time ? "the time is up" : "finer images are expected to move the field by less than is asked for",
         0.0, in_all);
    return true;
  }

  /// Full multigrid, then conjugate gradients until the steps say that it is enough.
  void solve_image() {
    ElasticSolver solver(scene_.full, scene_.poisson, session_);
    note(scene_.extent(), "levels", "moments of the moduli and cut cells on all levels", 0.0, unknown);
    const double set_up = clock_.seconds();
    solver.full_multigrid();
    note(scene_.extent(), "multigrid", "from the coarsest level up, a W cycle on each", 0.0, unknown);
    RemainingError error(contrast_of(scene_.full.modulus));
    double last = clock_.seconds() - set_up; // a step costs no more than full multigrid
    bool at_rest = false;
    for (int i = 0;; ++i) {
      const double before = clock_.seconds();
      const bool accurate = request_.accuracy && error.is_within(*request_.accuracy);
      if (accurate || !has_time_for(last)) {
        break;
      }
      if (i == most_steps) {
        mistrust_ = fmt::format("{} steps of conjugate gradients did not come to an end", most_steps);
        break;
      }
      const ElasticSolver::Step step = solver.conjugate_gradients();
      if (step.ended) {
        at_rest = step.at_rest;
        mistrust_ = at_rest ? "" : "moduli or springs differ so much that float32 has no further step";
        note(scene_.extent(), "end", at_rest ? "what is left is rounding" : mistrust_, 0.0, unknown);
        break;
      }
      error.add(step.change);
      last = clock_.seconds() - before;
      note(scene_.extent(), "gradients",
           i == 0              ? std::string("says how far full multigrid was from the end")
           : request_.accuracy ? fmt::format("{:.3g} px are asked for", *request_.accuracy)
                               : std::string("there is time left"),
           step.change, error.estimate());
    }
    solver.settle(scene_.full, free_motions(scene_.full));
    plan_.solution.displacement = solver.displacement();
    add_work(solver);
    const double largest = largest_component(plan_.solution.displacement);
    const double rounding = solver.rounding(largest, contrast_of(scene_.full.modulus));
    if (!std::isfinite(rounding)) {
      mistrust_ = "moduli differ more than float32 can tell";
    } else if ((error.is_known() && mistrust_.empty()) || at_rest) {
      // No field was seen closer to the truth than this, whatever the moduli.
      plan_.solution.estimated_error = std::hypot(error.is_known() ? error.estimate() : 0.0, rounding);
    }
    // At 0.499 one request in ten was broken, on the random volumes of test/promise_test.cpp.
    if (scene_.extent().axes() == 3 && scene_.poisson > 0.49 && mistrust_.empty()) {
      mistrust_ = "of a volume with a Poisson's ratio above 0.49 no estimate is believed";
    }
  }

  /// Of the accuracy asked for: what steps may leave on a sampled image.
  static constexpr double share_of_steps = 0.5;
  static constexpr double unknown = std::numeric_limits<double>::infinity();

  Clock clock_;
  const Scene& scene_;
  const Request& request_;
  ElasticSession& session_;
  Progress& progress_;
  std::vector<Extent> extents_;
  Plan plan_;
  std::string mistrust_; ///< why the estimate cannot be believed; empty: it can
};

} // namespace

void conclude(Plan& plan, const Scene& scene, const Request& request, double seconds,
              std::string_view mistrust) {
  std::optional<double>& error = plan.solution.estimated_error;
  const std::string absurd = why_absurd(scene, plan.solution.displacement);
  if (!absurd.empty()) {
    error.reset();
    mistrust = absurd;
  }
  const bool accurate = !request.accuracy || (error && mistrust.empty() && *error <= *request.accuracy);
  const bool in_time = !request.seconds || seconds <= *request.seconds;
  plan.met = accurate && in_time && absurd.empty();
  plan.outcome = fmt::format(
      "{}{}{} in {:.3g} ms: {}{}",
      request.accuracy ? fmt::format("asked {:.3g} px from finite elements, ", *request.accuracy) : "",
      request.seconds ? fmt::format("asked {:.3g} ms, ", 1e3 * *request.seconds) : "",
      error ? fmt::format("estimated {:.2g} px{}", *error, request.accuracy ? "" : " from finite elements")
            : "no estimate",
      1e3 * seconds, plan.met ? "met" : "NOT met", mistrust.empty() ? "" : fmt::format(" ({})", mistrust));
}

double fine_sweep_equivalents(const Plan& plan) {
  return total_site_updates(plan.solution.levels) /
         static_cast<double>(plan.solution.displacement.extent.sites());
}

Plan solve_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                     const SessionOptions& options, Progress& progress) {
  require_positive(request.accuracy, "the accuracy asked for (px)");
  require_positive(request.seconds, "the time asked for (s)");
  if (scene.energy->near != ReferenceSolution::finite_elements) {
    throw InputError(
        "an accuracy is a distance from finite elements, which the elastic energy alone comes near");
  }
  if (const std::optional<Scene> scaled = with_safe_moduli(scene)) {
    return solve_as_needed(*scaled, request, backend, options, progress);
  }
  if (const std::string why = why_not_solved(scene, backend); !why.empty()) {
    throw InputError(fmt::format("{} {}; use --backend scalar", backend.name(), why));
  }
  const auto session = backend.open_elastic(options);
  return Planner(scene, request, *session, progress).run();
}

} // namespace hdmbench
