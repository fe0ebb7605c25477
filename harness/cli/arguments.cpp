#include "harness/cli/arguments.hpp"

#include "harness/measure/choices.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/joined.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/nearest_name.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <utility>

namespace hdmbench::commands {

namespace {

void add_session_to(const Command& command, SessionOptions& session) {
  command.add_option("--device", session.device, "Device by part of its name or by number (see devices)");
  command.add_option("--threads", session.threads, "CPU threads (0: all)").range(0, 4096);
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

void add_choice_cache_to(const Command& command, SessionOptions& session) {
  if (const std::filesystem::path file = choice_cache_file(); !file.empty()) {
    session.kept_choices = std::make_shared<ChoiceCache>(file);
  }
  command.add_flag(
      "--no-cache", [&session] { session.kept_choices.reset(); },
      "Measure anew which way is fastest on a device, and keep nothing of it for the next time");
}

void SceneArguments::add_scene_to(const Command& command) {
  command.add_option("scene", scene, "Scene by name or TOML file").required();
  command.add_option("--size", size, "Image size: 300 (square) or 257x130");
  schedule.add_to(command);
}

void SceneArguments::add_backend_to(const Command& command) {
  command.add_option("--backend", backend, "Backend that computes").capture_default_str();
  add_session_to(command, session);
}

void SceneArguments::add_orientation_to(const Command& command) {
  Option option = command.add_option("--orientation", orientation,
                                     "Of a [brain]: axial, coronal or sagittal, in place of the scene's own");
  option.one_of(std::vector<std::string>(orientation_names.begin(), orientation_names.end()));
  command.add_option("--slice", slice, "Of that orientation; default: the one that shows most of the brain")
      .needs(option);
}

Scene SceneArguments::load() const {
  Scene loaded = load_scene(scene, options());
  schedule.apply(loaded);
  return loaded;
}

SceneOptions SceneArguments::options() const {
  return {.size = size.empty() ? std::nullopt : std::optional(parse_size(size)),
          .orientation = orientation,
          .slice = slice};
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

void CommonArguments::add_backends_to(const Command& command) {
  command
      .add_option("--backends", backends, "Backends with commas (none: all; one that is named must be there)")
      .delimiter(',');
  command.add_option("--require", required, "Backends that must be there, others may be skipped")
      .delimiter(',');
  add_session_to(command, session);
}

void CommonArguments::add_scenes_to(const Command& command) {
  command.add_option("scenes", scenes,
                     "Scenes by name or TOML file (none: all that the command is made for)");
  command.add_option("--sizes,--size", sizes, "Image sizes: 300 (square) or 257x130, several with commas")
      .delimiter(',');
  schedule.add_to(command);
  command
      .add_option("--methods", methods,
                  "Several methods with commas, or all of them, instead of --method (tradeoff: rivals too)")
      .delimiter(',')
      .excludes("--method");
}

void CommonArguments::add_to(const Command& command) {
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

bool CommonArguments::needs(std::string_view backend) const {
  return std::ranges::find(backends, backend) != backends.end() ||
         std::ranges::find(required, backend) != required.end();
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

void require_other_outputs(const Command& command) {
  namespace fs = std::filesystem;
  constexpr std::array<std::string_view, 7> writes{
      "--json", "--junit", "--benchmark-json", "--output", "--csv", "--write", "output"};
  std::vector<fs::path> inputs;
  std::vector<fs::path> outputs;
  for (const Option& option : command.options()) {
    const bool is_output = std::ranges::find(writes, option.name()) != writes.end() ||
                           (command.name() == "fem-to-image" && option.name() == "--mask");
    for (const std::string& value : option.values()) {
      std::error_code missing;
      if (is_output) {
        outputs.emplace_back(value);
      } else if (fs::is_directory(value, missing)) {
        for (const auto& entry : fs::directory_iterator(value, missing)) {
          if (entry.path().extension() == ".json") {
            inputs.push_back(entry.path());
          }
        }
      } else {
        std::ranges::move(files_of_scene(value), std::back_inserter(inputs));
      }
    }
  }
  for (const fs::path& output : outputs) {
    require_no_input(output, inputs);
  }
}

std::string command_line(int argc, const char* const* argv) {
  std::string line;
  for (int i = 1; i < argc; ++i) {
    line += (i > 1 ? " " : "") + shell_word(argv[i]);
  }
  return line;
}

void leave_out_of_help(const Command& command, std::initializer_list<const char*> options) {
  for (const char* const option : options) {
    command.option(option).group("");
  }
}

void refuse_idle(const Command& command, std::initializer_list<Idle> idle) {
  for (const Idle& one : idle) {
    std::vector<std::string> given;
    std::ranges::copy_if(one.options, std::back_inserter(given),
                         [&](const std::string& option) { return command.count(option) > 0; });
    if (one.here && !given.empty()) {
      throw InputError(fmt::format("{} {} no effect here: {}; leave {} out", joined(given, ", "),
                                   given.size() > 1 ? "have" : "has", one.why,
                                   given.size() > 1 ? "them" : "it"));
    }
  }
}

std::vector<std::string> options_of_group(const Command& command, std::string_view group,
                                          std::initializer_list<std::string_view> but) {
  std::vector<std::string> names;
  for (const Option& option : command.options()) {
    const std::string name = option.name();
    if (option.heading() == group && std::ranges::find(but, name) == but.end()) {
      names.push_back(name);
    }
  }
  return names;
}

void require_known_options(const Command& command, const std::vector<std::string>& words) {
  std::vector<std::string> known{"--help"};
  for (const Option& option : command.options()) {
    for (const std::string& name : option.long_names()) {
      known.push_back("--" + name);
    }
  }
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (word == "--") { // what follows are no options
      return;
    }
    if (name.starts_with("--") && std::ranges::find(known, name) == known.end()) {
      throw InputError(fmt::format(
          "{} has no option {}; {}", command.name(), name,
          did_you_mean(name, known, fmt::format("hdmbench {} --help lists them", command.name()))));
    }
  }
}

void require_whole_lists(const Command& command, const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::size_t equals = words[i].find('=');
    const std::string name = words[i].substr(0, equals);
    const std::optional<Option> option = command.find(name);
    if (!option || option->delimiter() == '\0') {
      continue;
    }
    const std::string list = equals != std::string::npos ? words[i].substr(equals + 1)
                             : i + 1 < words.size()      ? words[i + 1]
                                                         : name;
    const char end = option->delimiter();
    if (fmt::format("{0}{1}{0}", end, list).find(fmt::format("{0}{0}", end)) != std::string::npos) {
      throw InputError(fmt::format("{} {}: a word is missing before or after a comma", name, list));
    }
  }
}

} // namespace hdmbench::commands
