#include "harness/judge/tradeoff.hpp"

#include "harness/scene/method.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

/// What differs from the thesis's GPU design, and what that shows.
struct Variant {
  const char* name;
  const char* note;
  void (*change)(Scene& scene);
};

constexpr std::array variants{
    Variant{"step set without 0", "Every site has to move at every iteration, so the field never rests.",
            [](Scene& scene) { scene.full.steps = StepSet::parse("thesis"); }},
    Variant{"step set as printed, with 0",
            "The thesis prints {-1, 0.1, 1, 0.1}: without -0.1 a component can creep up but not down.",
            [](Scene& scene) { scene.full.steps = StepSet::parse("0,-1,0.1,1"); }},
    Variant{"step set with 0.01", "Steps of 0.1 px no longer pay where the field is smooth.",
            [](Scene& scene) { scene.full.steps = StepSet::parse("fine"); }},
    Variant{"pixel-centred pyramid",
            "Coarse levels sampled at pixel centres lose conditions that are one pixel wide.",
            [](Scene& scene) { scene.schedule.alignment = Alignment::center; }},
    Variant{"ten times the iterations", "What more iterations alone would bring.",
            [](Scene& scene) { scene.schedule.iterations *= 10; }}};

/// Says so where a level of "until nothing moves" ended at its limit.
void note_limit(const Scene& scene, Judged& row) {
  for (const LevelResult& level : row.levels) {
    if (level.changed > 0) {
      row.note = fmt::format("ended by its limit of {} iterations on level {}, sites still moving: {}",
                             scene.schedule.iterations, level.level, level.changed);
    }
  }
}

/// Both designs of the thesis, and what differs from that for GPUs.
void add_thesis_methods(const Scene& scene, bool quick, Judge& judge) {
  // The thesis's GPU design: simultaneous, a fixed number of iterations.
  Scene icm = scene;
  icm.full.update = Update::simultaneous;
  icm.schedule.stop = Stop::fixed;
  judge.add(Setting{{.method = method_name(icm)}, icm});
  // Its CPU design: in place, until nothing moves. Two neighbours can pass a step to and fro for ever,
  // because no site's energy is part of a common one; so there is a limit.
  Scene in_place = scene;
  in_place.full.update = Update::sequential;
  in_place.schedule.stop = Stop::still;
  in_place.schedule.iterations = std::max(in_place.schedule.iterations, 1000);
  note_limit(in_place,
             judge.rows()[judge.add(Setting{{.method = method_name(in_place)}, in_place, Where::reference})]);
  for (const Variant& variant : quick ? std::span<const Variant>() : std::span(variants)) {
    Setting setting{
        {.method = method_name(icm), .variant = variant.name, .note = variant.note}, icm, Where::main_place};
    variant.change(setting.scene);
    judge.add(setting);
  }
}

} // namespace

std::vector<Judged> measure_accuracy(const Scene& scene, std::span<const Backend* const> backends,
                                     const JudgeOptions& options, Progress& progress) {
  require_known_pixels(scene, usual_energy());
  Judge judge(scene, backends, options, progress);
  for (const Rival& rival : rivals(scene, judge.truths(), true)) {
    if (rival.told.method != "fem-cg" && rival.told.method != "fem-amg") { // the same field as fem
      judge.add(rival);
    }
  }
  if (!scene.energy->is_of_cells()) {
    add_thesis_methods(scene, options.quick, judge);
  } else {
    for (const Method& method : scene.energy->methods) {
      Setting setting{{.method = std::string(method.name)}, scene};
      use_method(setting.scene, method);
      judge.add(setting);
    }
  }
  return std::move(judge.rows());
}

} // namespace hdmbench
