#include "harness/check/verify_row.hpp"

#include "harness/scene/row_fields.hpp"
#include "harness/solve/solve.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

static void list_fields(Fields& fields, FirstDifference& first) {
  fields("level", first.level);
  fields("iteration", first.iteration);
  fields("x", first.x);
  fields("y", first.y);
  fields.newer("expected", NullIsNan{first.expected});
  fields.newer("found", NullIsNan{first.found});
  fields.newer("energy_before", NullIsNan{first.energy_before});
  fields.newer("energy_expected", NullIsNan{first.energy_expected});
  fields.newer("energy_found", NullIsNan{first.energy_found});
  fields.newer("certified", first.certificate.holds);
  fields.newer("gap_over_bound", NullIsNan{first.certificate.gap_over_bound});
  fields.newer("step", first.step);
}

static void list_fields(Fields& fields, Window& window) {
  fields("x", window.x);
  fields("y", window.y);
  fields("width", window.extent.width);
  fields("height", window.extent.height);
}

static void list_fields(Fields& fields, WindowedLevel& level) {
  fields("level", level.level);
  fields("width", level.extent.width);
  fields("height", level.extent.height);
  fields("sweeps", level.sweeps);
  fields("level_by_level", level.level_by_level);
  fields("whole", level.whole);
  fields("windows", level.windows);
  fields("sites_compared", level.sites_compared);
  fields("sites_differing", level.sites_differing);
  fields("count_differs", level.count_differs);
}

static void list_fields(Fields& fields, WindowedPyramid& pyramid) {
  fields("work", pyramid.work);
  fields("sites_differing", pyramid.sites_differing);
  fields("same_field", pyramid.same_field);
  fields("same_count", pyramid.same_count);
}

void list_fields(Fields& fields, VerifyRow& row) {
  fields("scene", row.scene);
  fields("width", row.width);
  fields("height", row.height);
  fields("backend", row.backend);
  fields("device", row.device.name);
  fields("mode", row.mode);
  fields("levels", row.levels);
  fields.newer("method", row.method);
  fields("iterations", row.iterations);
  fields.newer("sweeps", row.sweeps);
  fields("sites_compared", row.sites_compared);
  fields("sites_differing", row.sites_differing);
  fields.newer("not_finite", row.not_finite);
  fields.newer("counts_differing", row.counts_differing);
  fields("certified_ties", row.certified_ties);
  fields("uncertified", row.uncertified);
  fields("max_abs_difference", NullIsNan{row.largest_difference});
  fields("first_difference", row.first);
  fields("tier", row.tier);
  fields("verdict", row.verdict);
  fields("reason", row.reason);
  fields.if_any("ranks", row.ranks);
  if (row.mode == Mode::windows) {
    fields.newer("coverage", row.coverage);
    fields.newer("pyramids", row.pyramids);
    return;
  }
  fields.newer("sites_drifted", row.sites_drifted);
  fields.newer("largest_gap_over_bound", NullIsNan{row.largest_gap_over_bound});
  fields.newer("sites_at_rest", row.sites_at_rest);
  fields.newer("coarse_levels", row.coarse_levels);
}

void require_consistent(const VerifyRow& row) {
  const bool passes = row.verdict == Verdict::agree || row.verdict == Verdict::certified;
  refuse_if(passes && row.sites_compared == 0, "verdict", "is a pass although no site was compared");
  refuse_if(row.verdict == Verdict::agree && row.sites_differing > 0, "verdict",
            "is \"agree\" although {} sites differ", row.sites_differing);
  refuse_if(passes && row.counts_differing > 0, "verdict",
            "is a pass although {} counts of changed sites differ", row.counts_differing);
  refuse_if(passes && row.uncertified > 0, "verdict", "is a pass although {} differing sites are uncertified",
            row.uncertified);
  refuse_if(passes != (row.tier != Tier::none) ||
                (row.verdict == Verdict::certified) != (row.tier == Tier::certified),
            "tier", "is \"{}\", which the verdict contradicts", name_of(row.tier));
}

VerifyRow verify_row(const Scene& scene, const Comparison& comparison) {
  return {comparison, scene.name, scene.extent().width, scene.extent().height, method_name(scene)};
}

VerifyRow verify_row(const std::string& scene, Extent extent, const std::string& method,
                     const WindowedComparison& comparison) {
  VerifyRow row{{}, scene, extent.width, extent.height, method, comparison.levels, comparison.pyramids};
  row.backend = comparison.backend;
  row.device = comparison.device;
  row.mode = Mode::windows;
  row.levels = static_cast<int>(comparison.levels.size());
  row.verdict = comparison.verdict;
  row.tier = comparison.verdict == Verdict::agree ? Tier::bitwise : Tier::none;
  row.reason = comparison.reason;
  for (const WindowedLevel& level : comparison.levels) {
    row.iterations += level.iterations;
    row.sweeps += level.sweeps;
    row.sites_compared += level.sites_compared;
    row.sites_differing += level.sites_differing;
    row.not_finite += level.not_finite;
    row.counts_differing += level.count_differs ? 1 : 0;
    row.largest_difference = std::max(row.largest_difference, level.largest_difference);
    if (level.first && !row.first) {
      row.first = FirstDifference{.level = level.level,
                                  .iteration = level.iterations,
                                  .x = level.first->x,
                                  .y = level.first->y,
                                  .expected = level.first->expected,
                                  .found = level.first->found};
      row.first->certificate.gap_over_bound = std::nan("");
    }
  }
  row.uncertified = row.sites_differing;
  return row;
}

} // namespace hdmbench
