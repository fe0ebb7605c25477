#include "harness/cli/judged_text.hpp"

#include "harness/report/table.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

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

std::string judged_table(const nlohmann::json& rows) {
  return table_text(rows, "method|variant|poisson_used:nu|backend|effort|rmsd_to_fem:px to FEM|"
                          "rmsd_to_fem_nu0:FEM nu 0|rmsd_to_fixed_point:fixed point|"
                          "rmsd_interface_to_fem:interfaces|rmsd_elsewhere_to_fem:elsewhere|mean_energy|"
                          "iterations|fine_sweep_equivalents:fine sweeps|seconds_median:seconds|"
                          "asked:px asked|estimated_error:estimated|status");
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
