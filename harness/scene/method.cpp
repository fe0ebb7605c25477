#include "harness/scene/method.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <vector>

namespace hdmbench {

namespace {

/// Steps as the scene has them, one after the other or all at once.
template <Update update>
void in_order(Schedule& /*schedule*/, Level& level) {
  level.update = update;
}

void icm(Schedule& /*schedule*/, Level& /*level*/) {}

void icm_fine(Schedule& /*schedule*/, Level& level) {
  level.steps = StepSet::parse("fine");
}

void icm_thesis_steps(Schedule& /*schedule*/, Level& level) {
  level.steps = StepSet::parse("thesis");
}

/// A simultaneous minimiser overshoots where neighbours move the same way: x waves that change sign from
/// column to column (y: from row to row) neither grow nor shrink at factor 1, and every factor below 1 damps
/// them.
void closed_form(Schedule& schedule, Level& /*level*/) {
  schedule.rule = Rule::closed_form;
  schedule.relaxation = {.factor = 0.9};
}

/// The numbers are those with the smallest error at about three sweeps over the full resolution, at 300 x
/// 300. More effort does not help on every scene: the fixed point of 128 x 128 sites is 0.08 to 0.98 px off,
/// by the scene, and what remains of that are waves as long as the image, which sweeps on the finest level
/// hardly move.
void cascade(Schedule& schedule, Level& level) {
  schedule.rule = Rule::closed_form;
  level.update = Update::coloured;
  schedule.growth = 1.8;
  schedule.most_per_side = 1.0;
  schedule.skip_nearer = 1.3;
  schedule.mean_modulus = true;
  schedule.relaxation = {.reach = 8.0, .largest = 1.97, .settling = 2};
}

/// To propose no step is to propose nothing, so 0 is left out.
void annealing(Schedule& schedule, Level& level) {
  schedule.rule = Rule::annealing;
  level.update = Update::coloured;
  std::vector<float> moves;
  std::ranges::copy_if(level.steps.values(), std::back_inserter(moves),
                       [](float step) { return step != 0.0F; });
  if (moves.empty()) {
    throw InputError("annealing needs a candidate other than 0");
  }
  level.steps = StepSet(moves);
}

constexpr const char* per_level = "iterations per level";

const std::array all{
    Method{"icm", "the thesis: every site takes its best candidate, all at once", per_level, 0,
           takes_steps | takes_update, icm},
    Method{"icm-6", "the same with candidates down to 0.01 px", per_level, 0, no_options, icm_fine},
    Method{"icm-thesis-steps", "the same with the printed candidates: 0 is none of them", per_level, 0,
           no_options, icm_thesis_steps},
    Method{"sequential", "candidates in raster order and in place (thesis, CPU)", per_level, 0, takes_steps,
           in_order<Update::sequential>},
    Method{"coloured", "candidates in place, two sets of sites in turn", per_level, 0, takes_steps,
           in_order<Update::coloured>},
    Method{"four-coloured", "candidates in place, four sets in turn (thesis 9.6.2)", per_level, 0,
           takes_steps, in_order<Update::four_coloured>},
    Method{"closed-form", "every site moves 0.9 of the way to its exact minimum, all at once", per_level, 0,
           takes_relaxation, closed_form},
    Method{"cascade", "exact minima in two colours, accelerated, more iterations on coarser levels",
           "iterations on the full resolution", 1, no_options, cascade},
    Method{"annealing", "candidates at random, taken by energy and temperature (thesis Alg. 1)", per_level,
           200, takes_steps | takes_temperatures | takes_seed, annealing}};

/// Levels, their order and their sweeps are the method's own.
void elastic(Schedule& /*schedule*/, Level& /*level*/) {}

const std::array all_elastic{
    Method{elastic_full_multigrid, "from the coarsest level up, a W cycle on each, then cycles",
           "cycles on the full resolution", 2, no_options, elastic, EnergyModel::elastic},
    Method{elastic_conjugate_gradients, "after full multigrid: its cycle as preconditioner", "steps", 8,
           no_options, elastic, EnergyModel::elastic},
    Method{elastic_sweeps, "damped Jacobi sweeps over the full resolution, no levels", "sweeps", 50,
           no_options, elastic, EnergyModel::elastic}};

/// What results call the options, in the order of their bits.
constexpr std::array<std::string_view, 5> names_of_options{"steps", "update", "relaxation", "temperatures",
                                                           "seed"};

unsigned given(const MethodOptions& options) {
  return (options.steps ? takes_steps : 0U) | (options.update ? takes_update : 0U) |
         (options.relaxation ? takes_relaxation : 0U) | (options.cooling ? takes_temperatures : 0U) |
         (options.seed ? takes_seed : 0U);
}

/// Throws where `method` does not take what is said.
void require_taken(const Method& method, const MethodOptions& options) {
  const unsigned refused = given(options) & ~method.options;
  if (refused == 0) {
    return;
  }
  std::string takers;
  for (const Method& other : all) {
    if ((other.options & refused) == refused) {
      takers += fmt::format("{}{}", takers.empty() ? "" : ", ", other.name);
    }
  }
  throw InputError(fmt::format("the method {} does not take {}{}{}", method.name, option_names(refused),
                               takers.empty() ? "" : "; those that do are ", takers));
}

void require_in_range(const MethodOptions& options) {
  if (options.iterations && (*options.iterations < 0 || *options.iterations > largest_effort)) {
    throw InputError(
        fmt::format("{} iterations are not possible, give 0 ... {}", *options.iterations, largest_effort));
  }
  if (options.relaxation && !(*options.relaxation > 0.0 && *options.relaxation < 2.0)) {
    throw InputError(
        fmt::format("the relaxation is {}, it must be above 0 and below 2", *options.relaxation));
  }
  if (options.cooling) {
    const auto [highest, lowest] = *options.cooling;
    // 1 / T is a 32-bit float, and so are the energies it is compared with.
    if (!(lowest >= 1e-30 && highest >= lowest && highest <= 1e30)) {
      throw InputError(
          fmt::format("the temperatures are {} and {}, the first must be the higher one, the second "
                      "at least 1e-30",
                      highest, lowest));
    }
  }
  if (options.seed && (*options.seed < 0 || *options.seed > 4092)) {
    throw InputError(fmt::format("the seed is {}, it must be 0 ... 4092", *options.seed));
  }
}

} // namespace

std::span<const Method> methods() {
  return all;
}

std::span<const Method> elastic_methods() {
  return all_elastic;
}

const Method& usual_method(EnergyModel energy) {
  return energy == EnergyModel::elastic ? all_elastic.front() : all.front();
}

std::string option_names(unsigned options) {
  std::string names;
  for (std::size_t bit = 0; bit < names_of_options.size(); ++bit) {
    if ((options >> bit & 1U) != 0) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", names_of_options[bit]);
    }
  }
  return names;
}

