#include "harness/check/faults/fault_row.hpp"

#include "harness/check/verify.hpp"
#include "harness/scene/row_fields.hpp"

#include <algorithm>
#include <array>

namespace hdmbench {

static void list_fields(Fields& fields, FaultOnScene& scene) {
  static constexpr std::array<std::string_view, 6> verdicts{"agree",      "certified", "skipped",
                                                            "mistrusted", "disagree",  "error"};
  fields("scene", scene.scene);
  fields("width", scene.width);
  fields("height", scene.height);
  fields.newer("method", scene.method);
  fields("exact", scene.exact);
  fields("verdict", OneOf{scene.verdict, verdicts});
  fields("sites_differing", scene.sites_differing);
  fields("uncertified", scene.uncertified);
  fields.newer("counts_differing", scene.counts_differing);
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
  fields.newer("device", row.device);
  fields("layer", row.layer);
  fields("expected", row.expected);
  fields("caught", row.caught);
  fields("as_expected", row.as_expected);
  fields("not_planted", row.not_planted);
  fields("scenes", row.scenes);
}

void require_consistent(const FaultRow& row) {
  using faults::Expected;
  const bool seen = std::ranges::count(row.scenes, "disagree", &FaultOnScene::verdict) > 0;
  if (row.caught != seen) {
    throw Contradiction{"caught", row.caught ? "is true although verify disagrees on no scene"
                                             : "is false although verify disagrees on a scene"};
  }
  const bool impossible = !row.not_planted.empty() ||
                          (row.expected == Expected::disagree && row.ran() && !row.caught) ||
                          (row.expected == Expected::let_through && row.caught);
  refuse_if(row.as_expected && impossible, "as_expected", "is true although the row says otherwise");
}

} // namespace hdmbench
