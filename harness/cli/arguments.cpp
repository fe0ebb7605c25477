#include "harness/cli/arguments.hpp"

#include "harness/judge/truths.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/schedule_keys.hpp"
#include "harness/solve/request.hpp"
#include "harness/solve/unloading.hpp"

#include <unistd.h>

#include <charconv>
#include <cmath>
#include <iterator>
#include <map>

namespace hdmbench::commands {

/// The headings of the options in a command's help; the second is for what means nothing to other energies.
static constexpr const char* schedule_group = "Instead of what the scene says";
static constexpr const char* thesis_group = "Instead of what the scene says, of the thesis's energy alone";

std::vector<std::string> schedule_names(const CLI::App& command, const std::vector<std::string>& but) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : command.get_options()) {
    const std::string& group = option->get_group();
    if ((group == schedule_group || group == thesis_group) && !contains(but, option->get_name())) {
      names.push_back(option->get_name());
    }
  }
  return names;
}

Options schedule_options(bool takes_energies) {
  Options all{};
  const auto add = [&](const std::string& name, const std::string& takes, const std::string& help, auto take,
                       const char* group = schedule_group) {
    all = {all, Options(name, [=](CLI::App& command, Call& call) {
                  const std::function<void(const std::string&)> into =
                      [&call, take](const std::string& value) { take(call.schedule, value); };
                  command.add_option_function(name, into, help)->type_name(takes);
                }).under(group)};
  };
  if (takes_energies) {
    std::vector<std::string> choices;
    std::ranges::transform(
        registered_energies(), std::back_inserter(choices),
        [](const RegisteredEnergy* one) { return fmt::format("{} ({})", one->name, one->summary); });
    add("--energy", fmt::format("TEXT:{{{},auto}}", fmt::join(energy_names(), ",")),
        fmt::format(
            "What the displacement minimises: {}; a method brings its own. auto, with run --accuracy: "
            "elastic, and neo-Hookean tissue where that makes a difference",
            fmt::join(choices, " or ")),
        [](ScheduleOverrides& schedule, const std::string& name) { schedule.choose_energy(name); });
  }
  const auto add_key = [&](std::string_view key, std::string_view takes, std::string_view help,
                           bool is_of_all = true) {
    add(
        option_of(key), std::string(takes), std::string(help),
        [key](ScheduleOverrides& schedule, const std::string& value) {
          schedule.given[std::string(key)] = value;
        },
        is_of_all || !takes_energies ? schedule_group : thesis_group);
  };
  add_key("method", "TEXT", "How the scene is solved (see methods)");
  for (const ScheduleKey& key : schedule_keys()) {
    add_key(key.name, key.takes, key.help, key.of == ScheduleKey::Of::all);
  }
  return all;
}

std::string schedule_words(const ScheduleOverrides& schedule,
                           const std::optional<std::string>& other_method) {
  std::string result =
      schedule.energy == nullptr
          ? ""
          : fmt::format(" --energy {}", schedule.law.empty() ? schedule.energy->name : "auto");
  for (const auto& [key, value] : schedule.given) {
    if (key != "method" || !other_method) {
      result += fmt::format(" {} {}", option_of(key), shell_word(value));
    }
  }
  return other_method ? result + " --method " + *other_method : result;
}

Options backend_options() {
  return {option::backend, option::device, option::threads};
}

Options backends_options() {
  return {option::backends, option::require, option::device, option::threads};
}

Options scenes_options() {
  return {option::scenes, option::sizes, schedule_options(true), option::methods};
}

Options comparison_options() {
  return {scenes_options(), backends_options(), option::quick, option::json};
}

Scene scene_of(const Call& call, const Option<std::string>& name) {
  Scene scene =
      load_scene(call[name], {.size = parse_any_size(call[option::size]),
                              .orientation = call[option::orientation],
                              .slice = call[option::slice],
                              .tissues = call[option::tissues],
                              .points = call[option::points],
                              .law = call[option::law].empty() ? call.schedule.law : call[option::law],
                              .idle_point = call.idle_point,
                              .energy = call.schedule.energy_to_be(),
                              .as_cubes = !call.schedule.takes_boxes});
  call.schedule.apply(scene);
  Progress progress(call.speaks());
  unload(scene, progress);
  return scene;
}

/// FNV-1a.
static std::uint64_t hash_of(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  }
  return hash;
}

