#include "harness/cli/judged_text.hpp"

#include "harness/measure/median.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace hdmbench::commands {

std::string name_of(const Judged& row) {
  return fmt::format("{}{}{}", row.method,
                     row.poisson_used ? fmt::format(", nu {:.2g}", *row.poisson_used) : "",
                     !row.variant.empty()   ? ": " + row.variant
                     : !row.backend.empty() ? " on " + row.backend
                                            : "");
}

std::string pixels_text(double pixels) {
  if (std::abs(pixels) < 1e-3) {
    return pixels == 0.0 ? "0" : fmt::format("{:.1e}", pixels);
  }
  return fmt::format("{:.{}f}", pixels, pixels < 0.1 ? 4 : pixels < 10.0 ? 3 : 2);
}

std::string table_text(std::span<const Judged* const> rows) {
  Table table({"<RMSD in pixels to", "<effort", "FEM", "FEM nu 0", "fixed point", "interfaces", "elsewhere",
               "mean energy", "iterations", "fine sweeps", "seconds", "<"});
  const auto pixels = [](const std::optional<double>& value) { return value ? pixels_text(*value) : ""; };
  for (const Judged* const row : rows) {
    const Deviations& to = row->deviations;
    const auto& sweeps = row->fine_sweep_equivalents;
    table.add({name_of(*row), row->effort, pixels(to.to_fem), pixels(to.to_fem_no_poisson),
               pixels(to.to_fixed_point), pixels(to.interface_to_fem), pixels(to.elsewhere_to_fem),
               fmt::format("{:.5g}", row->mean_energy),
               row->levels.empty() ? "" : std::to_string(total_iterations(row->levels)),
               sweeps ? fmt::format("{:.3g}", *sweeps) : "", fmt::format("{:.3g}", median(row->seconds)),
               row->status != JudgedStatus::ok ? std::string(hdmbench::name_of(row->status))
               : row->is_on_front              ? "front"
                                               : ""});
  }
  return table.text();
}

std::string failures_text(const std::vector<Judged>& rows) {
  std::map<std::pair<JudgedStatus, std::string>, std::set<std::string>> failed;
  for (const Judged& row : rows) {
    if (row.status != JudgedStatus::ok) {
      failed[{row.status, row.reason}].insert(name_of(row));
    }
  }
  std::string text;
  for (const auto& [why, names] : failed) {
    text += fmt::format("  {}: {}: {}\n", hdmbench::name_of(why.first), joined(names, ", "), why.second);
  }
  return text;
}

} // namespace hdmbench::commands
