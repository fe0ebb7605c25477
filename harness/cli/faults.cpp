#include "harness/check/faults/trial.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/ranks/rank_faults.hpp"

#include <optional>
#include <set>

namespace hdmbench::commands {

namespace {

using faults::Expected;
using faults::Planted;
using faults::Trial;
using faults::TrialScene;
struct Arguments {
  std::vector<std::string> scenes;
  std::vector<std::string> faults;
  std::string size; ///< "300" or "257x130"; empty: small
  std::string backend = "scalar";
  bool list = false;
  bool brief = false;
};

/// Those that were named, or all. Throws InputError for a name that none has.
std::vector<Planted> chosen(const std::vector<std::string>& names, std::vector<Planted> all) {
  for (const std::string& name : names) {
    if (std::ranges::find(all, name, &Planted::name) == all.end()) {
      throw InputError(fmt::format("there is no fault \"{}\"; hdmbench faults --list names them", name));
    }
  }
  std::erase_if(all, [&](const Planted& planted) {
    return !names.empty() && std::ranges::find(names, planted.name) == names.end();
  });
  return all;
}

/// What people are told of a trial in one word.
std::string outcome(const Trial& trial) {
  if (!trial.not_planted.empty()) {
    return "NOT PLANTED";
  }
  if (!trial.ran() && trial.as_expected()) {
    return "not run";
  }
  const bool is_control = trial.planted.expected == Expected::let_through;
  if (trial.as_expected()) {
    return is_control ? "let through" : "yes";
  }
  return is_control ? "NOT LET THROUGH" : "NO";
}

/// Where verify disagreed; else the verdicts there were, each once. `row`: as json_row() has it.
std::string seen_on(const json& row) {
  json where = json::array();
  std::set<std::string> verdicts;
  for (const json& scene : row["scenes"]) {
    if (scene["verdict"] == name_of(Verdict::disagree)) {
      where.push_back(scene["scene"]);
    }
    verdicts.insert(scene["verdict"]);
  }
  std::string text;
  for (const json& one : where.empty() ? json(verdicts) : where) {
    text += (text.empty() ? "" : where.empty() ? ", " : "; ") + one.get<std::string>();
  }
  return where.empty() ? fmt::format("nowhere ({})", text) : text;
}

/// Why something was not run, not planted or broke off, each reason once.
std::set<std::string> reasons(const std::vector<Trial>& trials) {
  std::set<std::string> lines;
  for (const Trial& trial : trials) {
    const std::string name = fmt::format("  {} on {}", trial.planted.name, trial.planted.backend);
    if (!trial.not_planted.empty()) {
      lines.insert(fmt::format("{} is not planted: {}\n", name, trial.not_planted));
    }
    for (const auto& seen : trial.seen) {
      if (seen && !seen->error.empty()) {
        lines.insert(fmt::format("{}: {}\n", name, seen->error));
      } else if (seen && seen->verdict == Verdict::skipped) {
        lines.insert(fmt::format("  {} is skipped: {}\n", trial.planted.backend, seen->reason));
      } else if (seen && seen->verdict == Verdict::mistrusted && !trial.as_expected()) {
        lines.insert(fmt::format("{}: mistrusted: {}\n", name, seen->reason));
      }
    }
  }
  return lines;
}

/// How many were caught, and how many only where every number is exact. `rows`: as json_row() has them.
void print_sum(const std::vector<Trial>& trials, const json& rows) {
  const auto count = [&](Expected expected, bool only_good) {
    return std::ranges::count_if(trials, [&](const Trial& trial) {
      const bool judged = trial.ran() || !trial.as_expected();
      return trial.planted.expected == expected && judged && (trial.as_expected() || !only_good);
    });
  };
  fmt::print("\n{} of {} planted faults caught, {} of {} controls let through\n",
             count(Expected::disagree, true), count(Expected::disagree, false),
             count(Expected::let_through, true), count(Expected::let_through, false));
  const auto exact = std::ranges::count_if(rows, [](const json& row) {
    return row["expected"] == "disagree" && row["caught"] &&
           std::ranges::none_of(row["scenes"], [](const json& scene) {
             return scene["verdict"] == name_of(Verdict::disagree) && !scene["exact"];
           });
  });
  if (exact > 0) {
    fmt::print("{} of the faults only where every number is exact: elsewhere a near-tie would excuse them\n",
               exact);
  }
}

/// `list`: what is planted. `asleep`: in place of the small scene of sleeping tiles, where given.
int try_faults(const Arguments& arguments, const Call& call, const std::vector<Planted>& list,
               const Backend& reference, const std::optional<Scene>& asleep = {}) {
  if (arguments.list) {
    json rows = json::array();
    for (const Planted& planted : list) {
      rows.push_back({{"fault", planted.name}, {"planted_on", planted.backend}, {"what", planted.what}});
    }
    fmt::print("{}", table_text(rows, "fault|planted_on|what"));
    return success;
  }
  std::vector<TrialScene> scenes = faults::trial_scenes(arguments.scenes, parse_any_size(arguments.size));
  for (TrialScene& scene : scenes) {
    if (scene.tiles_sleep && asleep) {
      scene.label = asleep->name;
      scene.scene = *asleep;
    }
  }
  Progress progress(call.speaks());
  std::ptrdiff_t total = 0;
  for (const Planted& planted : list) {
    total += std::ranges::count_if(scenes, [&](const TrialScene& scene) { return concerns(planted, scene); });
  }
  progress.set_total(static_cast<double>(total));

  std::vector<Trial> trials;
  json rows = json::array();
  json shown = json::array();
  for (const Planted& planted : list) {
    const Trial& trial = trials.emplace_back(faults::try_out(planted, reference, scenes, progress));
    rows.push_back(json_row(trial, scenes));
    if (!arguments.brief || !trial.as_expected()) {
      shown.push_back(rows.back());
      shown.back().update({{"seen", seen_on(rows.back())}, {"caught", outcome(trial)}});
    }
  }
  progress.clear();
  if (!shown.empty()) {
    fmt::print("{}", table_text(shown, "fault|backend:planted on|layer|seen:verify disagrees on|caught"));
  }
  print_sum(trials, rows);
  for (const std::string& reason : reasons(trials)) {
    fmt::print("{}", reason);
  }
  call.write(std::move(rows));
  return std::ranges::all_of(trials, &Trial::as_expected) ? success : disagreement;
}

/// In one process what is computed has the mistakes, on ranks what they tell each other.
int run_faults(Arguments& arguments, Call& call) {
  const auto registry = make_backends();
  if (call.ranks == nullptr) {
    const Backend& carrier = find_backend(registry, arguments.backend);
    return try_faults(arguments, call, chosen(arguments.faults, faults::all_planted(carrier)),
                      *registry.front());
  }
  return try_faults(
      arguments, call,
      chosen(arguments.faults, faults::planted_on_ranks(*call.ranks, registry, arguments.backend)),
      *registry.front(), sleeping_pieces(call.ranks->size()));
}

} // namespace

void add_faults(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "faults",
      "Check the checker: plant mistakes into sessions, shaders and driver calls, one at a time, and "
      "see that verify\ndisagrees on one scene at least; and that it lets through what is no mistake.\n"
      "mpirun -n R hdmbench faults: mistakes in what ranks tell each other.\n"
      "Exit status 1 if a fault is caught nowhere, or a control is not let through.",
      run_faults);
  CLI::Option* const list = add_flag(command, "--list", own.list, "Name the faults and stop");
  add_option(command, "scenes", own.scenes, "Scenes by name or TOML file (none: small ones made for this)")
      ->excludes(list);
  add_option(command, "--faults", own.faults, "Faults and controls by name, with commas (none: all)")
      ->delimiter(',');
  add_option(command, "--size", own.size, "Image size: 300 (square) or 257x130 (none: 48x40, 32 where exact)")
      ->excludes(list);
  add_option(command, "--backend", own.backend, "Whose sessions make the sessions' mistakes");
  add_flag(command, "--brief", own.brief, "Only what did not go as expected, and the sum")->excludes(list);
  add_json(command, call)->excludes(list);
}

} // namespace hdmbench::commands
