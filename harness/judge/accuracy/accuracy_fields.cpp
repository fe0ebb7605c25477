// What the rows of accuracy have, and what cannot be true of them.

#include "harness/judge/accuracy/accuracy_row.hpp"

#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace hdmbench {

namespace {

void require_length(const std::string& key, std::size_t found, std::int64_t wanted, const char* of_what) {
  refuse_if(static_cast<std::int64_t>(found) != wanted, key, "has {} values, but {} is {}", found, of_what,
            wanted);
}

void require_lines(const char* key, const std::vector<figures::Polyline>& lines) {
  for (const figures::Polyline& line : lines) {
    refuse_if(line.size() < 4 || line.size() % 2 != 0, key,
              "has a line of {} numbers, but x and y of at least two points are needed", line.size());
  }
}

void list_rmsd(Fields& fields, const std::string& truth, Rmsd& rmsd) {
  fields.if_any("rmsd_to_" + truth, NotNegative{rmsd.all});
  fields.if_any("rmsd_free_to_" + truth, NotNegative{rmsd.free});
}

/// The sites where there is a distance.
void list_interface(Fields& fields, std::optional<InterfaceRmsd>& interface) {
  InterfaceRmsd found = interface.value_or(InterfaceRmsd{});
  fields.if_any("rmsd_interface_to_fem", NotNegative{found.near});
  fields.if_any("rmsd_elsewhere_to_fem", NotNegative{found.elsewhere});
  if (found.near || found.elsewhere) {
    fields("interface_sites", found.near_sites);
    fields("elsewhere_sites", found.elsewhere_sites);
    interface = found;
  }
}

} // namespace

static void list_fields(Fields& fields, LevelResult& level) {
  fields("level", level.level);
  fields("width", level.extent.width);
  fields("height", level.extent.height);
  fields("iterations", level.iterations);
  fields.newer("changed", level.changed);
}

static void list_fields(Fields& fields, JudgedField::Split& split) {
  double remainder = split.parts.remainder();
  fields("poisson", split.poisson);
  fields("total", NotNegative{split.parts.total});
  fields("model", NotNegative{split.parts.model});
  fields("optimisation", NotNegative{split.parts.optimisation});
  fields("covariance", split.parts.covariance);
  fields("remainder", remainder);
  // The one that is written must be small, and be what the others leave.
  const double total = split.parts.total * split.parts.total;
  for (const double left : {remainder, split.parts.remainder()}) {
    refuse_if(fields.reading() && !(std::abs(left) <= 1e-9 * (total + 1.0)), "remainder",
              "is {:.3g} px^2: model^2 + optimisation^2 + 2 covariance is not total^2 = {:.6g}", left, total);
  }
}

static void list_fields(Fields& fields, Arithmetic::Iterations& steps) {
  fields("iterations", steps.iterations);
  fields("steps_compared", steps.steps_compared);
  fields("steps_differing", steps.steps_differing);
  fields("beyond_bound", steps.beyond_bound);
  fields.newer("largest_gap_over_bound", NotNegative{steps.largest_gap_over_bound});
  fields.newer("rmsd", NotNegative{steps.rmsd});
}

static void require_consistent(const Arithmetic::Iterations& steps) {
  refuse_if(steps.steps_differing > steps.steps_compared, "steps_differing",
            "is {}, but only {} were compared", steps.steps_differing, steps.steps_compared);
  refuse_if(steps.beyond_bound > steps.steps_differing, "beyond_bound", "is {}, but only {} steps differ",
            steps.beyond_bound, steps.steps_differing);
  if (steps.beyond_bound == 0 && steps.largest_gap_over_bound.value_or(0.0) > 1.0) {
    throw Contradiction{"largest_gap_over_bound",
                        fmt::format("is {}, but \"beyond_bound\" is 0", *steps.largest_gap_over_bound)};
  }
}

static void list_fields(Fields& fields, Arithmetic& arithmetic) {
  fields("resynchronised", arithmetic.resynchronised);
  fields.if_any("double_rmsd", NotNegative{arithmetic.run_rmsd});
}

static void list_fields(Fields& fields, Convergence& convergence) {
  fields("iterations_per_level", convergence.iterations_per_level);
  fields("rmsd_to_fem", NullIsNan{convergence.rmsd_to_fem});
  fields("rmsd_to_fixed_point", NullIsNan{convergence.rmsd_to_fixed_point});
  fields("mean_energy", NullIsNan{convergence.mean_energy});
}

static void require_consistent(const Convergence& convergence) {
  const std::vector<int>& iterations = convergence.iterations_per_level;
  refuse_if(iterations.empty() || iterations.front() < 1 ||
                std::ranges::adjacent_find(iterations, std::greater_equal<>()) != iterations.end(),
            "iterations_per_level", "must rise from at least 1");
  for (const auto& [key, values] : {std::pair("rmsd_to_fem", &convergence.rmsd_to_fem),
                                    std::pair("rmsd_to_fixed_point", &convergence.rmsd_to_fixed_point),
                                    std::pair("mean_energy", &convergence.mean_energy)}) {
    require_length(key, values->size(), std::ssize(iterations), "the length of \"iterations_per_level\"");
    const auto negative = std::ranges::find_if(*values, [](double value) { return value < 0.0; });
    if (values != &convergence.mean_energy && negative != values->end()) {
      throw Contradiction{key, fmt::format("has {}, but must not be negative", *negative)};
    }
  }
}