const Method& find_method(std::string_view name, std::optional<EnergyModel> energy) {
  std::string names;
  for (const std::span<const Method> known : {methods(), elastic_methods()}) {
    for (const Method& method : known) {
      if (energy && method.energy != *energy) {
        continue;
      }
      if (method.name == name) {
        return method;
      }
      names += fmt::format("{}{}", names.empty() ? "" : ", ", method.name);
    }
  }
  throw InputError(fmt::format("there is no method \"{}\"{}; the methods are {}", name,
                               energy == EnergyModel::elastic ? " for the elastic energy"
                               : energy                       ? " for the energy hdm"
                                                              : "",
                               names));
}

void use_method(Scene& scene, const Method& method, std::optional<int> iterations) {
  const Schedule own = method.energy == scene.energy ? scene.schedule : Schedule{};
  Schedule schedule{.method = std::string(method.name),
                    .iterations = method.usual_effort > 0 ? method.usual_effort : own.iterations,
                    .stop = own.stop,
                    .epsilon = own.epsilon,
                    .start_level = own.start_level,
                    .alignment = own.alignment};
  scene.full.update = Update::simultaneous;
  method.configure(schedule, scene.full);
  scene.schedule = schedule;
  scene.energy = method.energy;
  set_options(scene, {.iterations = iterations});
}

void set_options(Scene& scene, const MethodOptions& options) {
  const Method& method = find_method(scene.schedule.method, scene.energy);
  require_taken(method, options);
  require_in_range(options);
  Schedule schedule = scene.schedule;
  Level level = without_fields(scene.full);
  level.steps = options.steps.value_or(level.steps);
  level.update = options.update.value_or(level.update);
  level.seed = options.seed.value_or(level.seed);
  schedule.iterations = options.iterations.value_or(schedule.iterations);
  schedule.relaxation.factor = options.relaxation.value_or(schedule.relaxation.factor);
  schedule.cooling = options.cooling.value_or(schedule.cooling);
  if (options.steps && schedule.rule == Rule::annealing) {
    method.configure(schedule, level);
  }
  scene.schedule = schedule;
  scene.full.steps = level.steps;
  scene.full.update = level.update;
  scene.full.seed = level.seed;
}

} // namespace hdmbench