void require_same_scenes(const Call& call, std::span<const Scene> scenes) {
  if (call.ranks == nullptr) {
    return;
  }
  std::string own = fmt::format("hdmbench of commit {}", run_context("", false).commit);
  for (const Scene& scene : scenes) {
    own += fmt::format("\n{}, {}, energy {}, {}, {} iterations", scene.name, scene.extent().text(),
                       scene.energy->name, method_name(scene), scene.schedule.iterations);
    std::vector<std::filesystem::path> files = files_of_scene(scene.source);
    files.insert(files.end(), call[option::points].begin(), call[option::points].end());
    if (const auto& file = call[option::tissues]; !file.empty() && std::filesystem::exists(file)) {
      files.push_back(call[option::tissues]);
    }
    for (const std::filesystem::path& file : files) {
      own += fmt::format(", {} with the hash {:016x}", file.string(), hash_of(read_file(file)));
    }
  }
  require_same(*call.ranks, own, [](std::size_t rank, std::string_view text, std::string_view first) {
    const auto end = std::ranges::mismatch(text, first).in1 - text.begin();
    const auto line_of = [begin = text.substr(0, static_cast<std::size_t>(end)).rfind('\n') + 1](auto whole) {
      const std::string_view rest = whole.substr(std::min(begin, whole.size()));
      return rest.empty() ? "nothing" : rest.substr(0, rest.find('\n'));
    };
    return fmt::format("rank {} has {}, but rank 0 has {}; give all ranks the same program and files", rank,
                       line_of(text), line_of(first));
  });
}

const Backend& choose_backend(const Call& call, const std::vector<std::unique_ptr<Backend>>& registry,
                              const Scene& scene) {
  return hdmbench::choose_backend(registry, call[option::backend], scene);
}

std::string session_words(const SessionOptions& session) {
  return (session.device.empty() ? "" : " --device " + shell_word(session.device)) +
         (session.threads == 0 ? "" : fmt::format(" --threads {}", session.threads));
}

std::string size_words(const Scene& scene) {
  const bool are_boxes_of_file = scene.full.sides != Level{}.sides && has_pixels_of_files(scene.source);
  return are_boxes_of_file ? "" : fmt::format(" --size {}", scene.extent().text("x"));
}

std::string repeat_line(const Call& call, const Scene& scene, std::string_view backend, int threads) {
  std::string line = fmt::format("hdmbench {}", call.command->get_name());
  SessionOptions session = call.session();
  session.threads = threads > 0 ? threads : session.threads;
  if (const std::size_t on = backend.find(" on "); on != std::string_view::npos) { // "openmp on 4 ranks"
    const std::string_view count = backend.substr(on + 4);
    line = fmt::format("mpirun -n {} {}", count.substr(0, count.find(' ')), line);
    backend = backend.substr(0, on);
  }
  if (!scene.source.empty()) {
    line += fmt::format(" {}{}", shell_word(scene.source), size_words(scene));
  }
  // It chooses sizes only for bench, and one is given.
  const char* const quick = call[option::quick] && call.command->get_name() != "bench" ? " --quick" : "";
  const std::string law = call[option::law].empty() ? "" : " --law " + call[option::law];
  return fmt::format("{} --backends {}{}{}{}{}", line, backend, session_words(session), quick,
                     schedule_words(call.schedule, call[option::methods].empty()
                                                       ? std::nullopt
                                                       : std::optional(scene.schedule.method)),
                     law);
}

std::optional<Scene> load_unless_missing(std::string_view name, bool is_needed,
                                         const std::function<Scene()>& load) {
  try {
    return load();
  } catch (const MissingFile& error) {
    if (is_needed) {
      throw;
    }
    fmt::print("{} is left out: {}\n", name, error.what());
    return std::nullopt;
  }
}

/// Returns the scene, whose pixels are boxes where the command knows these: one that compares with the
/// thesis's energy does, where the elastic energy alone knows the scene.
static Scene load_with_boxes(const ScheduleOverrides& schedule, const std::string& name,
                             SceneOptions options) {
  Scene scene = load_scene(name, options);
  if (schedule.takes_boxes || scene.full.sides == Level{}.sides ||
      (schedule.meets_truths && is_of_tissue(scene))) {
    return scene;
  }
  options.as_cubes = true;
  return load_scene(name, options);
}

