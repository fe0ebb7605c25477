#include "harness/cli/arguments.hpp"

#include "harness/measure/choice_cache.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
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

constexpr const char* automatic = "auto";
const std::map<std::string, EnergyModel> energies{{"hdm", EnergyModel::hdm},
                                                  {"elastic", EnergyModel::elastic}};

void add_session_to(CLI::App& command, SessionOptions& session) {
  command.add_option("--device", session.device, "Device by part of its name or by number (see devices)");
  command.add_option("--threads", session.threads, "CPU threads (0: all)")->check(CLI::Range(0, 4096));
  add_choice_cache_to(command, session);
}

int parse_side(std::string_view text, const std::string& whole) {
  int side = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), side);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size() || side < 1) {
    throw InputError(fmt::format("the size \"{}\" is not understood; give 300 or 257x130", whole));
  }
  return side;
}

} // namespace

void add_choice_cache_to(CLI::App& command, SessionOptions& session) {
  if (const std::filesystem::path file = choice_cache_file(); !file.empty()) {
    session.kept_choices = std::make_shared<ChoiceCache>(file);
  }
  command.add_flag_callback(
      "--no-cache", [&session] { session.kept_choices.reset(); },
      "Measure anew which way is fastest on a device, and keep nothing of it for the next time");
}

void ScheduleOverrides::add_to(CLI::App& command) {
  const auto* const group = "Instead of what the scene says";
  if (takes_elastic) {
    command
        .add_option_function<std::string>(
            "--energy",
            [this](const std::string& name) {
              auto_energy = name == automatic;
              energy = auto_energy ? std::nullopt : std::optional(energies.at(name));
            },
            fmt::format("What the displacement minimises: hdm (the thesis) or elastic (plane stress); a "
                        "method of either brings its own{}",
                        takes_auto_energy ? "; auto: what --accuracy needs" : ""))
        ->check(CLI::IsMember(takes_auto_energy ? std::vector<std::string>{"hdm", "elastic", automatic}
                                                : std::vector<std::string>{"hdm", "elastic"}))
        ->group(group);
    command
        .add_option(
            "--robust", robust,
            "Of the elastic energy: observations with a confidence below 1 that are further away than "
            "this many pixels are forgiven")
        ->check(CLI::PositiveNumber)
        ->group(group);
  }
  command.add_option("--method", method, "How the scene is solved (see methods)")->group(group);
  command
      .add_option(
          "--iterations", iterations,
          "Effort of the method: iterations per level, exact or at most (see --stop), or what methods says")
      ->group(group);
  command.add_option("--relaxation", relaxation, "Of closed-form: how far a site moves towards its minimum")
      ->group(group);
  command.add_option("--temperatures", temperatures, "Of annealing: HIGHEST,LOWEST in units of the energy")
      ->delimiter(',')
      ->expected(2)
      ->group(group);
  command.add_option("--seed", seed, "Of annealing: 0 ... 4092")->group(group);
  command.add_option("--start-level", start_level, "First level computed; 0 is the full resolution")
      ->group(group);
  command
      .add_option("--stop", stop, "When a level ends: fixed, still (no site changed) or energy (thesis 5.3)")
      ->transform(CLI::CheckedTransformer(stops))
      ->group(group);
  command.add_option("--epsilon", epsilon, "Change of the mean energy that ends a level with --stop energy")
      ->check(CLI::Range(0.0, 1e6))
      ->group(group);
  command.add_option("--alignment", alignment, "Of the pyramid's levels: corner or center")
      ->transform(CLI::CheckedTransformer(alignments))
      ->group(group);
  command
      .add_option("--update", update,
                  "Of icm: simultaneous, coloured, four-coloured, or sequential (scalar only)")
      ->transform(CLI::CheckedTransformer(updates))
      ->group(group);
  command.add_option("--steps", steps, "Candidates: default, thesis, fine, or numbers such as 0,-1,1")
      ->group(group);
  command.add_option("--penalty", penalty, "K > 0 of the observation term")->group(group);
  command
      .add_option(
          "--prior-weight", prior_weight,
          "alpha of the thesis, (3.17), above 0 and below 1: U = alpha prior + (1 - alpha) observation")
      ->group(group);
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
  if ((scene.energy == EnergyModel::elastic || auto_energy) &&
      (start_level || epsilon || alignment || penalty || prior_weight)) {
    throw InputError("the elastic energy has levels of its own and prescribes what is observed; leave out "
                     "--start-level, --epsilon, --alignment, --penalty and --prior-weight");
  }
  if (robust && scene.energy == EnergyModel::hdm && !auto_energy) {
    throw InputError("the thesis's energy takes the absolute value of every observation, which forgives; "
                     "--robust is for --energy elastic");
  }
  scene.robust = robust ? robust : scene.robust;
  MethodOptions options{.iterations = iterations, .update = update, .relaxation = relaxation, .seed = seed};
  if (steps) {
    options.steps = StepSet::parse(*steps);
  }
  if (!temperatures.empty()) {
    options.cooling = Cooling{.highest = temperatures.at(0), .lowest = temperatures.at(1)};
  }
  set_options(scene, options);
  if (stop && scene.schedule.cycle != Cycle::one_way) {
    throw InputError(fmt::format("{} ends after its {}; leave out --stop", scene.schedule.method,
                                 find_method(scene.schedule.method, scene.energy).effort));
  }
  if (start_level) {
    set_start_level(scene, *start_level);
  }
  scene.schedule.stop = stop.value_or(scene.schedule.stop);
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
  add("--energy", auto_energy ? std::optional(automatic) : std::nullopt);
  add("--steps", steps ? std::optional(shell_word(*steps)) : std::nullopt);
  add("--penalty", penalty);
  add("--prior-weight", prior_weight);
  add("--robust", robust);
  return result;
}

