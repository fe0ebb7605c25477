#include "harness/scene/method.hpp"

#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <stdexcept>
#include <vector>

namespace hdmbench {

namespace {

/// Steps as the scene has them, one after the other or all at once.
template <Update update>
void in_order(Schedule& /*schedule*/, Level& level) {
  level.update = update;
}

/// As the scene has it; or levels, their order and their sweeps are the method's own.
void unchanged(Schedule& /*schedule*/, Level& /*level*/) {}

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

constexpr std::array all{
    Method{"icm", "the thesis: every site takes its best candidate, all at once", per_level, 0,
           "steps, update", unchanged},
    Method{"icm-6", "the same with candidates down to 0.01 px", per_level, 0, "",
           [](Schedule& /*schedule*/, Level& level) { level.steps = StepSet::parse("fine"); }},
    Method{"icm-thesis-steps", "the same with the printed candidates: 0 is none of them", per_level, 0, "",
           [](Schedule& /*schedule*/, Level& level) { level.steps = StepSet::parse("thesis"); }},
    Method{"sequential", "candidates in raster order and in place (thesis, CPU)", per_level, 0, "steps",
           in_order<Update::sequential>},
    Method{"coloured", "candidates in place, two sets of sites in turn", per_level, 0, "steps",
           in_order<Update::coloured>},
    Method{"four-coloured", "candidates in place, four sets in turn (thesis 9.6.2)", per_level, 0, "steps",
           in_order<Update::four_coloured>},
    Method{"closed-form", "every site moves 0.9 of the way to its exact minimum, all at once", per_level, 0,
           "relaxation", closed_form},
    Method{"cascade", "exact minima in two colours, accelerated, more iterations on coarser levels",
           "iterations on the full resolution", 1, "", cascade},
    Method{"annealing", "candidates at random, taken by energy and temperature (thesis Alg. 1)", per_level,
           200, "steps, temperatures, seed", annealing}};

constexpr std::array all_elastic{
    Method{elastic_full_multigrid, "from the coarsest level up, a W cycle on each, then cycles",
           "cycles on the full resolution", 2, "", unchanged,
           100.0}, // layers two pixels thin: from 10,000 on cycles leave pixels while they move nothing
    Method{elastic_conjugate_gradients, "after full multigrid: its cycle as preconditioner", "steps", 8, "",
           unchanged},
    Method{elastic_sweeps, "damped Jacobi sweeps over the full resolution, no levels", "sweeps", 50, "",
           unchanged}};

constexpr RegisteredEnergy hdm{.name = "hdm",
                               .summary = "the thesis",
                               .methods = all,
                               .of_sites = &thesis_energy,
                               .takes_volumes = true};
constexpr RegisteredEnergy plane_stress{.name = "elastic",
                                        .summary = "plane stress",
                                        .methods = all_elastic,
                                        .near = ReferenceSolution::finite_elements,
                                        .takes_volumes = true,
                                        .takes_boxes = true,
                                        .takes_forces = true,
                                        .takes_laws = true,
                                        .bytes_per_pixel = 90,
                                        .bytes_per_voxel = 130};

std::vector<const RegisteredEnergy*>& registry() {
  static std::vector<const RegisteredEnergy*> registered{&hdm, &plane_stress};
  return registered;
}

} // namespace

std::span<const Method> methods() {
  return all;
}

bool RegisteredEnergy::has(const Method& method) const {
  return &method >= methods.data() && &method < methods.data() + methods.size();
}

std::span<const RegisteredEnergy* const> registered_energies() {
  return registry();
}

std::vector<std::string_view> energy_names() {
  std::vector<std::string_view> names;
  std::ranges::transform(registered_energies(), std::back_inserter(names), &RegisteredEnergy::name);
  return names;
}

const RegisteredEnergy& usual_energy() {
  return hdm;
}

bool register_energy(const RegisteredEnergy& energy) {
  if (std::ranges::find(registered_energies(), energy.name, &RegisteredEnergy::name) !=
      registered_energies().end()) {
    throw std::logic_error(fmt::format("two energies are called {}", energy.name));
  }
  registry().push_back(&energy);
  return true;
}

const RegisteredEnergy& find_energy(std::string_view name) {
  const auto found = std::ranges::find(registered_energies(), name, &RegisteredEnergy::name);
  if (found == registered_energies().end()) {
    throw InputError(
        fmt::format("there is no energy \"{}\"; the energies are {}", name, fmt::join(energy_names(), ", ")));
  }
  return **found;
}

const RegisteredEnergy& energy_near(ReferenceSolution solution) {
  return **std::ranges::find(registered_energies(), solution, &RegisteredEnergy::near);
}

const RegisteredEnergy& energy_of(const Method& method) {
  return **std::ranges::find_if(registered_energies(),
                                [&](const auto* energy) { return energy->has(method); });
}

const Method& find_method(std::string_view name, const RegisteredEnergy* energy) {
  std::vector<std::string_view> names;
  for (const RegisteredEnergy* const known : registered_energies()) {
    for (const Method& method : known->methods) {
      const bool is_meant = energy == nullptr ? &energy_of(method) == known : energy == known;
      if (is_meant && method.name == name) {
        return method;
      }
      if (is_meant) {
        names.push_back(method.name);
      }
    }
  }
  throw InputError(fmt::format("there is no method \"{}\"{}; the methods are {}", name,
                               energy == nullptr ? "" : fmt::format(" for the {} energy", energy->name),
                               fmt::join(names, ", ")));
}

const Method& usual_method(const Scene& scene) {
  const std::span<const Method> methods = scene.energy->methods;
  const ScalarField& modulus = scene.full.modulus;
  const auto takes = [](const Method& method, double contrast) { return !(contrast > method.most_contrast); };
  const double in_all = contrast_of(modulus);
  if (takes(methods.front(), in_all)) {
    return methods.front(); // no two neighbours differ more
  }
  const double contrast = largest_neighbour_contrast(modulus).ratio;
  return *std::ranges::find_if(methods, [&](const Method& method) { return takes(method, contrast); });
}

void set_energy_of_sites(Scene& scene) {
  const RegisteredEnergy& energy = *scene.energy;
  scene.full.energy = energy.is_of_cells() ? &thesis_energy : energy.of_sites;
  scene.full.inputs.clear();
  if (energy.set_inputs != nullptr) {
    energy.set_inputs(scene.full);
  }
}

void require_known_pixels(const Scene& scene, const RegisteredEnergy& energy) {
  if (!energy.takes_forces && (has_forces(scene.full) || has_springs_by_direction(scene.full))) {
    throw InputError(fmt::format("{} has {}, which the {} energy does not know: what solves it by the "
                                 "elastic energy alone takes it",
                                 scene.name,
                                 has_forces(scene.full) ? "loads"
                                 : scene.full.has_walls ? "walls to slide along"
                                                        : "targets with a precision",
                                 energy.name));
  }
  if (!energy.takes_laws && has_laws(scene.full)) {
    throw InputError(fmt::format("{} has tissues with a law of large strains, which the {} energy does not "
                                 "know: `run` solves it by the elastic energy",
                                 scene.name, energy.name));
  }
  if (!energy.takes_boxes && scene.full.sides != Level{}.sides) {
    throw InputError(
        fmt::format("the pixels of {} have sides of {:.4g} to each other, and the {} energy knows "
                    "squares and cubes only; load the scene with it, or resample its files",
                    scene.name, fmt::join(scene.full.sides, " : "), energy.name));
  }
}

void use_energy(Scene& scene, const RegisteredEnergy& energy) {
  if (scene.energy == &energy) {
    return;
  }
  require_known_pixels(scene, energy);
  const bool keeps_schedule = energy.has(find_method(scene.schedule.method, scene.energy));
  scene.energy = &energy;
  set_energy_of_sites(scene);
  if (!keeps_schedule) {
    scene.schedule = {};
    use_method(scene, usual_method(scene));
  }
}

void use_method(Scene& scene, const Method& method, std::optional<int> iterations) {
  if (!scene.energy->has(method)) {
    use_energy(scene, energy_of(method));
  }
  const Schedule own = scene.schedule;
  Schedule schedule{.method = std::string(method.name),
                    .iterations =
                        iterations.value_or(method.usual_effort > 0 ? method.usual_effort : own.iterations),
                    .stop = own.stop,
                    .epsilon = own.epsilon,
                    .start_level = own.start_level,
                    .alignment = own.alignment};
  scene.full.update = Update::simultaneous;
  method.configure(schedule, scene.full);
  scene.schedule = schedule;
}

} // namespace hdmbench
