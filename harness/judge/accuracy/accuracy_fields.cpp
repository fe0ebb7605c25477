// What the rows of accuracy have.

#include "harness/judge/accuracy/accuracy_row.hpp"

#include "harness/scene/row_fields.hpp"

#include <optional>
#include <string>

namespace hdmbench {

namespace {

void list_rmsd(Fields& fields, const std::string& truth, Rmsd& rmsd) {
  fields.if_any("rmsd_to_" + truth, rmsd.all);
  fields.if_any("rmsd_free_to_" + truth, rmsd.free);
}

/// The sites where there is a distance.
void list_interface(Fields& fields, std::optional<InterfaceRmsd>& interface) {
  InterfaceRmsd found = interface.value_or(InterfaceRmsd{});
  fields.if_any("rmsd_interface_to_fem", found.near);
  fields.if_any("rmsd_elsewhere_to_fem", found.elsewhere);
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
  fields("changed", level.changed);
}

static void list_fields(Fields& fields, JudgedField::Split& split) {
  double remainder = split.parts.remainder();
  fields("poisson", split.poisson);
  fields("total", split.parts.total);
  fields("model", split.parts.model);
  fields("optimisation", split.parts.optimisation);
  fields("covariance", split.parts.covariance);
  fields("remainder", remainder);
}

static void list_fields(Fields& fields, Arithmetic::Iterations& steps) {
  fields("iterations", steps.iterations);
  fields("steps_compared", steps.steps_compared);
  fields("steps_differing", steps.steps_differing);
  fields("beyond_bound", steps.beyond_bound);
  fields("largest_gap_over_bound", steps.largest_gap_over_bound);
  fields("rmsd", steps.rmsd);
}

static void list_fields(Fields& fields, Arithmetic& arithmetic) {
  fields("resynchronised", arithmetic.resynchronised);
  fields.if_any("double_rmsd", arithmetic.run_rmsd);
}

static void list_fields(Fields& fields, Convergence& convergence) {
  fields("iterations_per_level", convergence.iterations_per_level);
  fields("rmsd_to_fem", convergence.rmsd_to_fem);
  fields("rmsd_to_fixed_point", convergence.rmsd_to_fixed_point);
  fields("mean_energy", convergence.mean_energy);
}

static void list_fields(Fields& fields, figures::Profiles& profiles) {
  fields("horizontal", profiles.horizontal);
  fields("vertical", profiles.vertical);
  fields("falling", profiles.falling);
  fields("rising", profiles.rising);
}

static void list_fields(Fields& fields, LevelProfiles::Components& line) {
  fields("x", line.x);
  fields("y", line.y);
}

static void list_fields(Fields& fields, LevelProfiles& profiles) {
  fields("level", profiles.level);
  fields("width", profiles.width);
  fields("height", profiles.height);
  fields("horizontal", profiles.horizontal);
  fields("vertical", profiles.vertical);
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

static void list_fields(Fields& fields, AccuracyRow::Grid& grid) {
  fields("spacing", grid.spacing);
  fields("lines", grid.lines);
}

void list_fields(Fields& fields, AccuracyRow& row) {
  fields("scene", row.scene);
  fields("title", row.title);
  fields("width", row.width);
  fields("height", row.height);
  fields("poisson", row.poisson);
  fields("method", row.method);
  fields("variant", row.variant);
  fields("note", row.note);
  fields("energy", row.energy);
  fields("backend", row.backend);
  fields("device", row.device);
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
  fields.if_any("decompositions", row.decompositions);
  fields.if_any("convergence", row.convergence);
  fields.if_any("profiles", row.profiles);
  fields.if_any("level_profiles", row.level_profiles);
  fields.if_any("differences", row.differences);
  fields.if_any("grid", row.grid);
  fields.if_any("interfaces", row.interfaces);
}

} // namespace hdmbench
