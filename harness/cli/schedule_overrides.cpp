#include "harness/cli/schedule_overrides.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

namespace hdmbench::commands {

namespace {

const std::map<std::string, Stop> stops{
    {"fixed", Stop::fixed}, {"still", Stop::still}, {"energy", Stop::energy}};
const std::map<std::string, Alignment> alignments{{"corner", Alignment::corner},
                                                  {"center", Alignment::center}};
const std::map<std::string, Update> updates{{"simultaneous", Update::simultaneous},
                                            {"sequential", Update::sequential},
                                            {"coloured", Update::coloured},
                                            {"four-coloured", Update::four_coloured}};

template <typename Value>
std::vector<std::string> words_of(const std::map<std::string, Value>& meanings) {
  std::vector<std::string> words;
  for (const auto& [word, meaning] : meanings) {
    words.push_back(word);
  }
  return words;
}

const std::map<std::string, EnergyModel> energies{{"hdm", EnergyModel::hdm},
                                                  {"elastic", EnergyModel::elastic}};

} // namespace

void ScheduleOverrides::add_to(const Command& command) {
  const auto* const group = schedule_group;
  if (takes_elastic) {
    command
        .add_option(
            "--energy", [this](const std::string& name) { energy = energies.at(name); },
            "What the displacement minimises: hdm (the thesis) or elastic (plane stress); a method of either "
            "brings its own")
        .one_of({"hdm", "elastic"})
        .group(group);
    if (is_of_run) {
      command
          .add_option(
              "--robust", robust,
              "Of the elastic energy: observations with a confidence below 1 that are further away than "
              "this many pixels are forgiven")
          .range(1e-6, 1e6) // PositiveNumber would name the largest double
          .group(group);
      command
          .add_option(
              "--stride", stride,
              "Of the elastic energy: solve an image that samples every so many pixels, with means of "
              "their moduli, and interpolate; 1 is the full resolution")
          .range(1, 1024)
          .group(group);
    }
  }
  command.add_option("--method", method, "How the scene is solved (see methods)").group(group);
  command
      .add_option(
          "--iterations", iterations,
          "Effort of the method: iterations per level, exact or at most (see --stop), or what methods says")
      .group(group);
  command.add_option("--relaxation", relaxation, "Of closed-form: how far a site moves towards its minimum")
      .group(group);
  command.add_option("--temperatures", temperatures, "Of annealing: HIGHEST,LOWEST in units of the energy")
      .delimiter(',')
      .expected(2)
      .group(group);
  command.add_option("--seed", seed, "Of annealing: 0 ... 4092").group(group);
  command.add_option("--start-level", start_level, "First level computed; 0 is the full resolution")
      .group(group);
  command
      .add_option(
          "--stop", [this](const std::string& word) { stop = stops.at(word); },
          "When a level ends: fixed, still (no site changed) or energy (thesis 5.3)")
      .one_of(words_of(stops))
      .group(group);
  command.add_option("--epsilon", epsilon, "Change of the mean energy that ends a level with --stop energy")
      .range(0.0, 1e6)
      .group(group);
  command
      .add_option(
          "--alignment", [this](const std::string& word) { alignment = alignments.at(word); },
          "Of the pyramid's levels: corner or center")
      .one_of(words_of(alignments))
      .group(group);
  command
      .add_option(
          "--update", [this](const std::string& word) { update = updates.at(word); },
          "Of icm: simultaneous, coloured, four-coloured, or sequential (scalar only)")
      .one_of(words_of(updates))
      .group(group);
  command.add_option("--steps", steps, "Candidates: default, thesis, fine, or numbers such as 0,-1,1")
      .group(group);
  command.add_option("--penalty", penalty, "K > 0 of the observation term").group(group);
  command
      .add_option(
          "--prior-weight", prior_weight,
          "alpha of the thesis, (3.17), above 0 and below 1: U = alpha prior + (1 - alpha) observation")
      .group(group);
}

void ScheduleOverrides::apply(Scene& scene, const std::optional<std::string>& other_method) const {
  const std::optional<std::string> chosen = other_method ? other_method : method;
  if (chosen) {
    use_method(scene, find_method(*chosen, energy));
  } else if (energy && *energy != scene.energy) {
    use_method(scene, usual_method(*energy));
  }
  if (scene.energy == EnergyModel::elastic && !takes_elastic) {
    throw InputError(fmt::format("{} would have the elastic energy, which this command does not know; run, "
                                 "verify, bench, tradeoff and accuracy do",
                                 scene.name));
  }
  if (scene.energy == EnergyModel::elastic &&
      (start_level || epsilon || alignment || penalty || prior_weight)) {
    throw InputError("the elastic energy has levels of its own and prescribes what is observed; leave out "
                     "--start-level, --epsilon, --alignment, --penalty and --prior-weight");
  }
  if (robust && scene.energy == EnergyModel::hdm) {
    throw InputError("the thesis's energy takes the absolute value of every observation, which forgives; "
                     "--robust is for --energy elastic");
  }
  if (stride && scene.energy == EnergyModel::hdm) {
    throw InputError(
        "the thesis's energy has its pyramid, see --start-level; --stride is for --energy elastic");
  }
  scene.schedule.stride = stride.value_or(scene.schedule.stride);
  scene.robust = robust ? robust : scene.robust;
  MethodOptions options{.iterations = iterations, .update = update, .relaxation = relaxation, .seed = seed};
  if (steps) {
    options.steps = StepSet::parse(*steps);
  }
  if (!temperatures.empty()) {
    options.cooling = Cooling{.highest = temperatures.at(0), .lowest = temperatures.at(1)};
  }
  set_options(scene, options);
  if (stop && scene.energy == EnergyModel::elastic) {
    throw InputError(fmt::format("{} ends after its {}; leave out --stop", scene.schedule.method,
                                 find_method(scene.schedule.method, scene.energy).effort));
  }
  if (start_level) {
    set_start_level(scene, *start_level);
  }
  scene.schedule.stop = stop.value_or(scene.schedule.stop);
  if (epsilon && scene.schedule.stop != Stop::energy) {
    throw InputError("--epsilon has no effect here: it ends a level with --stop energy; give that, or leave "
                     "it out");
  }
  scene.schedule.epsilon = epsilon.value_or(scene.schedule.epsilon);
  scene.schedule.alignment = alignment.value_or(scene.schedule.alignment);
  set_weight(scene, {.penalty = penalty.value_or(scene.weight.penalty),
                     .prior_weight = prior_weight.value_or(scene.weight.prior_weight)});
  const bool own_numbers =
      !chosen && !steps && !penalty && !prior_weight && !start_level && !alignment && !energy;
  const bool provable = scene.full.update != Update::sequential;
  scene.exact = scene.exact && own_numbers && provable; // the file vouches for nothing else
}

std::string ScheduleOverrides::text(const std::optional<std::string>& other_method) const {
  std::string result;
  const auto add = [&](std::string_view option, const auto& value) {
    if (value) {
      result += fmt::format(" {} {}", option, *value);
    }
  };
  const auto add_name = [&](std::string_view option, const auto& value, const auto& names) {
    for (const auto& [name, meaning] : names) {
      if (value == meaning) {
        result += fmt::format(" {} {}", option, name);
      }
    }
  };
  add("--method", other_method ? other_method : method);
  add("--iterations", iterations);
  add("--relaxation", relaxation);
  if (!temperatures.empty()) {
    result += fmt::format(" --temperatures {}", fmt::join(temperatures, ","));
  }
  add("--seed", seed);
  add("--start-level", start_level);
  add_name("--stop", stop, stops);
  add("--epsilon", epsilon);
  add_name("--alignment", alignment, alignments);
  add_name("--update", update, updates);
  add_name("--energy", energy, energies);
  add("--steps", steps ? std::optional(shell_word(*steps)) : std::nullopt);
  add("--penalty", penalty);
  add("--prior-weight", prior_weight);
  add("--robust", robust);
  add("--stride", stride);
  return result;
}

} // namespace hdmbench::commands