void SceneArguments::add_scene_to(CLI::App& command) {
  command.add_option("scene", scene, "Scene by name or TOML file")->required();
  command.add_option("--size", size, "Image size: 300 (square) or 257x130");
  schedule.add_to(command);
}

void SceneArguments::add_backend_to(CLI::App& command) {
  command.add_option("--backend", backend, "Backend that computes")->capture_default_str();
  add_session_to(command, session);
}

Scene SceneArguments::load() const {
  Scene loaded = load_scene(scene, options());
  schedule.apply(loaded);
  return loaded;
}

ScenePart SceneArguments::load_part(const ChoosePart& part) const {
  ScenePart loaded = load_scene_part(scene, options(), part);
  schedule.apply(loaded.scene);
  return loaded;
}

SceneOptions SceneArguments::options() const {
  return {.size = size.empty() ? std::nullopt : std::optional(parse_size(size))};
}

const Backend& SceneArguments::choose(const std::vector<std::unique_ptr<Backend>>& registry,
                                      const Scene& scene_to_solve) const {
  const Backend& found = find_backend(registry, backend);
  if (!found.supports(scene_to_solve.full.update)) {
    throw InputError(fmt::format("{} cannot update as {} wants; use --backend scalar", found.name(),
                                 method_name(scene_to_solve)));
  }
  return found;
}

std::string CommonArguments::repeat(std::string_view command, const Scene& scene,
                                    std::string_view backend) const {
  const std::size_t on = backend.find(" on "); // "openmp on 4 ranks"
  const bool ranks = on != std::string_view::npos;
  std::string line = fmt::format("hdmbench {}", command);
  if (ranks) {
    const std::string_view count = backend.substr(on + 4);
    line = fmt::format("mpirun -n {} {}", count.substr(0, count.find(' ')), line);
    backend = backend.substr(0, on);
  }
  if (!scene.source.empty()) {
    line += fmt::format(" {} --size {}x{}", shell_word(scene.source), scene.extent().width,
                        scene.extent().height);
  }
  line += fmt::format(" --backends {}", backend);
  if (!session.device.empty()) {
    line += " --device " + shell_word(session.device);
  }
  if (session.threads != 0) {
    line += fmt::format(" --threads {}", session.threads);
  }
  const bool many = !methods.empty();
  return line + (quick ? " --quick" : "") +
         schedule.text(many ? std::optional(scene.schedule.method) : std::nullopt);
}

void CommonArguments::add_backends_to(CLI::App& command) {
  command
      .add_option("--backends", backends, "Backends with commas (none: all; one that is named must be there)")
      ->delimiter(',');
  command.add_option("--require", required, "Backends that must be there, others may be skipped")
      ->delimiter(',');
  add_session_to(command, session);
}

void CommonArguments::add_scenes_to(CLI::App& command) {
  command.add_option("scenes", scenes,
                     "Scenes by name or TOML file (none: all that the command is made for)");
  command.add_option("--sizes,--size", sizes, "Image sizes: 300 (square) or 257x130, several with commas")
      ->delimiter(',');
  schedule.add_to(command);
  command
      .add_option("--methods", methods,
                  "Several methods with commas, or all of them, instead of --method (tradeoff: rivals too)")
      ->delimiter(',')
      ->excludes("--method");
}

