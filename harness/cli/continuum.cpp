#include "harness/judge/continuum.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::vector<int> sizes;
  std::vector<double> contrasts{0.1, 3.0, 10.0, 100.0};
  std::string backend = "openmp";
  SessionOptions session;
  bool quick = false;
  std::filesystem::path json;

  [[nodiscard]] std::vector<int> sides() const {
    std::vector<int> chosen = sizes;
    if (chosen.empty()) {
      chosen = quick ? std::vector{50, 100, 200} : std::vector{50, 75, 100, 150, 200, 300, 400, 600};
    }
    std::ranges::sort(chosen);
    return chosen;
  }
};

std::string text(const Distance& distance) {
  return fmt::format("{:.2e} ({:.1e})", distance.rmsd, distance.largest);
}

int run_continuum(const Arguments& arguments, const Command& command, const std::string& line) {
  refuse_idle(
      command,
      {{.here = !arguments.sizes.empty(), .options = {"--quick"}, .why = "--sizes says which sizes"}});
  require_results_writable(arguments.json);
  const auto registry = make_backends();
  const Backend& backend = find_backend(registry, arguments.backend);
  const std::vector<int> sides = arguments.sides();
  Progress progress;
  double total = 0.0;
  for (const int side : sides) {
    total += static_cast<double>(side) * side * static_cast<double>(arguments.contrasts.size());
  }
  progress.set_total(total);
  fmt::print(
      "A sheet with a round inclusion, stretched by 50 px, whose displacement is known in closed form. RMSD "
      "(largest) in\npixels. Discretisation: finite elements on the pixels, direct and in double, from the "
      "closed form. Algebraic: our\nfield at its usual effort from these finite elements; float32: when it "
      "rests. Order: of discretisation, since the\nfirst size.\n");
  nlohmann::json rows = nlohmann::json::array();
  for (const double contrast : arguments.contrasts) {
    Table table({"contrast", "size", "discretisation", "order", "algebraic", "float32", "our field in all"});
    for (const ContinuumRow& row : measure_continuum(contrast, sides, backend, arguments.session, progress)) {
      table.add({fmt::format("{:.6g}", row.contrast), std::to_string(row.width), text(row.discretisation),
                 row.order ? fmt::format("{:.2f}", *row.order) : "", text(row.algebraic), text(row.rounding),
                 text(row.total)});
      rows.push_back(to_json_row(row));
    }
    progress.clear();
    fmt::print("\n{}", table.text());
    std::fflush(stdout);
  }
  write_results(arguments.json, "continuum", run_context(line, arguments.quick), std::move(rows));
  return success;
}

} // namespace

void add_continuum(const Command& program, const std::string& arguments, int& status) {
  const Command command = program.add_subcommand(
      "continuum", "How far a mesh of pixels is from the continuum: a round inclusion whose displacement is "
                   "known exactly,\non meshes of several sizes; errors of discretisation, of the solver and "
                   "of float32 apart.");
  const auto own = std::make_shared<Arguments>();
  command.add_option("--sizes", own->sizes, "Sides of the images, several with commas")
      .delimiter(',')
      .range(8, 4096);
  command
      .add_option("--contrasts", own->contrasts,
                  "Modulus of the inclusion over that around it, several with commas")
      .delimiter(',')
      .range(1e-4, 1e4)
      .capture_default_str();
  command.add_option("--backend", own->backend, "Backend that computes").capture_default_str();
  command.add_option("--threads", own->session.threads, "CPU threads (0: all)").range(0, 4096);
  command.add_flag("--quick", own->quick, "Three sizes to 200; the results say so");
  command.add_option("--json", own->json, "Write the results to this file");
  command.callback([own, command, arguments, &status] { status = run_continuum(*own, command, arguments); });
}

} // namespace hdmbench::commands