std::vector<SceneLoader> scene_loaders(const Call& call, const std::vector<std::string>& by_default) {
  const std::vector<std::string>& scenes = call[option::scenes];
  const std::vector<std::string>& sizes = call[option::sizes];
  const std::vector<std::string>& methods = call[option::methods];
  std::vector<std::optional<Extent>> extents(std::max<std::size_t>(sizes.size(), 1));
  std::ranges::transform(sizes, extents.begin(), parse_size);
  std::vector<std::optional<std::string>> chosen(methods.begin(), methods.end());
  if (methods == std::vector<std::string>{"all"}) {
    chosen.clear();
    std::ranges::transform(hdmbench::methods(), std::back_inserter(chosen),
                           [](const Method& method) { return std::string(method.name); });
  }
  chosen.resize(std::max<std::size_t>(chosen.size(), 1)); // none: what --method or the scene says
  std::vector<SceneLoader> loaders;
  for (const std::string& name : scenes.empty() ? by_default : scenes) {
    for (const std::optional<Extent>& extent : extents) {
      for (const std::optional<std::string>& method : chosen) {
        loaders.push_back([&call, name, extent, method] {
          return load_unless_missing(name, !call[option::scenes].empty(), [&] {
            Scene scene = load_with_boxes(
                call.schedule, name,
                {.size = extent, .law = call[option::law], .energy = call.schedule.energy_to_be(method)});
            call.schedule.apply(scene, method);
            Progress progress(call.speaks());
            unload(scene, progress);
            return scene;
          });
        });
      }
    }
  }
  return loaders;
}

std::vector<Scene> load_scenes(const Call& call, const std::vector<std::string>& by_default) {
  std::vector<Scene> loaded;
  for (const SceneLoader& load : scene_loaders(call, by_default)) {
    if (std::optional<Scene> scene = load()) {
      loaded.push_back(std::move(*scene));
    }
  }
  return loaded;
}

bool needs(const Call& call, std::string_view backend) {
  return contains(call[option::backends], backend) || contains(call[option::require], backend);
}

std::vector<const Backend*> choose_backends(const Call& call,
                                            const std::vector<std::unique_ptr<Backend>>& registry,
                                            const std::string& reference) {
  const std::vector<std::string>& backends = call[option::backends];
  const Backend* const scalar = registry.front().get();
  for (const auto* names : {&backends, &call[option::require]}) {
    for (const std::string& name : *names) {
      const Backend& backend = find_backend(registry, name);
      try {
        (void)backend.device(&backend == scalar ? SessionOptions{} : call.session());
      } catch (const DeviceError& error) {
        throw DeviceError(fmt::format("{} is needed but not there: {}", name, error.what()));
      }
    }
  }
  const Backend* const first = reference.empty()     ? scalar
                               : reference == "none" ? nullptr
                                                     : &find_backend(registry, reference);
  std::vector<const Backend*> chosen;
  for (const auto& backend : registry) {
    const bool is_wanted = backend.get() == scalar && first != scalar
                               ? contains(backends, scalar->name())
                               : backends.empty() || contains(backends, backend->name());
    if (is_wanted && backend.get() != first) {
      chosen.push_back(backend.get());
    }
  }
  if (first != scalar && chosen.empty()) {
    throw InputError(fmt::format("no backend is left to {}; name one with --backends",
                                 first == nullptr ? "run" : "compare with " + reference));
  }
  if (first != nullptr) {
    chosen.insert(chosen.begin(), first);
  }
  return chosen;
}

ExitStatus ended(const Call& call, bool good, std::string_view missing) {
  if (missing.empty() || !good) {
    return good ? success : disagreement;
  }
  if (call.speaks()) {
    std::fflush(stdout);
    fmt::print(stderr, "hdmbench: {}\n", printable(missing));
  }
  return bad_input;
}

Extent parse_size(const std::string& text) {
  const auto side = [&](std::string_view digits) {
    const std::optional<int> number = number_of<int>(digits);
    if (!number || *number < 1) {
      throw InputError(fmt::format("the size \"{}\" is not understood; give 300, 257x130 or 64x64x64", text));
    }
    return *number;
  };
  const std::string_view view = text;
  const std::size_t cross = std::min(view.find('x'), view.size());
  const std::size_t second = std::min(view.find('x', cross + 1), view.size());
  const Extent extent{side(view.substr(0, cross)),
                      cross == view.size() ? side(view) : side(view.substr(cross + 1, second - cross - 1)),
                      second == view.size() ? 1 : side(view.substr(second + 1))};
  require_memory(extent);
  return extent;
}

std::optional<Extent> parse_any_size(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional(parse_size(text));
}

std::string beside(const std::filesystem::path& results, const std::filesystem::path& folder,
                   const std::string& name) {
  namespace fs = std::filesystem;
  return results.empty() ? name
                         : (fs::proximate(folder, fs::absolute(results).parent_path()) / name)
                               .lexically_normal()
                               .string();
}

json gather_rows(const json& own, Ranks& ranks) {
  json rows = json::array();
  for (const std::string& text : ranks.gather(json_text(own))) {
    const json more = json::parse(text);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

std::string machine_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
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

} // namespace hdmbench::commands
