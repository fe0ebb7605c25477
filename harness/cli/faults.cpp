#include "harness/check/faults/trial.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/ranks/rank_faults.hpp"

#include <set>

namespace hdmbench::commands {

namespace {

using faults::Planted;
using faults::TrialScene;

const Option<std::vector<std::string>> names("--faults",
                                             "Faults and controls by name, with commas (none: all)");
const Option<bool> brief("--brief", "Only what did not go as expected, and the sum");

/// Those that were named, or all. Throws InputError for a name that none has.
std::vector<Planted> chosen(const std::vector<std::string>& asked, std::vector<Planted> all) {
  for (const std::string& name : asked) {
    if (!contains(all, name, &Planted::name)) {
      throw InputError(fmt::format("there is no fault \"{}\"; hdmbench faults --list names them", name));
    }
  }
  std::erase_if(all,
                [&](const Planted& planted) { return !asked.empty() && !contains(asked, planted.name); });
  return all;
}

// Rows are as faults::try_out() has them.

/// What people are told of a fault in one word.
std::string outcome(const json& row) {
  if (row["not_planted"] != "") {
    return "NOT PLANTED";
  }
  if (!row["ran"] && row["as_expected"]) {
    return "not run";
  }
  const std::string yes = row["expected"] == "disagree" ? "yes" : "let through";
  const std::string no = row["expected"] == "disagree" ? "NO" : "NOT LET THROUGH";
  return row["as_expected"] ? yes : no;
}

/// Where verify disagreed; else the verdicts there were, each once.
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
std::set<std::string> reasons(const json& rows) {
  std::set<std::string> lines;
  for (const json& row : rows) {
    const std::string name = row_text("  {fault} on {backend}", row);
    if (row["not_planted"] != "") {
      lines.insert(name + row_text(" is not planted: {not_planted}\n", row));
    }
    for (const json& seen : row["scenes"]) {
      if (seen["verdict"] == "error") {
        lines.insert(name + row_text(": {reason}\n", seen));
      } else if (seen["verdict"] == name_of(Verdict::skipped) && seen["reason"] != "") {
        lines.insert(row_text("  {backend}", row) + row_text(" is skipped: {reason}\n", seen));
      } else if (seen["verdict"] == name_of(Verdict::mistrusted) && !row["as_expected"]) {
        lines.insert(name + row_text(": mistrusted: {reason}\n", seen));
      }
    }
  }
  return lines;
}

/// How many were caught, and how many only where every number is exact.
void print_sum(const json& rows) {
  const auto count = [&](std::string_view expected, bool only_good) {
    return std::ranges::count_if(rows, [&](const json& row) {
      const bool is_good = row["as_expected"];
      return row["expected"] == expected && (is_good ? row["ran"].get<bool>() : !only_good);
    });
  };
  fmt::print("\n{} of {} planted faults caught, {} of {} controls let through\n", count("disagree", true),
             count("disagree", false), count("let through", true), count("let through", false));
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
int try_faults(const Call& call, const std::vector<Planted>& list, const Backend& reference,
               const std::optional<Scene>& asleep = {}) {
  if (call[option::list]) {
    json rows = json::array();
    for (const Planted& planted : list) {
      rows.push_back({{"fault", planted.name}, {"planted_on", planted.backend}, {"what", planted.what}});
    }
    fmt::print("{}", table_text(rows, "fault|planted_on|what"));
    return success;
  }
  std::vector<TrialScene> scenes =
      faults::trial_scenes(call[option::scenes], parse_any_size(call[option::size]));
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

  json rows = json::array();
  json shown = json::array();
  for (const Planted& planted : list) {
    const json& row = rows.emplace_back(faults::try_out(planted, reference, scenes, progress));
    if (!call[brief] || !row["as_expected"]) {
      shown.push_back(row);
      shown.back().update({{"seen", seen_on(row)}, {"caught", outcome(row)}});
    }
    call.keep(rows);
  }
  progress.clear();
  if (!shown.empty()) {
    fmt::print("{}", table_text(shown, "fault|backend:planted on|layer|seen:verify disagrees on|caught"));
  }
  print_sum(rows);
  for (const std::string& reason : reasons(rows)) {
    fmt::print("{}", reason);
  }
  const bool good = std::ranges::all_of(rows, [](const json& row) { return row["as_expected"].get<bool>(); });
  const bool any = std::ranges::any_of(rows, [](const json& row) { return row["ran"].get<bool>(); });
  call.write(std::move(rows));
  return ended(call, good,
               any ? ""
                   : "no fault was tried, so nothing is known of verify: none concerns these scenes, or "
                     "what it is planted in is not there");
}

/// In one process what is computed has the mistakes, on ranks what they tell each other.
int run_faults(Call& call) {
  const auto registry = make_backends();
  if (call.ranks == nullptr) {
    const Backend& carrier = find_backend(registry, call[option::backend]);
    return try_faults(call, chosen(call[names], faults::all_planted(carrier)), *registry.front());
  }
  return try_faults(
      call, chosen(call[names], faults::planted_on_ranks(*call.ranks, registry, call[option::backend])),
      *registry.front(), sleeping_pieces(call.ranks->size()));
}

} // namespace

void add_faults(CLI::App& program, Call& call) {
  add_command(program, call, "faults", run_faults,
              "Plant mistakes: does verify see each of them?\n"
              "Check the checker: plant mistakes into sessions, shaders and driver calls, one at a time, and "
              "see that verify\n"
              "disagrees on one scene at least; and that it lets through what is no mistake.\n"
              "mpirun -n R hdmbench faults: mistakes in what ranks tell each other.\n"
              "Exit status 1 if a fault is caught nowhere, or a control is not let through.",
              {Options(option::list, "Name the faults and stop"),
               Options(option::scenes, "Scenes by name or TOML file (none: small ones made for this)"), names,
               Options(option::size, "Image size: 300 (square) or 257x130 (none: 48x40, 32 where exact)"),
               Options(option::backend, "Whose sessions make the sessions' mistakes", "scalar"), brief,
               option::json},
              {"--list excludes scenes --size --brief --json"});
}

} // namespace hdmbench::commands
