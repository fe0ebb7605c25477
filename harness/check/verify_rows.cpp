#include "harness/check/verify_rows.hpp"

#include "harness/scene/row_fields.hpp"
#include "harness/solve/solve.hpp"

namespace hdmbench {

nlohmann::json verify_row(const Scene& scene, const Comparison& comparison) {
  nlohmann::json row = with_size({{"scene", scene.name},
                                  {"backend", comparison.backend},
                                  {"device", comparison.device.name},
                                  {"driver", comparison.device.driver},
                                  {"mode", name_of(comparison.mode)},
                                  {"levels", comparison.levels},
                                  {"method", method_name(scene)},
                                  {"iterations", comparison.iterations},
                                  {"sweeps", comparison.sweeps},
                                  {"sites_compared", comparison.sites_compared},
                                  {"sites_differing", comparison.sites_differing},
                                  {"not_finite", comparison.not_finite},
                                  {"counts_differing", comparison.counts_differing},
                                  {"has_hosts_laws", comparison.has_hosts_laws},
                                  {"certified_ties", comparison.certified_ties},
                                  {"uncertified", comparison.uncertified},
                                  {"max_abs_difference", comparison.largest_difference},
                                  {"first_difference", nullptr},
                                  {"tier", name_of(comparison.tier)},
                                  {"verdict", name_of(comparison.verdict)},
                                  {"reason", comparison.reason},
                                  {"why", comparison.why},
                                  {"wall_seconds", comparison.seconds},
                                  {"sites_drifted", comparison.sites_drifted},
                                  {"largest_gap_over_bound", comparison.largest_gap_over_bound},
                                  {"sites_at_rest", comparison.sites_at_rest}},
                                 scene.extent());
  if (comparison.first) {
    const FirstDifference& first = *comparison.first;
    row["first_difference"] = {{"level", first.level},
                               {"iteration", first.iteration},
                               {"x", first.x},
                               {"y", first.y},
                               {"expected", first.expected},
                               {"found", first.found},
                               {"certified", first.certificate.holds},
                               {"gap_over_bound", first.certificate.gap_over_bound},
                               {"step", first.step},
                               {"text", first.text()}};
    if (scene.extent().axes() > 2) {
      row["first_difference"]["z"] = first.z;
    }
  }
  return row;
}

} // namespace hdmbench
