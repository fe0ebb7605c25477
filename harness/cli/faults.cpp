#include "harness/check/faults/trial.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/ranks/rank_faults.hpp"
#include "harness/ranks/sleeping_pieces.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <optional>

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
  std::filesystem::path json;
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

void print_list(const std::vector<Planted>& list) {
  Table table({"<fault", "<planted on", "<what"});
  for (const Planted& planted : list) {
    table.add({planted.name, planted.backend, planted.what});
  }
  fmt::print("{}", table.text());
}

std::string outcome(const Trial& trial) {
  if (!trial.not_planted.empty()) {
    return "NOT PLANTED";
  }
  if (!trial.ran() && trial.as_expected()) {
    return "not run";
  }
  switch (trial.planted.expected) {
  case Expected::disagree:
    return trial.caught() ? "yes" : "NO";
  case Expected::let_through:
    return trial.as_expected() ? "let through" : "NOT LET THROUGH";
  case Expected::either:
    return trial.caught() ? "yes" : "not shown";
  }
  return "";
}

/// Where verify disagreed; else the verdicts there were, each once.
std::string seen_on(const Trial& trial, const std::vector<TrialScene>& scenes) {
  std::vector<std::string> where;
  std::vector<std::string> verdicts;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (trial.seen[i] && text(*trial.seen[i]) == name_of(Verdict::disagree)) {
      where.push_back(scenes[i].label);
    } else if (trial.seen[i] && std::ranges::find(verdicts, text(*trial.seen[i])) == verdicts.end()) {
      verdicts.emplace_back(text(*trial.seen[i]));
    }
  }
  return where.empty() ? fmt::format("nowhere ({})", fmt::join(verdicts, ", "))
                       : fmt::format("{}", fmt::join(where, "; "));
}

/// Why something was not run, not planted or broke off, each reason once.
void explain(const std::vector<Trial>& trials) {
  std::vector<std::string> lines;
  const auto add = [&](std::string line) {
    if (!line.empty() && std::ranges::find(lines, line) == lines.end()) {
      lines.push_back(std::move(line));
    }
  };
  for (const Trial& trial : trials) {
    const Planted& planted = trial.planted;
    if (!trial.not_planted.empty()) {
      add(fmt::format("{} on {} is not planted: {}", planted.name, planted.backend, trial.not_planted));
    }
    for (const auto& seen : trial.seen) {
      if (seen && !seen->error.empty()) {
        add(fmt::format("{} on {}: {}", planted.name, planted.backend, seen->error));
      } else if (seen && seen->verdict == Verdict::skipped) {
        add(fmt::format("{} is skipped: {}", planted.backend, seen->reason));
      } else if (seen && seen->verdict == Verdict::mistrusted && planted.expected == Expected::let_through) {
        add(fmt::format("{} on {}: mistrusted: {}", planted.name, planted.backend, seen->reason));
      }
    }
  }
  for (const std::string& line : lines) {
    fmt::print("  {}\n", line);
  }
}

/// All that was tried, or only `in_brief` what did not go as expected.
void print_table(const std::vector<Trial>& trials, const std::vector<TrialScene>& scenes, bool in_brief) {
  Table table({"<fault", "<planted on", "<layer", "<verify disagrees on", "<caught"});
  if (in_brief && std::ranges::all_of(trials, &Trial::as_expected)) {
    return;
  }
  for (const Trial& trial : trials) {
    if (!(in_brief && trial.as_expected())) {
      table.add({trial.planted.name, trial.planted.backend,
                 std::string(faults::layer_names.at(static_cast<std::size_t>(trial.planted.layer))),
                 seen_on(trial, scenes), outcome(trial)});
    }
  }
  fmt::print("{}", table.text());
}

/// No scene that rounds would have caught it.
bool only_where_exact(const Trial& trial, const std::vector<TrialScene>& scenes) {
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (trial.seen[i] && trial.seen[i]->verdict == Verdict::disagree && !scenes[i].scene.exact) {
      return false;
    }
  }
  return trial.planted.expected == Expected::disagree && trial.caught();
}

