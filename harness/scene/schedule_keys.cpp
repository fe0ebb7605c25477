#include "harness/scene/schedule_keys.hpp"

#include "harness/scene/method.hpp"
#include "harness/scene/names.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

namespace hdmbench {

namespace {

using Of = ScheduleKey::Of;

/// Not a number passes.
template <typename Number>
Number number(const std::string& text, Number least, Number most) {
  const auto value = number_of<Number>(text);
  if (!value || *value < least || *value > most) {
    throw InputError(fmt::format("give {} ... {}", least, most));
  }
  return *value;
}
constexpr double any = std::numeric_limits<double>::infinity();

template <auto member, const auto& names>
void choose(Scene& scene, const std::string& text) {
  const auto found = std::ranges::find(names, text);
  if (found == names.end()) {
    throw InputError(fmt::format("give one of {}", fmt::join(names, ", ")));
  }
  auto& of = [&]() -> auto& {
    if constexpr (std::is_invocable_v<decltype(member), Schedule&>) {
      return scene.schedule;
    } else {
      return scene.full;
    }
  }
  ();
  of.*member = static_cast<std::remove_reference_t<decltype(of.*member)>>(found - names.begin());
}

void set_relaxation(Scene& scene, const std::string& text) {
  const double factor = number(text, 0.0, 2.0);
  if (!(factor > 0.0 && factor < 2.0)) {
    throw InputError("it must be above 0 and below 2");
  }
  scene.schedule.relaxation.factor = factor;
}

void set_temperatures(Scene& scene, const std::string& text) {
  constexpr double largest = 1e30; // 1 / T is a 32-bit float, and so are the energies it is compared with
  const std::size_t comma = std::min(text.find(','), text.size() - 1);
  const auto highest = number(text.substr(0, comma), 1.0 / largest, largest);
  const auto lowest = number(text.substr(comma + 1), 1.0 / largest, largest);
  if (!(lowest <= highest)) {
    throw InputError("the first temperature must be the higher one");
  }
  scene.schedule.cooling = {.highest = highest, .lowest = lowest};
}

void set_epsilon(Scene& scene, const std::string& text) {
  scene.schedule.epsilon = number(text, 0.0, 1e6);
  if (scene.schedule.stop != Stop::energy) {
    throw InputError("has no effect here: it ends a level with --stop energy; give that, or leave "
                     "it out");
  }
}

void set_steps(Scene& scene, const std::string& text) {
  scene.full.steps = StepSet::parse(text);
  if (scene.schedule.rule == Rule::annealing) { // which leaves out 0
    find_method(scene.schedule.method, scene.energy).configure(scene.schedule, scene.full);
  }
}

void set_poisson(Scene& scene, const std::string& text) {
  const double poisson = number(text, -1.0, 0.5);
  if (!(poisson > -1.0 && poisson <= 0.5)) {
    throw InputError("it must be above -1 and at most 0.5");
  }
  if (scene.extent().axes() == 3 && poisson > largest_volume_poisson) {
    throw InputError(
        fmt::format("of a volume it must be at most {}: one that keeps its size whatever pulls at "
                    "it has no energy of this kind",
                    largest_volume_poisson));
  }
  scene.elastic.poisson = poisson;
}

constexpr std::array keys{
    ScheduleKey{"iterations", "schedule", Of::all, true, "INT",
                "Effort of the method: iterations per level, exact or at most (see --stop), or what methods "
                "says",
                [](Scene& scene, const std::string& text) {
                  scene.schedule.iterations = number(text, 0, largest_effort);
                }},
    ScheduleKey{"relaxation", "schedule", Of::methods, true, "FLOAT",
                "Of closed-form: how far a site moves towards its minimum", set_relaxation},
    ScheduleKey{"temperatures", "schedule", Of::methods, true, "HIGHEST,LOWEST",
                "Of annealing, in units of the energy", set_temperatures},
    ScheduleKey{"seed", "schedule", Of::methods, true, "INT", "Of annealing: 0 ... 4092",
                [](Scene& scene, const std::string& text) { scene.full.seed = number(text, 0, 4092); }},
    ScheduleKey{"start_level", "schedule", Of::sites, false, "INT",
                "First level computed; 0 is the full resolution",
                [](Scene& scene, const std::string& text) {
                  set_start_level(scene, number(text, -largest_effort, largest_effort));
                }},
    ScheduleKey{"stop", "schedule", Of::sites, true, "TEXT:{fixed,still,energy}",
                "When a level ends: fixed, still (no site changed) or energy (thesis 5.3)",
                choose<&Schedule::stop, stop_names>},
    ScheduleKey{"epsilon", "schedule", Of::sites, true, "FLOAT:FLOAT in [0 - 1000000]",
                "Change of the mean energy that ends a level with --stop energy", set_epsilon},
    ScheduleKey{"alignment", "schedule", Of::sites, false, "TEXT:{corner,center}",
                "Of the pyramid's levels: corner or center", choose<&Schedule::alignment, alignment_names>},
    ScheduleKey{"update", "schedule", Of::methods, true,
                "TEXT:{simultaneous,sequential,coloured,four-coloured}",
                "Of icm: simultaneous, coloured, four-coloured, or sequential (scalar only)",
                choose<&Level::update, update_names>},
    ScheduleKey{"steps", "", Of::methods, false, "TEXT",
                "Candidates: default, thesis, fine, or numbers such as 0,-1,1", set_steps},
    ScheduleKey{"poisson", "", Of::all, true, "FLOAT",
                "Poisson's ratio of the elastic energy and of finite elements", set_poisson},
    ScheduleKey{"penalty", "", Of::sites, false, "FLOAT", "K > 0 of the observation term",
                [](Scene& scene, const std::string& text) {
                  set_weight(scene, {number(text, -any, any), scene.weight.prior_weight});
                }},
    ScheduleKey{"prior_weight", "", Of::sites, false, "FLOAT",
                "alpha of the thesis, (3.17), above 0 and below 1: U = alpha prior + (1 - alpha) observation",
                [](Scene& scene, const std::string& text) {
                  set_weight(scene, {scene.weight.penalty, number(text, -any, any)});
                }}};

} // namespace

std::span<const ScheduleKey> schedule_keys() {
  return keys;
}

void set_key(Scene& scene, const ScheduleKey& key, const std::string& text) {
  const auto takes = [&](const Method& method) { return method.takes.find(key.name) != method.takes.npos; };
  const Method& own = find_method(scene.schedule.method, scene.energy);
  if (key.of == Of::sites && scene.energy->is_of_cells()) {
    throw InputError(fmt::format("the {} energy has levels and an end of its own and prescribes what is "
                                 "observed; leave out --start-level, --stop, --epsilon, --alignment, "
                                 "--penalty and --prior-weight",
                                 scene.energy->name));
  }
  if (key.of == Of::methods && !takes(own)) {
    std::string takers;
    for (const Method& method : methods()) {
      takers += takes(method) ? fmt::format("{}{}", takers.empty() ? "" : ", ", method.name) : "";
    }
    throw InputError(
        fmt::format("the method {} does not take {}; those that do are {}", own.name, key.name, takers));
  }
  key.set(scene, text);
}

} // namespace hdmbench
