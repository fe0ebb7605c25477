#include "harness/judge/accuracy/accuracy.hpp"
#include "harness/report/accuracy_tables.hpp"
#include "harness/report/html.hpp"
#include "harness/report/verdict.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

namespace hdmbench::report {

namespace {

// RMSD of one field to finite elements with Poisson ratio 0, the thesis's measure.
struct Distance {
  double pixels = 0.0;
  std::string scene;
};

struct Tally {
  std::vector<Distance> distances;                    ///< of ICM as the scenes say, in place and simultaneous
  std::set<std::string> scenes;                       ///< of `distances`
  std::set<std::string> beside_interpolation;         ///< scenes where both have a distance
  std::set<std::string> no_better_than_interpolation; ///< of them
  double worst_remainder = 0.0;                       ///< of the decompositions, px^2
  std::int64_t decompositions = 0;
  std::int64_t arithmetic_runs = 0;
  std::int64_t steps_compared = 0;
  std::int64_t steps_differing = 0;
  std::int64_t beyond_bound = 0;
  std::int64_t compared_nothing = 0;  ///< runs of arithmetic without a step
  std::set<std::string> out_of_bound; ///< "gl-compute on square"
  std::int64_t wrong = 0;             ///< rows whose field is there, but not valid
  std::vector<std::string> failures;  ///< "icm by gl-compute on square: reason"
  std::vector<std::string> skipped;   ///< the same
};

void add_failure(Tally& tally, const AccuracyRow& row) {
  const std::string name = row.backend.empty() ? row.method : row.method + " by " + row.backend;
  const std::string variant = row.variant.empty() ? "" : " (" + row.variant + ")";
  (row.skipped() ? tally.skipped : tally.failures)
      .push_back(fmt::format("{}{} on {}: {}", name, variant, row.scene, row.failure()));
  const bool rival = row.method == registration_name; // its mistakes are its own
  tally.wrong += !rival && (row.status == "ok" || row.mean_energy || row.to_fem.all) ? 1 : 0;
}

void add_arithmetic(Tally& tally, const AccuracyRow& row) {
  ++tally.arithmetic_runs;
  const Arithmetic::Iterations& found = row.arithmetic->resynchronised;
  tally.steps_compared += found.steps_compared;
  tally.steps_differing += found.steps_differing;
  tally.compared_nothing += found.steps_compared == 0 ? 1 : 0;
  tally.beyond_bound += found.beyond_bound;
  if (found.beyond_bound > 0) {
    tally.out_of_bound.insert(fmt::format("{} on {}", row.backend, row.scene));
  }
}

void add_distances(Tally& tally, const AccuracyScene& scene) {
  const AccuracyRow* const interpolation = scene.find("interpolation");
  for (const char* const method : {"icm", "sequential"}) {
    const AccuracyRow* const row = scene.find(method);
    if (row == nullptr || !row->to_fem_nu0.all) {
      continue;
    }
    tally.distances.push_back({*row->to_fem_nu0.all, scene.scene});
    tally.scenes.insert(scene.scene);
    if (interpolation != nullptr && interpolation->to_fem_nu0.all) {
      tally.beside_interpolation.insert(scene.scene);
      if (*row->to_fem_nu0.all >= *interpolation->to_fem_nu0.all) {
        tally.no_better_than_interpolation.insert(scene.scene);
      }
    }
  }
}

Tally tally_of(const std::vector<AccuracyScene>& scenes) {
  Tally tally;
  for (const AccuracyScene& scene : scenes) {
    add_distances(tally, scene);
    for (const AccuracyRow* const row : scene.rows) {
      if (row->failed()) {
        add_failure(tally, *row);
      }
      if (row->arithmetic) {
        add_arithmetic(tally, *row);
      }
      for (const JudgedField::Split& split : row->decompositions) {
        ++tally.decompositions;
        tally.worst_remainder = std::max(tally.worst_remainder, std::abs(split.parts.remainder()));
      }
    }
  }
  return tally;
}

std::string distances_sentence(const Tally& tally) {
  if (tally.distances.empty()) {
    return "No distance of ICM to finite elements was measured.";
  }
  const auto [nearest, farthest] = std::ranges::minmax_element(tally.distances, {}, &Distance::pixels);
  if (tally.scenes.size() == 1) {
    const std::string low = distance_text(nearest->pixels);
    const std::string high = distance_text(farthest->pixels);
    return fmt::format("ICM is {} px (RMSD) from finite elements on {}.",
                       low == high ? low : low + " to " + high, nearest->scene);
  }
  return fmt::format("ICM is {} px ({}) to {} px ({}) from finite elements: RMSD on {}.",
                     distance_text(nearest->pixels), nearest->scene, distance_text(farthest->pixels),
                     farthest->scene, plural(std::ssize(tally.scenes), "scene"));
}

void note_interpolation(const Tally& tally, std::vector<std::string>& notes) {
  if (tally.beside_interpolation.empty()) {
    return;
  }
  const auto better = tally.beside_interpolation.size() - tally.no_better_than_interpolation.size();
  notes.push_back(
      fmt::format("ICM is nearer to FEM than interpolation, which knows no material, on {} of {}{}.", better,
                  plural(std::ssize(tally.beside_interpolation), "scene"),
                  tally.no_better_than_interpolation.empty()
                      ? ""
                      : "; not on " + joined(tally.no_better_than_interpolation, ", ")));
}

void note_arithmetic(const Tally& tally, std::vector<std::string>& notes) {
  const std::string where =
      fmt::format("{} of {}", plural(tally.steps_compared, "step"), plural(tally.arithmetic_runs, "run"));
  if (tally.steps_compared > 0 && tally.steps_differing == 0) {
    notes.push_back(fmt::format("float32 chose as double does in all {}.", where));
  } else if (tally.steps_compared > 0 && tally.beyond_bound == 0) {
    notes.push_back(
        fmt::format("float32 chose otherwise than double in {} of {}, each a near-tie within the derived "
                    "bound.",
                    count_text(tally.steps_differing), where));
  }
  if (tally.arithmetic_runs == 0) {
    notes.emplace_back("float32 was not compared with double.");
  } else if (tally.compared_nothing > 0) {
    notes.push_back(fmt::format("float32 was compared with double at no step in {}.",
                                plural(tally.compared_nothing, "run")));
  }
}

// The first few by name.
std::string list(const std::string& start, const std::vector<std::string>& texts) {
  constexpr std::size_t most = 6;
  const std::size_t count = std::min(most, texts.size());
  const std::vector<std::string> shown(texts.begin(), texts.begin() + static_cast<std::ptrdiff_t>(count));
  return fmt::format("{}: {}{}.", start, joined(shown, "; "),
                     texts.size() > count ? fmt::format("; and {} more", texts.size() - count) : "");
}

// What is wrong, one text each; empty where nothing is.
std::vector<std::string> faults(const Tally& tally, std::int64_t rows) {
  std::vector<std::string> texts;
  if (tally.beyond_bound > 0) {
    texts.push_back(fmt::format("float32 leaves the derived bound in {}: {}.",
                                plural(tally.beyond_bound, "step"), joined(tally.out_of_bound, ", ")));
  }
  if (!tally.failures.empty()) {
    texts.push_back(
        list(fmt::format("{} of {} failed", count_text(std::ssize(tally.failures)), plural(rows, "result")),
             tally.failures));
  }
  return texts;
}

} // namespace

std::optional<Summary> summarise_accuracy(const Results& results, const std::string& machine) {
  std::vector<AccuracyScene> scenes;
  std::int64_t rows = 0;
  bool quick = false;
  for (const std::string& name : results.machines) {
    if (machine.empty() || name == machine) {
      std::ranges::move(accuracy_scenes(results, name), std::back_inserter(scenes));
    }
  }
  for (const AccuracyScene& scene : scenes) {
    rows += std::ssize(scene.rows);
    quick = quick || std::ranges::any_of(scene.rows, [&](const AccuracyRow* row) {
              return results.sources[row->source].quick;
            });
  }
  if (rows == 0) {
    return std::nullopt;
  }
  const Tally tally = tally_of(scenes);
  Summary summary;
  summary.notes = faults(tally, rows);
  summary.notes.push_back(distances_sentence(tally));
  summary.sentence = summary.notes.front(); // what is wrong comes first
  summary.notes.erase(summary.notes.begin());
  if (tally.beyond_bound > 0 || tally.wrong > 0) {
    summary.state = Summary::State::bad;
  } else if (tally.failures.empty() && !tally.distances.empty() && tally.arithmetic_runs > 0 &&
             tally.compared_nothing == 0) {
    summary.state = Summary::State::good;
  }
  note_interpolation(tally, summary.notes);
  note_arithmetic(tally, summary.notes);
  if (tally.decompositions > 0) {
    summary.notes.push_back(
        fmt::format("Model, optimisation and covariance add up to the whole error in {}; the worst "
                    "remainder is {:.1e} px².",
                    plural(tally.decompositions, "decomposition"), tally.worst_remainder));
  }
  if (!tally.skipped.empty()) {
    summary.notes.push_back(list("Skipped, so not judged", tally.skipped));
  }
  if (quick) {
    summary.notes.emplace_back("Includes --quick runs, which do less than a full one.");
  }
  return summary;
}

} // namespace hdmbench::report