/// Prints how many were caught. Whether all went as expected.
bool print_sum(const std::vector<Trial>& trials, const std::vector<TrialScene>& scenes) {
  const auto count = [&](Expected expected, bool only_good) {
    return std::ranges::count_if(trials, [&](const Trial& trial) {
      const bool judged = trial.ran() || !trial.as_expected();
      return trial.planted.expected == expected && judged && (trial.as_expected() || !only_good);
    });
  };
  fmt::print("\n{} of {} planted faults caught, {} of {} controls let through\n",
             count(Expected::disagree, true), count(Expected::disagree, false),
             count(Expected::let_through, true), count(Expected::let_through, false));
  const auto exact =
      std::ranges::count_if(trials, [&](const Trial& trial) { return only_where_exact(trial, scenes); });
  if (exact > 0) {
    fmt::print("{} of the faults only where every number is exact: elsewhere a near-tie would excuse them\n",
               exact);
  }
  return std::ranges::all_of(trials, &Trial::as_expected);
}

/// `list`: what is planted. `asleep`: in place of the small scene of sleeping tiles, where given. `speaks`:
/// shows progress.
int try_faults(const Arguments& arguments, const std::vector<Planted>& list, const Backend& reference,
               const std::string& line, const std::optional<Scene>& asleep = {}, bool speaks = true) {
  if (arguments.list) {
    print_list(list);
    return success;
  }
  require_results_writable(arguments.json);
  std::vector<TrialScene> scenes = faults::trial_scenes(
      arguments.scenes, arguments.size.empty() ? std::nullopt : std::optional(parse_size(arguments.size)));
  for (TrialScene& scene : scenes) {
    if (scene.tiles_sleep && asleep) {
      scene.label = asleep->name;
      scene.scene = *asleep;
    }
  }
  Progress progress(speaks);
  std::ptrdiff_t total = 0;
  for (const Planted& planted : list) {
    total += std::ranges::count_if(scenes, [&](const TrialScene& scene) { return concerns(planted, scene); });
  }
  progress.set_total(static_cast<double>(total));

  std::vector<Trial> trials;
  nlohmann::json rows = nlohmann::json::array();
  for (const Planted& planted : list) {
    trials.push_back(faults::try_out(planted, reference, scenes, progress));
    rows.push_back(json_row(trials.back(), scenes));
  }
  progress.clear();

  print_table(trials, scenes, arguments.brief);
  const bool good = print_sum(trials, scenes);
  explain(trials);
  write_results(arguments.json, "faults", run_context(line, false), std::move(rows));
  return good ? success : disagreement;
}

int run_faults(const Arguments& arguments, const std::string& line) {
  const auto registry = make_backends();
  const Backend& carrier = find_backend(registry, arguments.backend);
  return try_faults(arguments, chosen(arguments.faults, faults::all_planted(carrier)), *registry.front(),
                    line);
}

/// What ranks tell each other, with a mistake.
int run_faults_on_ranks(Arguments arguments, const std::string& line, Ranks& ranks) {
  if (!ranks.is_first()) { // results are the first one's to write
    arguments.json.clear();
  }
  const auto registry = make_backends();
  const std::vector<Planted> list =
      chosen(arguments.faults, faults::planted_on_ranks(ranks, registry, arguments.backend));
  return try_faults(arguments, list, *registry.front(), line, sleeping_pieces(ranks.size()),
                    ranks.is_first());
}

} // namespace

void add_faults(const Command& program, const std::string& arguments, int& status, Ranks* ranks) {
  const Command command = program.add_subcommand(
      "faults",
      "Check the checker: plant mistakes into sessions, shaders and driver calls, one at a time, and "
      "see that verify\ndisagrees on one scene at least; and that it lets through what is no mistake.\n"
      "mpirun -n R hdmbench faults: mistakes in what ranks tell each other.\n"
      "Exit status 1 if a fault is caught nowhere, or a control is not let through.");
  const auto own = std::make_shared<Arguments>();
  command.add_option("scenes", own->scenes, "Scenes by name or TOML file (none: small ones made for this)");
  command.add_option("--faults", own->faults, "Faults and controls by name, with commas (none: all)")
      .delimiter(',');
  command.add_flag("--list", own->list, "Name the faults and stop");
  command.add_option("--size", own->size,
                     "Image size: 300 (square) or 257x130 (none: 48x40, 32 where exact)");
  command.add_option("--backend", own->backend, "Whose sessions make the sessions' mistakes")
      .capture_default_str();
  command.add_flag("--brief", own->brief, "Only what did not go as expected, and the sum");
  command.add_option("--json", own->json, "Write the results to this file");
  command.callback([own, command, arguments, &status, ranks] {
    refuse_idle(command, {{.here = own->list,
                           .options = {"scenes", "--size", "--brief", "--json"},
                           .why = "--list names the faults and stops"}});
    status = ranks != nullptr ? run_faults_on_ranks(*own, arguments, *ranks) : run_faults(*own, arguments);
  });
}

} // namespace hdmbench::commands
