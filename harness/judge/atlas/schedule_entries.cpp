#include "harness/judge/atlas/entry.hpp"

#include <algorithm>
#include <random>

/// What the pyramid, the candidates and the order of updates do.
namespace hdmbench::atlas {

namespace {

constexpr int size = 128; // levels 0 ... 7

void start_at(Scene& scene, double knob) {
  scene.schedule.start_level = static_cast<int>(knob);
}

Scene rim(int width) {
  Scene scene = one_material(size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (x < width || y < width || x >= size - width || y >= size - width) {
        // The values of a field that is its own fixed point, bent so that no level is right by chance.
        const float u = static_cast<float>(x) / (size - 1);
        const float v = static_cast<float>(y) / (size - 1);
        hold(scene, x, y, 20.0F * (u - 1.0F) * (1.0F - 0.5F * v), 20.0F * v * u);
      }
    }
  }
  return scene;
}

std::vector<Series> on_both_alignments() {
  const auto center = [](Scene& scene, double) { scene.schedule.alignment = Alignment::center; };
  return {{.name = "icm", .method = "icm"},
          {.name = "icm, center", .method = "icm", .adjust = center},
          {.name = "closed-form", .method = "closed-form"},
          {.name = "closed-form, center", .method = "closed-form", .adjust = center},
          {.name = "cascade", .method = "cascade"},
          {.name = "cascade, center", .method = "cascade", .adjust = center}};
}

double moving_percent(const Problem&, const Outcome& outcome) {
  return 100.0 * outcome.share_moving;
}

/// Candidates 0 and +-1, +-0.3, +-0.1, ... down to the knob.
void step_down_to(Scene& scene, double knob) {
  std::vector<float> steps{0.0F};
  for (const double step : {1.0, 0.3, 0.1, 0.03, 0.01, 0.003}) {
    if (step >= knob) {
      steps.push_back(static_cast<float>(-step));
      steps.push_back(static_cast<float>(step));
    }
  }
  scene.full.steps = StepSet(steps);
}

void iterate_longer(Scene& scene, double) {
  scene.schedule.iterations *= 4;
}

/// The square scene, to begin on the full image with the answer plus independent noise of `amplitude` px: a
/// rough field from elsewhere (thesis 9.5).
Problem rough(float amplitude) {
  Problem problem = against_fixed_point(shipped("square", 64));
  VectorField& start = problem.scene.start.emplace(problem.truth.to_float());
  problem.scene.schedule.start_level = 0;
  std::minstd_rand random(1);
  for (auto* const component : {&start.x, &start.y}) {
    for (float& value : *component) {
      const auto uniform = static_cast<float>(random()) / static_cast<float>(std::minstd_rand::max());
      value += amplitude * (2.0F * uniform - 1.0F);
    }
  }
  return problem;
}

void relax(Scene& scene, double knob) {
  scene.schedule.relaxation = {.factor = knob};
}

void relax_in_two_colours(Scene& scene, double knob) {
  relax(scene, knob);
  scene.full.update = Update::coloured;
}

void iterate(Scene& scene, double knob) {
  scene.schedule.iterations = static_cast<int>(knob);
}

} // namespace