void CommonArguments::add_to(CLI::App& command) {
  add_scenes_to(command);
  add_backends_to(command);
  command.add_flag("--quick", quick, "A shorter run; the results say so");
  command.add_option("--json", json, "Write the results to this file");
}

std::vector<std::optional<std::string>> CommonArguments::chosen_methods() const {
  std::vector<std::optional<std::string>> chosen;
  if (methods == std::vector<std::string>{"all"}) {
    for (const Method& method : hdmbench::methods()) {
      chosen.emplace_back(method.name);
    }
  } else {
    chosen.assign(methods.begin(), methods.end());
  }
  if (chosen.empty()) {
    chosen.emplace_back(std::nullopt);
  }
  return chosen;
}

std::vector<SceneChoice> CommonArguments::scene_choices(const std::vector<std::string>& by_default) const {
  std::vector<SceneOptions> options;
  std::ranges::transform(sizes, std::back_inserter(options),
                         [](const std::string& size) { return SceneOptions{.size = parse_size(size)}; });
  if (options.empty()) {
    options.emplace_back();
  }
  std::vector<SceneChoice> choices;
  for (const std::string& name : scenes.empty() ? by_default : scenes) {
    for (const SceneOptions& option : options) {
      for (const auto& method : chosen_methods()) {
        choices.push_back({.name = name, .options = option, .method = method, .by_default = scenes.empty()});
      }
    }
  }
  return choices;
}

std::optional<Scene> CommonArguments::load(const SceneChoice& choice) const {
  try {
    Scene scene = load_scene(choice.name, choice.options);
    schedule.apply(scene, choice.method);
    return scene;
  } catch (const MissingFile& error) {
    if (!choice.by_default) {
      throw;
    }
    fmt::print("{} is left out: {}\n", choice.name, error.what());
    return std::nullopt;
  }
}

std::vector<Scene> CommonArguments::load_scenes(const std::vector<std::string>& by_default) const {
  std::vector<Scene> loaded;
  for (const SceneChoice& choice : scene_choices(by_default)) {
    if (std::optional<Scene> scene = load(choice)) {
      loaded.push_back(std::move(*scene));
    }
  }
  return loaded;
}

std::vector<const Backend*>
CommonArguments::choose(const std::vector<std::unique_ptr<Backend>>& registry) const {
  for (const auto* names : {&backends, &required}) {
    for (const std::string& name : *names) {
      const Backend& backend = find_backend(registry, name);
      try {
        (void)backend.device(&backend == registry.front().get() ? SessionOptions{} : session);
      } catch (const DeviceError& error) {
        throw DeviceError(fmt::format("{} is needed but not there: {}", name, error.what()));
      }
    }
  }
  std::vector<const Backend*> chosen{registry.front().get()};
  for (const auto& backend : registry) {
    const bool wanted = backends.empty() || std::ranges::find(backends, backend->name()) != backends.end();
    if (wanted && backend != registry.front()) {
      chosen.push_back(backend.get());
    }
  }
  return chosen;
}

Extent parse_size(const std::string& text) {
  const auto cross = text.find('x');
  if (cross == std::string::npos) {
    const int side = parse_side(text, text);
    return {side, side};
  }
  const std::string_view view = text;
  return {parse_side(view.substr(0, cross), text), parse_side(view.substr(cross + 1), text)};
}

std::string shell_word(std::string_view word) {
  if (!word.empty() && word.find_first_of(" \t\n'\"\\$&|;<>()*?#~`!{}") == std::string_view::npos) {
    return std::string(word);
  }
  std::string result = "'";
  for (const char c : word) {
    result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return result + "'";
}

std::string command_line(int argc, const char* const* argv) {
  std::string line;
  for (int i = 1; i < argc; ++i) {
    line += (i > 1 ? " " : "") + shell_word(argv[i]);
  }
  return line;
}

void leave_out_of_help(CLI::App& command, std::initializer_list<const char*> options) {
  for (const char* const option : options) {
    command.get_option(option)->group("");
  }
}

void require_whole_lists(const CLI::App& command, const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::size_t equals = words[i].find('=');
    const std::string name = words[i].substr(0, equals);
    const CLI::Option* const option = command.get_option_no_throw(name);
    if (option == nullptr || option->get_delimiter() == '\0') {
      continue;
    }
    const std::string list = equals != std::string::npos ? words[i].substr(equals + 1)
                             : i + 1 < words.size()      ? words[i + 1]
                                                         : name;
    const std::string ends(1, option->get_delimiter());
    if ((ends + list + ends).find(ends + ends) != std::string::npos) {
      throw InputError(fmt::format("{} {}: a word is missing before or after a comma", name, list));
    }
  }
}

} // namespace hdmbench::commands
