#include "harness/report/faults_results.hpp"

#include "harness/report/json_reader.hpp"

#include <algorithm>

namespace hdmbench::report {

namespace {

FaultOnScene read_scene(const JsonReader& json) {
  FaultOnScene scene;
  scene.scene = json.text("scene");
  scene.width = json.count("width");
  scene.height = json.count("height");
  scene.exact = json.flag("exact");
  scene.verdict = json.text("verdict", {"agree", "certified", "skipped", "mistrusted", "disagree", "error"});
  scene.sites_differing = json.count("sites_differing");
  scene.uncertified = json.count("uncertified");
  scene.reason = json.text("reason");
  return scene;
}

} // namespace

bool FaultRow::ran() const {
  return std::ranges::any_of(scenes, [](const FaultOnScene& scene) {
    return scene.verdict == "agree" || scene.verdict == "certified" || scene.verdict == "disagree";
  });
}

FaultRow read_fault(const JsonReader& json) {
  FaultRow row;
  row.fault = json.text("fault");
  row.what = json.text("what");
  row.backend = json.text("backend");
  row.layer = json.text("layer", {"session", "shader", "driver"});
  row.expected = json.text("expected", {"disagree", "let through", "either"});
  row.caught = json.flag("caught");
  row.as_expected = json.flag("as_expected");
  row.not_planted = json.text("not_planted");
  for (const JsonReader& scene : json.objects("scenes")) {
    row.scenes.push_back(read_scene(scene));
  }
  const bool seen = std::ranges::count(row.scenes, "disagree", &FaultOnScene::verdict) > 0;
  if (row.caught != seen) {
    json.fail("caught", row.caught ? "is true although verify disagrees on no scene"
                                   : "is false although verify disagrees on a scene");
  }
  const bool impossible = !row.not_planted.empty() ||
                          (row.expected == "disagree" && row.ran() && !row.caught) ||
                          (row.expected == "let through" && row.caught);
  if (row.as_expected && impossible) {
    json.fail("as_expected", "is true although the row says otherwise");
  }
  return row;
}

} // namespace hdmbench::report