std::vector<Entry> schedule_entries() {
  return {
      {.name = "start-level-late",
       .title = "Pyramid started too late (thesis 5.8)",
       .mechanism = "A condition travels one site per iteration: on a fine first level the middle of the "
                    "image never hears of the border.",
       .knob = "start level (0 = full image only)",
       .survivor = "leave --start-level out",
       .warnings = {"out-of-reach", "still-moving", "stalled"},
       .knobs = {7, 6, 5, 4, 3, 2, 1, 0},
       .quick_knobs = {7, 3, 0},
       .series = usual_series(start_at),
       .problem = [](double) { return against_fixed_point(shipped("square", size)); },
       .picture = PictureWanted{.series = "icm",
                                .knob = 0.0,
                                .shows = "icm on the full image only: the error of dx, red where the "
                                         "pull of the left border did not arrive"}},
      {.name = "start-level-early",
       .title = "Pyramid started too early (thesis 5.6)",
       .mechanism = "A level of n sites forgets its start within about n iterations: what a very coarse one "
                    "got wrong is gone two levels later.",
       .knob = "start level (0 = full image only)",
       .survivor = "every method, from the coarsest level on",
       .knobs = {3, 4, 5, 6, 7},
       .quick_knobs = {4, 7},
       .series = usual_series(start_at),
       .problem = [](double) { return against_fixed_point(shipped("circular-radial", size)); }},
      {.name = "alignment",
       .title = "Coarse levels lose the conditions (--alignment center)",
       .mechanism = "A coarse site samples the middle of its block: a border thinner than half a block "
                    "exists on no coarse level.",
       .knob = "width of the known border [px]",
       .survivor = "--alignment corner (the default)",
       .warnings = {"lost-condition", "not-met", "stalled", "still-moving"},
       .knobs = {32, 16, 8, 4, 2, 1},
       .quick_knobs = {16, 4, 1},
       .series = on_both_alignments(),
       .problem = [](double knob) { return against_fixed_point(rim(static_cast<int>(knob))); },
       .picture = PictureWanted{.series = "icm, center",
                                .knob = 1.0,
                                .shows = "icm with centred alignment, border of one pixel: the error of dx"}},
      {.name = "step-quantum",
       .title = "The smallest candidate is too large",
       .mechanism = "ICM rests where no candidate pays, up to half the smallest one off the mean of the "
                    "neighbours; such offsets add up.",
       .knob = "smallest candidate [px]",
       .limit = 0.25,
       .survivor = "--steps fine; --method closed-form or cascade, which move by any amount",
       .warnings = {"stalled", "still-moving", "not-met"},
       .knobs = {0.003, 0.01, 0.03, 0.1, 0.3, 1.0},
       .quick_knobs = {0.01, 0.1, 1.0},
       .series = {{.name = "icm", .method = "icm", .adjust = step_down_to},
                  {.name = "coloured", .method = "coloured", .adjust = step_down_to},
                  {.name = "closed-form", .method = "closed-form"}},
       .problem = [](double) { return against_fixed_point(shipped("square", 96)); }},
      {.name = "growing-image",
       .title = "The same displacement over ever more pixels",
       .mechanism = "Each level of the pyramid rests to the same candidate, so the error of the whole stays "
                    "at about one of them.",
       .knob = "image side [px], targets of 50 px",
       .limit = 0.25,
       .survivor = "every method with 200 iterations a level; --steps fine gains a factor of 4",
       .warnings = {"stalled", "still-moving"},
       .knobs = {16, 32, 64, 128, 256},
       .quick_knobs = {16, 64},
       .series = usual_series(iterate_longer),
       .problem =
           [](double knob) {
             const int side = static_cast<int>(knob);
             return against_fixed_point(load_scene("square", {.size = Extent{side, side}}));
           }},
      {.name = "oscillation",
       .title = "Minimisers that move all at once overshoot",
       .mechanism = "Moving every site at once maps a wave that changes sign from column to column onto its "
                    "negative: at factor 1 it flips for ever.",
       .knob = "relaxation factor",
       .limit = 0.25,
       .survivor =
           "--method closed-form (factor 0.8), or two colours, in which no site sees another that moves",
       .warnings = {"oscillation", "divergence"},
       .knobs = {0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0, 1.02, 1.05, 1.1},
       .quick_knobs = {0.8, 1.02, 1.1},
       .series = {{.name = "all at once", .method = "closed-form", .adjust = relax},
                  {.name = "two colours", .method = "closed-form", .adjust = relax_in_two_colours}},
       .problem = [](double) { return rough(2.0F); },
       .picture = PictureWanted{.series = "all at once",
                                .knob = 1.02,
                                .shows = "all at once with factor 1.02: the error of dx"}},
      {.name = "two-cycles",
       .title = "Simultaneous ICM never comes to rest",
       .mechanism =
           "Two neighbours that each close the same gap both jump, find it turned around and jump back.",
       .knob = "roughness of the start field [px]",
       .measure = "sites that the last sweep moved [%]",
       .limit = 1.0,
       .survivor = "--method coloured or sequential: both rest",
       .warnings = {"oscillation"},
       .knobs = {0, 0.1, 0.3, 1, 2, 4},
       .quick_knobs = {0, 1, 4},
       .series = {{.name = "icm", .method = "icm", .iterations = 300},
                  {.name = "coloured", .method = "coloured", .iterations = 300},
                  {.name = "four-coloured", .method = "four-coloured", .iterations = 300},
                  {.name = "sequential", .method = "sequential", .iterations = 300}},
       .problem = [](double knob) { return rough(static_cast<float>(knob)); },
       .error = moving_percent},
      {.name = "no-zero-step",
       .title = "0 is not among the candidates",
       .mechanism = "A site that cannot stay must leave its minimum at every iteration: the field shivers by "
                    "its smallest step for ever.",
       .knob = "iterations per level",
       .measure = "sites that the last sweep moved [%]",
       .limit = 50.0,
       .survivor = "--steps default, whose first candidate is 0",
       .warnings = {"never-rests"},
       .knobs = {10, 30, 100, 300, 1000},
       .quick_knobs = {10, 300},
       .series = {{.name = "icm", .method = "icm", .adjust = iterate},
                  {.name = "icm-thesis-steps", .method = "icm-thesis-steps", .adjust = iterate}},
       .problem = [](double) { return Problem{.scene = shipped("square", 96)}; },
       .error = moving_percent},
      {.name = "cooling",
       .title = "Annealing that is cooled too fast",
       .mechanism = "A random step is one site's, so the field is a slow diffusion; cooled before it has "
                    "spread, disorder stays.",
       .knob = "iterations per level",
       .survivor = "30 iterations a level and more; icm is as good with as many, closed-form better",
       .warnings = {"stalled", "still-moving", "not-met"},
       .knobs = {1000, 300, 100, 30, 10, 3},
       .quick_knobs = {100, 30, 3},
       .series = {{.name = "annealing", .method = "annealing", .adjust = iterate},
                  {.name = "icm", .method = "icm", .adjust = iterate},
                  {.name = "closed-form", .method = "closed-form", .adjust = iterate}},
       .problem = [](double) { return against_fixed_point(shipped("square", 64)); }}};
}

} // namespace hdmbench::atlas
