#include "harness/report/accuracy_tables.hpp"
#include "harness/report/html.hpp"
#include "harness/report/joined.hpp"
#include "harness/report/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace hdmbench::report {

namespace {

struct Tally {
  std::set<std::string> scenes; ///< with a distance of ICM to FEM
  double nearest = HUGE_VAL;    ///< of those distances, pixels
  double farthest = 0.0;
  double worst_remainder = 0.0; ///< of the decompositions, px^2
  std::int64_t decompositions = 0;
  std::int64_t arithmetic_runs = 0;
  std::int64_t steps_compared = 0;
  std::int64_t beyond_bound = 0;
  std::int64_t wrong = 0;                       ///< rows whose field is there, but not valid
  std::map<std::string, std::int64_t> failures; ///< "gl-compute, icm on square: reason"
  std::set<std::string> out_of_bound;           ///< "gl-compute on square"
  std::int64_t compared_nothing = 0;            ///< arithmetic without a step
};

// The thesis's measure: over all sites, ICM as the scene says.
void add_distance(Tally& tally, const AccuracyRow& row) {
  const bool icm = row.method == "icm" || row.method == "sequential";
  if (icm && row.variant.empty() && row.to_fem_nu0.all) {
    tally.scenes.insert(row.scene);
    tally.nearest = std::min(tally.nearest, *row.to_fem_nu0.all);
    tally.farthest = std::max(tally.farthest, *row.to_fem_nu0.all);
  }
}

void add_failure(Tally& tally, const AccuracyRow& row) {
  const std::string name = row.backend.empty() ? row.method : row.method + " by " + row.backend;
  ++tally.failures[fmt::format("{}{} on {}: {}", name, row.variant.empty() ? "" : " (" + row.variant + ")",
                               row.scene, row.failure())];
  tally.wrong += row.status == "ok" || row.mean_energy || row.to_fem.all ? 1 : 0;
}

void add_arithmetic(Tally& tally, const AccuracyRow& row) {
  ++tally.arithmetic_runs;
  tally.steps_compared += row.arithmetic->steps_compared;
  tally.compared_nothing += row.arithmetic->steps_compared == 0 ? 1 : 0;
  tally.beyond_bound += row.arithmetic->beyond_bound;
  if (row.arithmetic->beyond_bound > 0) {
    tally.out_of_bound.insert(fmt::format("{} on {}", row.backend, row.scene));
  }
}

Tally tally_of(const std::vector<const AccuracyRow*>& rows) {
  Tally tally;
  for (const AccuracyRow* const row : rows) {
    if (row->failed()) {
      add_failure(tally, *row);
    } else {
      add_distance(tally, *row);
    }
    if (row->arithmetic) {
      add_arithmetic(tally, *row);
    }
    for (const Decomposition& parts : row->decompositions) {
      ++tally.decompositions;
      tally.worst_remainder = std::max(tally.worst_remainder, std::abs(parts.remainder));
    }
  }
  return tally;
}

std::string distances_sentence(const Tally& tally) {
  if (tally.scenes.empty()) {
    return "No distance of ICM to finite elements was measured.";
  }
  const std::string low = distance_text(tally.nearest);
  const std::string high = distance_text(tally.farthest);
  return fmt::format("ICM is {} px (RMSD) from finite elements with ν = 0 on {}.",
                     low == high ? low : low + " to " + high, plural(std::ssize(tally.scenes), "scene"));
}

void note_arithmetic(const Tally& tally, std::vector<std::string>& notes) {
  if (tally.beyond_bound > 0) {
    notes.push_back(fmt::format("float32 leaves the derived bound in {}: {}.",
                                plural(tally.beyond_bound, "step"), joined(tally.out_of_bound, ", ")));
  } else if (tally.steps_compared > 0) {
    notes.push_back(fmt::format("float32 stays within the derived bound in all {} of {}.",
                                plural(tally.steps_compared, "step"), plural(tally.arithmetic_runs, "run")));
  }
  if (tally.arithmetic_runs == 0) {
    notes.emplace_back("float32 was not compared with double.");
  } else if (tally.compared_nothing > 0) {
    notes.push_back(fmt::format("float32 was compared with double at no step in {}.",
                                plural(tally.compared_nothing, "run")));
  }
}

void note_failures(const Tally& tally, std::size_t rows, std::vector<std::string>& notes) {
  constexpr std::size_t shown = 6;
  std::vector<std::string> texts;
  std::int64_t count = 0;
  for (const auto& [text, times] : tally.failures) {
    count += times;
    if (texts.size() < shown) {
      texts.push_back(text);
    }
  }
  if (texts.empty()) {
    return;
  }
  const std::size_t hidden = tally.failures.size() - texts.size();
  notes.push_back(fmt::format("{} of {} failed: {}{}.", count_text(count),
                              plural(static_cast<std::int64_t>(rows), "result"), joined(texts, "; "),
                              hidden > 0 ? fmt::format("; and {} more", hidden) : ""));
}

} // namespace

std::optional<Summary> summarise_accuracy(const Results& results, const std::string& machine) {
  std::vector<const AccuracyRow*> rows;
  bool quick = false;
  for (const AccuracyRow& row : results.accuracy) {
    if (machine.empty() || results.machine_of(row.context) == machine) {
      rows.push_back(&row);
      quick = quick || results.contexts[row.context].quick;
    }
  }
  if (rows.empty()) {
    return std::nullopt;
  }
  const Tally tally = tally_of(rows);
  Summary summary;
  summary.sentence = distances_sentence(tally);
  if (tally.beyond_bound > 0 || tally.wrong > 0) {
    summary.state = Summary::State::bad;
  } else if (tally.failures.empty() && !tally.scenes.empty() && tally.arithmetic_runs > 0 &&
             tally.compared_nothing == 0) {
    summary.state = Summary::State::good;
  }
  note_failures(tally, rows.size(), summary.notes);
  note_arithmetic(tally, summary.notes);
  if (tally.decompositions > 0) {
    summary.notes.push_back(
        fmt::format("Model, optimisation and covariance add up to the whole error in {}; the worst "
                    "remainder is {:.1e} px².",
                    plural(tally.decompositions, "decomposition"), tally.worst_remainder));
  }
  if (quick) {
    summary.notes.emplace_back("Includes --quick runs, which do less than a full one.");
  }
  return summary;
}

} // namespace hdmbench::report
