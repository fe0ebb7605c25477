#include "harness/report/verdict.hpp"

#include "harness/report/html.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace hdmbench::report {

namespace {

using Names = std::set<std::string>;

std::string machine_phrase(std::size_t machines) {
  return machines == 1 ? "on this machine" : fmt::format("on {} machines", machines);
}

// "gl-fragment on square, circular; vulkan-compute on brain"
std::string where(const std::vector<VerifyRow>& rows, Verdict verdict) {
  std::map<std::string, Names> scenes_of;
  for (const VerifyRow& row : rows) {
    if (row.verdict == verdict) {
      scenes_of[row.backend].insert(row.scene);
    }
  }
  std::vector<std::string> parts;
  parts.reserve(scenes_of.size());
  for (const auto& [backend, scenes] : scenes_of) {
    parts.push_back(fmt::format("{} on {}", backend, joined(scenes, ", ")));
  }
  return joined(parts, "; ");
}

std::string backends_phrase(const Names& backends, bool some_are_missing) {
  if (backends.size() == 1) {
    return fmt::format("The one backend that was compared, {},", *backends.begin());
  }
  return fmt::format("All {} backends{}", backends.size(), some_are_missing ? " that were compared" : "");
}

// One note per reason.
void note_skipped(const Results& results, const std::vector<VerifyRow>& rows, std::size_t machines,
                  std::vector<std::string>& notes) {
  struct Skipped {
    Names backends;
    std::int64_t count = 0;
  };
  std::map<std::string, Skipped> by_reason;
  for (const VerifyRow& row : rows) {
    if (row.verdict == Verdict::skipped) {
      const std::string place = machines > 1 ? " on " + results.machine_of(row) : "";
      Skipped& skipped = by_reason[row.reason];
      skipped.backends.insert(row.backend + place);
      ++skipped.count;
    }
  }
  for (const auto& [reason, skipped] : by_reason) {
    notes.push_back(fmt::format("Skipped, so not checked: {}, {}{}", joined(skipped.backends, ", "),
                                plural(skipped.count, "comparison"),
                                reason.empty() ? "." : fmt::format(" ({}).", reason)));
  }
}

void note_mistrusted(const std::vector<VerifyRow>& rows, std::vector<std::string>& notes) {
  std::map<std::pair<std::string, std::string>, std::int64_t> counts;
  for (const VerifyRow& row : rows) {
    if (row.verdict == Verdict::mistrusted) {
      ++counts[{row.scene, row.reason}];
    }
  }
  for (const auto& [key, count] : counts) {
    notes.push_back(fmt::format("Mistrusted, so not counted as agreement: {}, {}{}", key.first,
                                plural(count, "comparison"),
                                key.second.empty() ? "." : fmt::format(" ({}).", key.second)));
  }
}

// Backends that a machine lists but no verify row mentions.
void note_never_compared(const Results& results, const std::vector<VerifyRow>& rows,
                         const std::string& machine, std::vector<std::string>& notes) {
  Names missing;
  for (const DeviceRow& device : results.devices) {
    const std::string& place = results.machine_of(device);
    const bool listed = machine.empty() || place == machine;
    const bool compared = std::ranges::any_of(rows, [&](const VerifyRow& row) {
      return row.backend == device.backend && results.machine_of(row) == place;
    });
    if (listed && !compared && device.backend != "scalar") {
      missing.insert(machine.empty() && results.machines.size() > 1 ? device.backend + " on " + place
                                                                    : device.backend);
    }
  }
  if (!missing.empty()) {
    notes.push_back(fmt::format("Never compared: {}.", joined(missing, ", ")));
  }
}

std::int64_t count(const std::vector<VerifyRow>& rows, Verdict verdict) {
  return std::ranges::count(rows, verdict, &VerifyRow::verdict);
}

} // namespace

Summary summarise(const Results& results, const std::string& machine) {
  const std::vector<VerifyRow> rows = machine.empty() ? results.verify : results.of(results.verify, machine);
  Summary summary;
  if (rows.empty()) {
    summary.sentence = "Nothing was cross-checked: there are no results of hdmbench verify.";
    return summary;
  }

  Names backends;
  Names machines;
  for (const VerifyRow& row : rows) {
    machines.insert(results.machine_of(row));
    if (row.verdict != Verdict::skipped) {
      backends.insert(row.backend);
    }
  }
  const std::int64_t agree = count(rows, Verdict::agree);
  const std::int64_t certified = count(rows, Verdict::certified);
  const std::int64_t disagree = count(rows, Verdict::disagree);
  const std::int64_t mistrusted = count(rows, Verdict::mistrusted);
  const std::int64_t skipped = count(rows, Verdict::skipped);
  const std::int64_t compared = std::ssize(rows) - skipped;

  note_mistrusted(rows, summary.notes);
  note_skipped(results, rows, machines.size(), summary.notes);
  note_never_compared(results, rows, machine, summary.notes);

  if (disagree > 0) {
    summary.state = Summary::State::bad;
    summary.sentence = fmt::format("{} of {} {} with scalar {}: {}.", count_text(disagree),
                                   plural(compared, "comparison"), disagree == 1 ? "disagrees" : "disagree",
                                   machine_phrase(machines.size()), where(rows, Verdict::disagree));
  } else if (compared == 0) {
    summary.sentence =
        fmt::format("Nothing was cross-checked: {} skipped.",
                    skipped == 1 ? "the only comparison was"
                                 : fmt::format("all {} comparisons were", count_text(skipped)));
  } else if (mistrusted > 0) {
    summary.sentence = fmt::format("No comparison disagrees {}, but {} of {} cannot be trusted: {}.",
                                   machine_phrase(machines.size()), count_text(mistrusted),
                                   count_text(compared), where(rows, Verdict::mistrusted));
  } else {
    summary.state = Summary::State::good;
    const bool some_are_missing = !summary.notes.empty();
    const std::string detail =
        certified == 0
            ? fmt::format("to the last bit in {} of {}", count_text(agree), plural(compared, "comparison"))
            : fmt::format("in {} of {}, {} to the last bit and {} with every difference a certified near-tie",
                          count_text(agree + certified), plural(compared, "comparison"), count_text(agree),
                          count_text(certified));
    summary.sentence =
        fmt::format("{} {} {} with scalar {}.", backends_phrase(backends, some_are_missing),
                    machine_phrase(machines.size()), backends.size() == 1 ? "agrees" : "agree", detail);
  }
  if (summary.state != Summary::State::good && agree + certified > 0) {
    summary.notes.insert(summary.notes.begin(), fmt::format("{} of {} {}.", count_text(agree + certified),
                                                            plural(compared, "comparison"),
                                                            agree + certified == 1 ? "agrees" : "agree"));
  }
  if (std::ranges::any_of(rows, [&](const VerifyRow& row) { return results.sources[row.source].quick; })) {
    summary.notes.emplace_back("Includes --quick runs, which do less than a full one.");
  }
  return summary;
}

} // namespace hdmbench::report
