#include "harness/cli/verify_text.hpp"

#include "harness/check/verify_row.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/joined.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::commands {

namespace {

/// For all modes of a backend, where nothing needs to be told apart, or for one.
void explain(const Comparison& comparison, std::string_view modes) {
  fmt::print("  {}{}: {}", comparison.backend, modes, name_of(comparison.verdict));
  if (comparison.verdict == Verdict::certified) {
    fmt::print(": {} differing site{} within the bound of rounding, the nearest to it at {:.2g} of the bound",
               grouped(comparison.certified_ties), comparison.certified_ties == 1 ? "" : "s",
               comparison.largest_gap_over_bound);
  }
  fmt::print("{}{}\n", comparison.reason.empty() ? "" : ": ", comparison.reason);
}

void explain_disagreement(const Scene& scene, const Comparison& comparison,
                          const CommonArguments& arguments) {
  if (comparison.not_finite > 0) {
    fmt::print("    {} sites are NaN or infinite\n", grouped(comparison.not_finite));
  }
  if (comparison.uncertified > 0) {
    fmt::print("    {} of {} differing sites are not explained by rounding\n",
               grouped(comparison.uncertified), grouped(comparison.sites_differing));
  }
  if (comparison.first) {
    const FirstDifference& first = *comparison.first;
    const std::string when = first.step.empty() ? fmt::format("iteration {}", first.iteration)
                                                : fmt::format("step {}, {}", first.iteration, first.step);
    fmt::print("    first: level {}, {}, x = {}, y = {}: expected ({}, {}), found ({}, {})\n", first.level,
               when, first.x, first.y, first.expected[0], first.expected[1], first.found[0], first.found[1]);
    if (first.step.empty() && !std::isnan(first.energy_before)) {
      fmt::print("    energy of that site (double): {} before, {} expected, {} found\n", first.energy_before,
                 first.energy_expected, first.energy_found);
    }
  }
  if (comparison.counts_differing > 0) {
    fmt::print(scene.energy == EnergyModel::elastic
                   ? fmt::runtime("    {} sums over the image are wrong\n")
                   : fmt::runtime("    the number of changed sites was wrong after {} iterations\n"),
               grouped(comparison.counts_differing));
  }
  fmt::print("    repeat: {}\n", arguments.repeat("verify", scene, comparison.backend));
}

/// The comparisons of one backend, one per mode.
using Modes = std::span<const Comparison>;

bool is_skipped(const Comparison& comparison) {
  return comparison.verdict == Verdict::skipped;
}

void explain(const Scene& scene, Modes modes, const CommonArguments& arguments) {
  const Comparison& first = modes.front();
  const bool all_alike = std::ranges::all_of(modes, [&](const Comparison& comparison) {
    return comparison.verdict == first.verdict && comparison.reason == first.reason;
  });
  if (all_alike && (is_skipped(first) || first.verdict == Verdict::mistrusted)) {
    explain(first, "");
    return;
  }
  for (const Comparison& comparison : modes) {
    if (comparison.verdict != Verdict::agree) {
      explain(comparison, fmt::format(" ({})", name_of(comparison.mode)));
    }
    if (comparison.verdict == Verdict::disagree) {
      explain_disagreement(scene, comparison, arguments);
    }
  }
}

/// The worst of those that ran.
std::string verdict_of(Modes modes) {
  const Comparison* worst = nullptr;
  for (const Comparison& comparison : modes) {
    if (!is_skipped(comparison) && (worst == nullptr || comparison.verdict > worst->verdict)) {
      worst = &comparison;
    }
  }
  const Verdict verdict = worst == nullptr ? Verdict::skipped : worst->verdict;
  return verdict == Verdict::agree ? fmt::format("agree, {}", name_of(worst->tier))
                                   : std::string(name_of(verdict));
}

/// Which modes are not compared on any backend, and how much of the work active may leave out.
void print_remarks(const Scene& scene, const std::vector<Comparison>& comparisons) {
  if (scene.robust) {
    fmt::print("  observations are forgiven by solving again with other springs: followed is the first "
               "solution\n");
  }
  for (const Mode mode : {Mode::active, Mode::pyramid}) {
    const std::string reason = why_left_out(mode, scene);
    const bool is_compared = std::ranges::find(comparisons, mode, &Comparison::mode) != comparisons.end();
    if (!reason.empty() && !is_compared) {
      fmt::print("  {} is not compared: {}\n", name_of(mode), reason);
    }
  }
  for (const Comparison& comparison : comparisons) {
    if (!comparison.coarse_levels.empty()) {
      fmt::print("  pyramid on {}: coarse levels by {}\n", comparison.backend,
                 joined(comparison.coarse_levels, ", and by "));
    }
  }
  const auto rested = std::ranges::find_if(
      comparisons, [](const Comparison& comparison) { return comparison.sites_at_rest > 0; });
  if (rested != comparisons.end()) {
    fmt::print("  active: tiles of 16 x 16 are at rest in {:.1f} % of the site updates\n",
               100.0 * static_cast<double>(rested->sites_at_rest) /
                   static_cast<double>(rested->sites_compared));
  }
}

} // namespace

