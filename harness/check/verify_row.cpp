#include "harness/check/verify.hpp"

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
  fields.newer("certified", first.certificate.holds);
  fields.newer("gap_over_bound", NullIsNan{first.certificate.gap_over_bound});
  fields.newer("step", first.step);
}

void list_fields(Fields& fields, VerifyRow& row) {
  fields("scene", row.scene);
  fields("width", row.width);
  fields("height", row.height);
  fields("backend", row.backend);
  fields("device", row.device.name);
  fields.newer("driver", row.device.driver);
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
  fields.if_any("reference", row.reference);
  fields.if_any("repeat", row.repeat);
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

std::vector<BackendTier> tiers_reached(std::span<const Comparison> comparisons) {
  std::vector<BackendTier> rows;
  for (const Comparison& comparison : comparisons) {
    auto row = std::ranges::find(rows, comparison.backend, &BackendTier::backend);
    if (row == rows.end()) {
      row = rows.insert(rows.end(), {.backend = comparison.backend});
    }
    if (comparison.verdict == Verdict::skipped) {
      continue;
    }
    row->tier = row->comparisons == 0 ? comparison.tier : std::min(row->tier, comparison.tier);
    ++row->comparisons;
    row->exact += comparison.tier == Tier::exact ? 1 : 0;
    row->sites_compared += comparison.sites_compared;
    row->sites_differing += comparison.sites_differing;
    row->certified_ties += comparison.certified_ties;
    row->uncertified += comparison.uncertified;
  }
  return rows;
}

} // namespace hdmbench
