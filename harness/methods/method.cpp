#include "harness/methods/method.hpp"

#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

/// Steps as the scene has them, one after the other or all at once.
template <Update update>
void in_order(Schedule& schedule, StepSet& /*steps*/) {
  schedule.update = update;
}

void icm(Schedule& /*schedule*/, StepSet& /*steps*/) {}

void icm_fine(Schedule& /*schedule*/, StepSet& steps) {
  steps = StepSet::parse("fine");
}

void icm_thesis_steps(Schedule& /*schedule*/, StepSet& steps) {
  steps = StepSet::parse("thesis");
}

/// A simultaneous minimiser overshoots where neighbours move the same way: x waves that change sign from
/// column to column (y: from row to row) neither grow nor shrink at factor 1, and every factor below 1 damps
/// them.
void closed_form(Schedule& schedule, StepSet& /*steps*/) {
  schedule.rule = Rule::closed_form;
  schedule.relaxation = {.factor = 0.8};
}

void cascade(Schedule& schedule, StepSet& /*steps*/) {
  schedule.rule = Rule::closed_form;
  schedule.update = Update::coloured;
  schedule.growth = 1.6;
  schedule.most_per_side = 1.0;
  schedule.skip_nearer = 1.3;
  schedule.mean_modulus = true;
  schedule.relaxation = {.reach = 8.0};
}

void annealing(Schedule& schedule, StepSet& steps) {
  schedule.rule = Rule::annealing;
  schedule.update = Update::coloured;
  steps = StepSet::parse("-1,-0.1,1,0.1");
}

template <Cycle cycle>
void corrected(Schedule& schedule, StepSet& /*steps*/) {
  schedule.rule = Rule::correction;
  schedule.update = Update::coloured;
  schedule.cycle = cycle;
  schedule.skip_nearer = 1.3;
  schedule.mean_modulus = true;
}

constexpr const char* per_level = "iterations per level";

const std::array all{
    Method{"icm", "the thesis: every site takes its best candidate, all at once", per_level, 0, icm},
    Method{"icm-6", "the same with candidates down to 0.01 px", per_level, 0, icm_fine},
    Method{"icm-thesis-steps", "the same with the printed candidates: 0 is none of them", per_level, 0,
           icm_thesis_steps},
    Method{"sequential", "candidates in raster order and in place (thesis, CPU)", per_level, 0,
           in_order<Update::sequential>},
    Method{"coloured", "candidates in place, two sets of sites in turn", per_level, 0,
           in_order<Update::coloured>},
    Method{"four-coloured", "candidates in place, four sets in turn (thesis 9.6.2)", per_level, 0,
           in_order<Update::four_coloured>},
    Method{"closed-form", "every site moves to 0.8 of the way to its exact minimum, all at once", per_level,
           0, closed_form},
    Method{"cascade", "exact minima in two colours, Chebyshev-accelerated, more iterations on coarser levels",
           "iterations on the full resolution", 1, cascade},
    Method{"annealing", "candidates at random, taken by energy and temperature (thesis Alg. 1)", per_level,
           200, annealing},
    Method{"multigrid", "levels correct each other until the fixed point is met", "cycles", 3,
           corrected<Cycle::multigrid>},
    Method{"krylov", "a Krylov method with a multigrid cycle as its preconditioner", "Krylov steps", 5,
           corrected<Cycle::krylov>}};

} // namespace

std::span<const Method> methods() {
  return all;
}

const Method& find_method(std::string_view name) {
  const auto found = std::ranges::find(all, name, &Method::name);
  if (found == all.end()) {
    std::string names;
    for (const Method& method : all) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", method.name);
    }
    throw InputError(fmt::format("there is no method \"{}\"; the methods are {}", name, names));
  }
  return *found;
}

void use_method(Scene& scene, const Method& method, std::optional<int> iterations) {
  const Schedule& own = scene.schedule;
  Schedule schedule{.method = std::string(method.name),
                    .iterations = method.usual_effort > 0 ? method.usual_effort : own.iterations,
                    .stop = own.stop,
                    .epsilon = own.epsilon,
                    .start_level = own.start_level,
                    .alignment = own.alignment,
                    .seed = own.seed};
  schedule.iterations = iterations.value_or(schedule.iterations);
  method.configure(schedule, scene.full.steps);
  scene.schedule = schedule;
  scene.full.update = schedule.update;
  scene.full.rule = schedule.rule;
  scene.full.seed = schedule.seed;
}

} // namespace hdmbench
