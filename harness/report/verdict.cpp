#include "harness/report/verdict.hpp"

#include "harness/report/table.hpp"
#include "harness/scene/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <set>

namespace hdmbench::report {

namespace {

using nlohmann::json;
using Names = std::set<std::string>;
using Findings = std::vector<Finding>;
using Holds = bool (*)(const json& row);

std::string plural(std::int64_t count, std::string_view noun) {
  return fmt::format("{} {}{}", grouped(count), noun, count == 1 ? "" : "s");
}

/// The first few names, and how many more there are.
std::string few(const Names& names) {
  constexpr std::ptrdiff_t most = 6;
  const auto end = std::next(names.begin(), std::min(most, std::ssize(names)));
  return joined(Names(names.begin(), end), "; ") +
         (std::ssize(names) > most ? fmt::format("; and {} more", std::ssize(names) - most) : "");
}

// How a row is named.

std::string on_scene(const json& row) {
  const std::string backend = text_of(row, "backend");
  return (backend.empty() ? text_of(row, "method") : backend) + " on " + text_of(row, "scene");
}
std::string method_on_scene(const json& row) {
  return (text_of(row, "backend").empty() ? "" : text_of(row, "method") + " by ") + on_scene(row) + ", " +
         size_of(row);
}
std::string request(const json& row) {
  return fmt::format("{} px asked, {:.3g} px reached by {}", number_of(row, "asked").value_or(0.0),
                     asked_error(row).value_or(0.0), method_on_scene(row));
}
std::string on_driver(const json& row) {
  return fmt::format("{} on {} ({})", text_of(row, "backend"), text_of(row, "implementation"),
                     text_of(row, "outcome"));
}
std::string for_gpu(const json& row) {
  return fmt::format("{}, {}, for {}", text_of(row, "text"), text_of(row, "kernel"), text_of(row, "target"));
}
std::string on_backend(const json& row) {
  return text_of(row, row.contains("fault") ? "fault" : "kind") + " on " + text_of(row, "backend");
}

// What holds of a row.

bool says(const json& row, std::string_view key, std::string_view value) {
  return text_of(row, key) == value;
}
bool is_mistrusted(const json& row) {
  return says(row, "verdict", "mistrusted");
}
bool is_ours(const json& row) {
  return !text_of(row, "backend").empty();
}
bool misses(const json& row) {
  const auto asked = number_of(row, "asked");
  return asked && asked_error(row).value_or(0.0) > *asked;
}
bool misses_and_says_so(const json& row) {
  return misses(row) && number_of(row, "estimated_error").value_or(0.0) > *number_of(row, "asked");
}
bool fault_ran(const json& row) {
  return row.contains("scenes") && std::ranges::any_of(row["scenes"], [](const json& scene) {
           return was_compared(scene) && !is_mistrusted(scene);
         });
}
bool is_missed(const json& row) { // also where a row contradicts itself
  const bool unseen =
      text_of(row, "expected") == "disagree" && fault_ran(row) && flag_of(row, "caught") == false;
  return unseen || !flag_of(row, "as_expected").value_or(false);
}
bool is_unclean(const json& row) {
  return row.contains("unclean") && !row["unclean"].empty();
}
bool has_seconds(const json& row) {
  return number_of(row, "seconds_median").value_or(0.0) > 0.0; // 0 where nothing was timed
}

/// A finding about the rows of a command of which something holds: "3 of 9 <sentence>: <names>." Without a
/// function that names a row it ends after the sentence.
struct Check {
  State state;
  std::string_view command;
  Holds holds;
  std::string (*name)(const json& row);
  std::string_view sentence;
};
using enum State;
constexpr std::array checks{
    Check{bad, "verify", disagrees, on_scene, "comparisons disagree with scalar"},
    Check{unsure, "verify", is_mistrusted, on_scene, "comparisons cannot be trusted"},
    Check{bad, "golden",
          [](const json& row) {
            return says(row, "verdict", "disagree") ||
                   (says(row, "verdict", "agree") && number_of(row, "first_difference"));
          },
          on_scene, "solutions have not the golden hashes"},
    Check{unsure, "golden", is_mistrusted, on_scene,
          "solutions have scalar's bits, but there are no golden hashes to compare with"},
    Check{bad, "implementations", [](const json& row) { return says(row, "outcome", "failed"); }, on_driver,
          "backends on other drivers disagree"},
    Check{unsure, "implementations",
          [](const json& row) { return !says(row, "outcome", "failed") && !says(row, "outcome", "passed"); },
          on_driver, "backends on other drivers gave no answer"},
    Check{bad, "machine-code", [](const json& row) { return says(row, "verdict", "fused"); }, for_gpu,
          "programs for GPUs have fused operations"},
    Check{unsure, "machine-code",
          [](const json& row) {
            return !says(row, "verdict", "fused") && !says(row, "verdict", "no fused operation");
          },
          for_gpu, "programs for GPUs were not compiled"},
    Check{bad, "faults", is_missed, on_backend,
          "planted faults and controls came out otherwise than expected"},
    Check{unsure, "faults", [](const json& row) { return !is_missed(row) && !fault_ran(row); }, on_backend,
          "planted faults were not run"},
    Check{bad, "failing-calls", is_unclean, on_backend, "kinds of failing calls of drivers end unclean"},
    Check{bad, "judged",
          [](const json& row) {
            return is_ours(row) && says(row, "status", "ok") && !flag_of(row, "valid").value_or(false);
          },
          method_on_scene, "fields are not finite, or not scalar's"},
    Check{unsure, "judged",
          [](const json& row) {
            return is_ours(row) && !says(row, "status", "ok") &&
                   !text_of(row, "status").starts_with("skipped");
          },
          method_on_scene, "fields could not be judged"},
    Check{good, "judged", [](const json& row) { return !is_ours(row) && !says(row, "status", "ok"); },
          method_on_scene, "points have no result, of other solvers"},
    Check{bad, "judged", [](const json& row) { return misses(row) && !misses_and_says_so(row); }, request,
          "points miss the accuracy that was asked for and estimated"},
    Check{unsure, "judged", misses_and_says_so, request,
          "points miss the accuracy that was asked for, and say so"},
    Check{unsure, "run", [](const json& row) { return !flag_of(row, "plan.met").value_or(true); },
          method_on_scene, "runs do not reach what was asked for"},
    Check{bad, "bench", [](const json& row) { return flag_of(row, "valid") == false && has_seconds(row); },
          method_on_scene, "timings belong to a field that is not scalar's"},
    Check{unsure, "bench",
          [](const json& row) { return flag_of(row, "valid") == false && !has_seconds(row); },
          method_on_scene, "timings have no result"},
    Check{good, "golden", [](const json& row) { return says(row, "verdict", "agree"); }, nullptr,
          "solutions have the hashes that are committed with the program"},
    Check{good, "implementations", [](const json& row) { return says(row, "outcome", "passed"); }, nullptr,
          "backends on other drivers agree with scalar, too"},
    Check{good, "machine-code", [](const json& row) { return says(row, "verdict", "no fused operation"); },
          nullptr, "programs for GPUs that are not there have no fused operation"},
    Check{good, "faults", [](const json& row) { return !is_missed(row) && fault_ran(row); }, nullptr,
          "planted faults and controls came out as expected"},
    Check{good, "failing-calls", [](const json& row) { return !is_unclean(row); }, nullptr,
          "kinds of failing calls of drivers ended clean"},
    Check{good, "bench", [](const json& row) { return has_seconds(row) && !flag_of(row, "valid"); }, nullptr,
          "timings were not checked against scalar, so no speed-up is printed"}};

/// Returns the backends of several rows that are all among `some`.
Names whole_backends(const Rows& rows, const Rows& some) {
  Names whole;
  for (const json* const row : some) {
    const std::string backend = text_of(*row, "backend");
    const auto is_its_own = [&](const json* other) { return text_of(*other, "backend") == backend; };
    const auto count = std::ranges::count_if(some, is_its_own);
    if (!backend.empty() && count > 1 && count == std::ranges::count_if(rows, is_its_own)) {
      whole.insert(backend);
    }
  }
  return whole;
}

/// Adds to the findings what holds of `rows` by the checks of this command.
void find(Findings& findings, std::string_view command, const Rows& rows) {
  for (const Check& check : checks) {
    const Rows found = check.command == command ? rows_where(rows, check.holds) : Rows();
    const Names whole = command == "bench" ? whole_backends(rows, found) : Names();
    Names names;
    for (const json* const row : check.name == nullptr ? Rows() : found) {
      const std::string backend = text_of(*row, "backend");
      names.insert(whole.contains(backend) ? "all of " + backend : check.name(*row));
    }
    if (!found.empty()) {
      findings.push_back(
          {check.state, fmt::format("{} of {} {}{}{}.", grouped(std::ssize(found)), grouped(std::ssize(rows)),
                                    check.sentence, names.empty() ? "" : ": ", few(names))});
    }
  }
}

/// Backends on scenes where nothing at all was compared; that one mode or method of several does not apply is
/// no concern.
void find_skipped(Findings& findings, const Rows& rows, std::string_view what) {
  Names compared;
  for (const json* const row : rows) {
    if (was_compared(*row)) {
      compared.insert(on_scene(*row));
    }
  }
  const Rows skipped = rows_where(rows, [](const json& row) { return !was_compared(row); });
  const Names whole = whole_backends(rows, skipped);
  std::map<std::string, Names> by_reason;
  std::int64_t not_applying = 0;
  for (const json* const row : skipped) {
    if (compared.contains(on_scene(*row))) {
      ++not_applying;
    } else {
      const std::string reason = text_of(*row, "reason");
      const std::string backend = text_of(*row, "backend");
      by_reason[reason.empty() ? "no reason is given" : reason].insert(
          whole.contains(backend) ? "all of " + backend : on_scene(*row));
    }
  }
  for (const auto& [reason, places] : by_reason) {
    findings.push_back({unsure, fmt::format("Skipped, so not checked: {} ({}).", few(places), reason)});
  }
  if (not_applying > 0) {
    findings.push_back({good, fmt::format("{} {} not apply to the backend or the scene.",
                                          plural(not_applying, what), not_applying == 1 ? "does" : "do")});
  }
}

/// The backends that the machine has not, by `devices`, each with the reason.
using Absent = std::map<std::string, std::string>;

Absent absent_backends(const Results& results, std::string_view machine) {
  Absent absent;
  for (const json* const device : rows_of(results, "devices", machine)) {
    if (flag_of(*device, "available") == false) {
      absent.emplace(text_of(*device, "backend"), text_of(*device, "reason"));
    }
  }
  return absent;
}

/// Without what could not be done on those; anything that was done stays.
Rows on_present(const Rows& rows, const Absent& absent) {
  return rows_where(rows, [&](const json& row) {
    return !absent.contains(text_of(row, "backend")) || was_compared(row) || has_seconds(row);
  });
}

/// Ends the sentence of what agrees: a backend that is not there is not among it.
std::string end_of(const Absent& absent) {
  Names names;
  for (const auto& [backend, reason] : absent) {
    names.insert(reason.empty() ? backend : fmt::format("{} ({})", backend, reason));
  }
  return names.empty() ? "" : fmt::format("; not there, so not checked: {}", joined(names, ", "));
}

/// What rewrites of the arithmetic, or none, make of the bits that differ.
void find_causes(Findings& findings, const Rows& compared) {
  struct Cause {
    Names places;
    State state = good;
  };
  std::map<std::string, Cause> causes;
  for (const json* const row : compared) {
    std::string why = text_of(*row, "why");
    if (!why.empty()) {
      for (const std::string_view before_numbers : {": that makes all", " of the arithmetic makes what"}) {
        why.resize(std::min(why.find(before_numbers), why.size())); // of sites, which are others each time
      }
      Cause& cause = causes[why];
      cause.places.insert(on_scene(*row));
      cause.state = disagrees(*row) ? unsure : cause.state;
    }
  }
  for (const auto& [why, cause] : causes) {
    findings.push_back({cause.state, fmt::format("Why bits differ: {} ({}).", why, few(cause.places))});
  }
}

void find_in_verify(Findings& findings, const Results& results, std::string_view machine,
                    const Absent& absent) {
  const Rows rows = on_present(rows_of(results, "verify", machine), absent);
  const Rows compared = rows_where(rows, was_compared);
  find(findings, "verify", compared);
  find_causes(findings, compared);
  const std::int64_t agree = std::ssize(compared) - count_where(compared, [](const json& row) {
                               return disagrees(row) || is_mistrusted(row);
                             });
  Names backends;
  for (const json* const row : compared) {
    backends.insert(text_of(*row, "backend"));
  }
  const Rows timed = rows_of(results, "bench", machine);
  const std::int64_t checked = count_where(timed, is_checked);
  if (rows.empty() && checked > 0) {
    findings.push_back(
        {good, fmt::format("The fields of {} are scalar's to the last bit. Sweep by sweep nothing was "
                           "compared: there are no results of hdmbench verify.",
                           plural(checked, "timed solution"))});
  } else if (compared.empty()) {
    findings.push_back(
        {unsure, rows.empty() ? "Nothing was compared with scalar: there are no results of hdmbench verify."
                              : "Nothing was compared with scalar: all comparisons were skipped."});
  } else if (agree == std::ssize(compared)) {
    const std::int64_t certified =
        count_where(compared, [](const json& row) { return says(row, "verdict", "certified"); });
    findings.push_back(
        {good,
         fmt::format("{} with scalar in {} of {}, {}{}.",
                     backends.size() == 1 ? *backends.begin() + " agrees"
                                          : fmt::format("All {} backends agree", backends.size()),
                     grouped(agree), plural(std::ssize(compared), "comparison"),
                     certified == 0 ? "to the last bit"
                                    : fmt::format("in {} of them with each difference certified as rounding",
                                                  grouped(certified)),
                     end_of(absent))});
  } else if (agree > 0) {
    findings.push_back({good, fmt::format("{} of {} agree with scalar{}.", grouped(agree),
                                          plural(std::ssize(compared), "comparison"), end_of(absent))});
  }
  find_skipped(findings, rows, "comparison");
  for (const json* const device : rows_of(results, "devices", machine)) {
    const std::string backend = text_of(*device, "backend");
    const auto is_its_own = [&](const json* row) { return says(*row, "backend", backend); };
    const bool is_named =
        std::ranges::any_of(rows, is_its_own) ||
        count_where(rows_where(timed, [&](const json& row) { return is_its_own(&row); }), is_checked) > 0;
    if (!is_named && backend != "scalar" && (compared.empty() || !absent.contains(backend))) {
      const std::string reason = text_of(*device, "reason");
      findings.push_back(
          {unsure, fmt::format("{} was not compared{}.", backend, reason.empty() ? "" : ": " + reason)});
    }
  }
}

} // namespace

Verdict verdict_of(const Results& results, std::string_view machine) {
  Findings findings;
  const Absent absent = absent_backends(results, machine);
  find_in_verify(findings, results, machine, absent);
  for (const char* const command : {"golden", "implementations", "machine-code", "faults", "failing-calls",
                                    "accuracy", "tradeoff", "run", "bench"}) {
    const Rows all = rows_of(results, command, machine);
    const bool is_on_backends = command == std::string_view("bench") || command == std::string_view("golden");
    const Rows rows = rows_where(is_on_backends ? on_present(all, absent) : all, [](const json& row) {
      const bool is_no_other_driver =
          says(row, "outcome", "absent") ||
          (says(row, "implementation", "as installed") && says(row, "outcome", "passed"));
      return !says(row, "kind", "equal accuracy") && !is_no_other_driver;
    });
    if (command == std::string_view("golden")) {
      find(findings, command, rows_where(rows, was_compared));
      continue;
    }
    const bool is_judged = command == std::string_view("accuracy") || command == std::string_view("tradeoff");
    find(findings, is_judged ? "judged" : command, rows);
  }
  find_skipped(findings, on_present(rows_of(results, "golden", machine), absent), "golden solution");
  if (std::ranges::any_of(results, [&](const Source& source) {
        return source.context.quick && (machine.empty() || source.context.machine == machine);
      })) {
    findings.push_back({good, "Some of it was measured with --quick, which does less than a full run."});
  }
  Names cut;
  for (const Source& source : results) {
    if (source.cut && (machine.empty() || source.context.machine == machine)) {
      cut.insert(source.file.filename().string());
    }
  }
  if (!cut.empty()) {
    findings.push_back(
        {unsure, fmt::format("Cut, because the command was ended before it had all rows: {}.", few(cut))});
  }
  Names told;
  std::erase_if(findings, [&](const Finding& finding) { return !told.insert(finding.sentence).second; });
  std::ranges::stable_sort(findings, std::ranges::greater(), &Finding::state);
  Verdict verdict{
      .state = findings.front().state, .sentence = findings.front().sentence, .notes = {}, .figures = {}};
  verdict.notes.assign(findings.begin() + 1, findings.end());
  verdict.figures = figures_of(results, machine);
  return verdict;
}

} // namespace hdmbench::report