static void list_fields(Fields& fields, figures::Profiles& profiles) {
  fields("horizontal", NullIsNan{profiles.horizontal});
  fields("vertical", NullIsNan{profiles.vertical});
  fields("falling", NullIsNan{profiles.falling});
  fields("rising", NullIsNan{profiles.rising});
}

static void list_fields(Fields& fields, LevelProfiles::Components& line) {
  fields("x", NullIsNan{line.x});
  fields("y", NullIsNan{line.y});
}

static void list_fields(Fields& fields, LevelProfiles& profiles) {
  fields("level", profiles.level);
  fields("width", profiles.width);
  fields("height", profiles.height);
  fields("horizontal", profiles.horizontal);
  fields("vertical", profiles.vertical);
}

static void require_consistent(const LevelProfiles& profiles) {
  require_length("horizontal.x", profiles.horizontal.x.size(), profiles.width, "the width of the level");
  require_length("horizontal.y", profiles.horizontal.y.size(), profiles.width, "the width of the level");
  require_length("vertical.x", profiles.vertical.x.size(), profiles.height, "the height of the level");
  require_length("vertical.y", profiles.vertical.y.size(), profiles.height, "the height of the level");
}

static void list_fields(Fields& fields, Differences::Files& files) {
  fields("magnitude", files.magnitude);
  fields("x", files.x);
  fields("y", files.y);
}

static void list_fields(Fields& fields, Differences& differences) {
  fields("pictures", differences.pictures);
  fields("limit", differences.limit);
  fields("against", differences.against);
}

static void require_consistent(const Differences& differences) {
  refuse_if(!(differences.limit > 0.0), "limit", "is {}, but must be greater than 0", differences.limit);
}

static void list_fields(Fields& fields, AccuracyRow::Grid& grid) {
  fields("spacing", grid.spacing);
  fields("lines", grid.lines);
}

static void require_consistent(const AccuracyRow::Grid& grid) {
  require_lines("lines", grid.lines);
}

void list_fields(Fields& fields, AccuracyRow& row) {
  static constexpr std::array<std::string_view, 10> methods{
      "icm",         "sequential",           "fixed-point",
      "fem",         "fem-coarse",           "interpolation",
      "b-spline",    elastic_full_multigrid, elastic_conjugate_gradients,
      elastic_sweeps};
  static constexpr std::array<std::string_view, 3> energies{"none", energy_names[0], energy_names[1]};
  fields("scene", row.scene);
  fields("title", row.title);
  fields("width", row.width);
  fields("height", row.height);
  fields("poisson", row.poisson);
  fields("method", OneOf{row.method, methods});
  fields.newer("variant", row.variant);
  fields.newer("note", row.note);
  fields.newer("energy", OneOf{row.energy, energies});
  fields.newer("backend", row.backend);
  fields.newer("device", row.device);
  fields("status", row.status);
  fields("valid", row.valid);
  if (row.method.starts_with("fem")) {
    fields("poisson_used", row.poisson_used);
  } else {
    fields.if_any("poisson_used", row.poisson_used);
  }
  fields.if_any("seconds", row.seconds);
  fields.if_any("seconds_median", row.seconds_median);
  fields.if_any("mean_energy", row.mean_energy);
  list_rmsd(fields, "fem", row.to_fem);
  list_rmsd(fields, "fem_nu0", row.to_fem_nu0);
  list_rmsd(fields, "fixed_point", row.to_fixed_point);
  list_interface(fields, row.interface);
  fields.if_any("iterations", row.iterations);
  fields.if_any("levels", row.levels);
  fields.if_any("fine_sweep_equivalents", row.fine_sweep_equivalents);
  fields.if_any("arithmetic", row.arithmetic);
  if (fields.reading() && row.failed()) {
    return; // a broken field may have null anywhere
  }
  fields.if_any("decompositions", row.decompositions);
  fields.if_any("convergence", row.convergence);
  fields.if_any("profiles", row.profiles);
  fields.if_any("level_profiles", row.level_profiles);
  fields.if_any("differences", row.differences);
  fields.if_any("grid", row.grid);
  fields.if_any("interfaces", row.interfaces);
}

void require_consistent(const AccuracyRow& row) {
  refuse_if(row.method.starts_with("fem") && !row.poisson_used, "poisson_used", "is missing");
  if (!row.failed()) {
    require_samples(row.seconds, row.seconds_median);
  }
  const std::int64_t sum = total_iterations(row.levels);
  if (!row.levels.empty() && row.iterations != sum) {
    throw Contradiction{"levels",
                        fmt::format("come to {} iterations, but \"iterations\" is {}", sum,
                                    row.iterations ? fmt::format("{}", *row.iterations) : "missing")};
  }
  if (row.profiles) {
    const figures::Profiles& profiles = *row.profiles;
    require_length("profiles.horizontal", profiles.horizontal.size(), row.width, "the width of the image");
    require_length("profiles.vertical", profiles.vertical.size(), row.height, "the height of the image");
    require_length("profiles.rising", profiles.rising.size(), std::ssize(profiles.falling),
                   "the length of \"falling\"");
  }
  require_lines("interfaces", row.interfaces);
}

} // namespace hdmbench
