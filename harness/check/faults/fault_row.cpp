#include "harness/check/faults/fault_row.hpp"

#include "harness/scene/row_fields.hpp"

#include <algorithm>

namespace hdmbench {

static void list_fields(Fields& fields, FaultOnScene& scene) {
  fields("scene", scene.scene);
  fields("width", scene.width);
  fields("height", scene.height);
  fields("method", scene.method);
  fields("exact", scene.exact);
  fields("verdict", scene.verdict);
  fields("sites_differing", scene.sites_differing);
  fields("uncertified", scene.uncertified);
  fields("counts_differing", scene.counts_differing);
  fields("reason", scene.reason);
}

bool FaultRow::ran() const {
  return std::ranges::any_of(scenes, [](const FaultOnScene& scene) {
    return scene.verdict == "agree" || scene.verdict == "certified" || scene.verdict == "disagree";
  });
}

void list_fields(Fields& fields, FaultRow& row) {
  fields("fault", row.fault);
  fields("what", row.what);
  fields("backend", row.backend);
  fields("device", row.device);
  fields("layer", row.layer);
  fields("expected", row.expected);
  fields("caught", row.caught);
  fields("as_expected", row.as_expected);
  fields("not_planted", row.not_planted);
  fields("scenes", row.scenes);
}

} // namespace hdmbench
