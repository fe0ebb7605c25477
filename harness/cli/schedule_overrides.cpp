#include "harness/cli/schedule_overrides.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/scene/names.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hdmbench::commands {

/// The heading of the options in a command's help.
static constexpr const char* schedule_group = "Instead of what the scene says";

std::vector<std::string> schedule_options(const CLI::App& command, const std::vector<std::string>& but) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : command.get_options()) {
    if (option->get_group() == schedule_group && std::ranges::find(but, option->get_name()) == but.end()) {
      names.push_back(option->get_name());
    }
  }
  return names;
}

void ScheduleOverrides::add_to(CLI::App& command) {
  command_ = &command;
  const OptionGroup group(command, schedule_group);
  const auto add = [&](const char* name, auto& value, const char* help) {
    return add_option(command, name, value, help);
  };
  const auto add_choice = [&]<typename Value>(const char* name, std::optional<Value>& value,
                                              const auto& names, const char* help) {
    const auto take = [&value, &names](const std::string& word) {
      value = static_cast<Value>(std::ranges::find(names, word) - names.begin());
    };
    command.add_option_function<std::string>(name, take, help)
        ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
  };
  if (takes_energy) {
    std::vector<std::string> choices;
    std::ranges::transform(energies(), std::back_inserter(choices), [](const RegisteredEnergy* one) {
      return fmt::format("{} ({})", one->name, one->summary);
    });
    const auto names = energy_names();
    const auto take = [this](const std::string& name) { energy = &find_energy(name); };
    command
        .add_option_function<std::string>(
            "--energy", take,
            fmt::format("What the displacement minimises: {}; a method brings its own",
                        fmt::join(choices, " or ")))
        ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
  }
  add("--method", method, "How the scene is solved (see methods)");
  add("--iterations", options.iterations,
      "Effort of the method: iterations per level, exact or at most (see --stop), or what methods says");
  add("--relaxation", options.relaxation, "Of closed-form: how far a site moves towards its minimum");
  const auto take_temperatures = [this](const std::vector<double>& two) {
    options.cooling = Cooling{.highest = two.at(0), .lowest = two.at(1)};
  };
  command
      .add_option_function<std::vector<double>>("--temperatures", take_temperatures,
                                                "Of annealing: HIGHEST,LOWEST in units of the energy")
      ->delimiter(',')
      ->expected(2);
  add("--seed", options.seed, "Of annealing: 0 ... 4092");
  add("--start-level", start_level, "First level computed; 0 is the full resolution");
  add_choice("--stop", stop, stop_names,
             "When a level ends: fixed, still (no site changed) or energy (thesis 5.3)");
  add("--epsilon", epsilon, "Change of the mean energy that ends a level with --stop energy")
      ->check(CLI::Range(0.0, 1e6));
  add_choice("--alignment", alignment, alignment_names, "Of the pyramid's levels: corner or center");
  add_choice("--update", options.update, update_names,
             "Of icm: simultaneous, coloured, four-coloured, or sequential (scalar only)");
  command.add_option_function<std::string>(
      "--steps", [this](const std::string& text) { options.steps = StepSet::parse(text); },
      "Candidates: default, thesis, fine, or numbers such as 0,-1,1");
  add("--penalty", penalty, "K > 0 of the observation term");
  add("--prior-weight", prior_weight,
      "alpha of the thesis, (3.17), above 0 and below 1: U = alpha prior + (1 - alpha) observation");
}

void ScheduleOverrides::apply(Scene& scene, const std::optional<std::string>& other_method) const {
  const std::optional<std::string> chosen = other_method ? other_method : method;
  if (energy != nullptr) {
    use_energy(scene, *energy);
  }
  if (chosen) {
    use_method(scene, find_method(*chosen, energy));
  }
  const bool of_cells = scene.energy->is_of_cells();
  if (of_cells && !takes_energy) {
    throw InputError(fmt::format("{} would have the {} energy, which this command does not know; run, "
                                 "verify, bench, tradeoff and accuracy do",
                                 scene.name, scene.energy->name));
  }
  if (of_cells && (start_level || epsilon || alignment || penalty || prior_weight)) {
    throw InputError(fmt::format("the {} energy has levels of its own and prescribes what is observed; leave "
                                 "out --start-level, --epsilon, --alignment, --penalty and --prior-weight",
                                 scene.energy->name));
  }
  set_options(scene, options);
  if (stop && of_cells) {
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
      !chosen && !options.steps && !penalty && !prior_weight && !start_level && !alignment && !energy;
  const bool provable = scene.full.update != Update::sequential;
  scene.exact = scene.exact && own_numbers && provable; // the file vouches for nothing else
}

std::string ScheduleOverrides::text(const std::optional<std::string>& other_method) const {
  std::string result = other_method ? " --method " + *other_method : "";
  for (const std::string& name : schedule_options(*command_, {other_method ? "--method" : ""})) {
    if (command_->count(name) > 0) {
      result += fmt::format(" {} {}", name, shell_word(joined(command_->get_option(name)->results(), ",")));
    }
  }
  return result;
}

} // namespace hdmbench::commands