void print_scene(const Scene& scene, const std::vector<Comparison>& comparisons,
                 const CommonArguments& arguments) {
  const auto ran = std::ranges::find_if_not(comparisons, is_skipped);
  fmt::print("\n{}, {} x {}, {}", scene.name, scene.extent().width, scene.extent().height,
             method_name(scene));
  if (ran != comparisons.end()) {
    fmt::print(
        ": {} level{}, {} iterations{}{}", ran->levels, ran->levels == 1 ? "" : "s", ran->iterations,
        ran->sweeps == ran->iterations
            ? ""
            : fmt::format(" in {} {}", ran->sweeps, scene.energy == EnergyModel::hdm ? "sweeps" : "steps"),
        arguments.quick ? " (quick)" : "");
  }
  fmt::print("\n");
  std::vector<Modes> backends;
  for (auto first = comparisons.begin(); first != comparisons.end();) {
    const auto last = std::find_if(first + 1, comparisons.end(), [&](const Comparison& comparison) {
      return comparison.backend != first->backend || comparison.mode == first->mode;
    });
    backends.emplace_back(first, last);
    first = last;
  }
  std::vector<Table::Column> columns{
      {"backend", Table::Align::left}, {"device", Table::Align::left}, {"sites compared"}};
  std::vector<Mode> modes_here;
  for (const Mode mode : {Mode::resync, Mode::free, Mode::active, Mode::pyramid}) {
    if (std::ranges::find(comparisons, mode, &Comparison::mode) != comparisons.end()) {
      modes_here.push_back(mode);
      columns.push_back({fmt::format("differing, {}", name_of(mode))});
    }
  }
  columns.push_back({scene.energy == EnergyModel::elastic ? "wrong sums" : "wrong counts"});
  columns.push_back({"verdict", Table::Align::left});
  Table table(columns);
  for (const Modes modes : backends) {
    std::vector<std::string> differing(modes_here.size(), "-");
    std::int64_t compared = 0;
    std::int64_t wrong_counts = 0;
    for (const Comparison& comparison : modes) {
      compared += comparison.sites_compared;
      wrong_counts += comparison.counts_differing;
      if (!is_skipped(comparison)) {
        const auto column = std::ranges::find(modes_here, comparison.mode) - modes_here.begin();
        differing.at(static_cast<std::size_t>(column)) = grouped(comparison.sites_differing);
      }
    }
    const bool ran_at_all = !std::ranges::all_of(modes, is_skipped);
    std::vector<std::string> cells{modes.front().backend, modes.front().device.name,
                                   ran_at_all ? grouped(compared) : "-"};
    cells.insert(cells.end(), differing.begin(), differing.end());
    cells.push_back(ran_at_all ? grouped(wrong_counts) : "-");
    cells.push_back(verdict_of(modes));
    table.add(std::move(cells));
  }
  fmt::print("{}", table.text());
  print_remarks(scene, comparisons);
  for (const Modes modes : backends) {
    explain(scene, modes, arguments);
  }
}

void print_tiers(std::span<const Comparison> comparisons) {
  Table table({{"backend", Table::Align::left},
               {"tier reached", Table::Align::left},
               {"comparisons", Table::Align::right},
               {"of them exact", Table::Align::right},
               {"sites compared", Table::Align::right},
               {"differing", Table::Align::right},
               {"certified", Table::Align::right},
               {"uncertified", Table::Align::right}});
  for (const BackendTier& row : tiers_reached(comparisons)) {
    if (row.comparisons == 0) {
      table.add({row.backend, "skipped", "-", "-", "-", "-", "-", "-"});
      continue;
    }
    table.add({row.backend, std::string(name_of(row.tier)), grouped(row.comparisons), grouped(row.exact),
               grouped(row.sites_compared), grouped(row.sites_differing), grouped(row.certified_ties),
               grouped(row.uncertified)});
  }
  fmt::print("\nAll scenes, all modes\n{}", table.text());
}

} // namespace hdmbench::commands
