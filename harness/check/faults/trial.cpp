#include "harness/check/faults/trial.hpp"

#include "backends/pieces/cut.hpp"
#include "backends/session/shapes.hpp"
#include "harness/check/cases.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/sites.hpp"

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace hdmbench::faults {

namespace {

/// Iterations per level: mistakes show at once or never.
constexpr int iteration_limit = 8;

/// Of scenes where nobody asks for a size: unequal sides, several levels, no multiple of a work group. Those
/// that are exact may be so only where the levels are powers of two.
constexpr Extent usual{48, 40};
constexpr Extent usual_if_exact{32, 32};

// What results call them, in the order of the enumerators.
constexpr std::string_view name_of(Expected expected) {
  return expected == Expected::disagree ? "disagree" : "let through";
}
constexpr std::string_view name_of(Layer layer) {
  constexpr std::array<std::string_view, 4> names{"session", "shader", "driver", "ranks"};
  return names[static_cast<std::size_t>(layer)];
}

TrialScene load_trial(Case one, const std::optional<Extent>& size) {
  TrialScene trial{.label = one.name(), .scene = {}};
  const bool has_own_size = one.size.has_value();
  one.size = size.value_or(one.size.value_or(usual_if_exact));
  trial.scene = load_case(one);
  if (!trial.scene.exact && !size && !has_own_size) {
    one.size = usual;
    trial.scene = load_case(one);
  }
  return trial;
}

/// What is tried where nobody names scenes, the most telling ones first: each rule and order of sites, and
/// two ways to the elastic energy.
std::vector<Case> usual_cases() {
  std::vector<Case> cases;
  for (const char* const scene :
       {"exact-textures", "random", "tie-rich", "square", "circular", "exact-pyramid", "exact-square"}) {
    cases.push_back({.scene = scene});
  }
  for (const char* const method :
       {"coloured", "closed-form", "annealing", "cascade", "conjugate-gradients"}) {
    cases.push_back({.scene = "random", .method = method});
  }
  cases.push_back({.scene = "square", .method = std::string(elastic_conjugate_gradients)});
  cases.push_back({.scene = "square", .method = std::string(elastic_sweeps)});
  for (const char* const method : {"", "closed-form", "conjugate-gradients"}) {
    cases.push_back({.scene = "ball", .size = Extent{13, 9, 7}, .method = method});
  }
  std::ranges::move(box_cases(iteration_limit), std::back_inserter(cases));
  return cases;
}

/// Pulled so little that coarse levels come to rest within a few iterations.
TrialScene pulled_by_2_px(Scene scene) {
  for (auto* const values : {&scene.full.target[0], &scene.full.target[1]}) {
    std::ranges::transform(*values, values->begin(), [](float pull) { return 0.04F * pull; });
  }
  return {.label = fmt::format("{}, 2 px", scene.name), .scene = std::move(scene)};
}

/// A level of 3 x 3 tiles of the largest size that a backend has, most of them asleep from the second sweep
/// on. The tile in the middle has something pulled next to each of its sides, away from its corners; the one
/// at the top right, in its middle and along y alone.
TrialScene sleeping_tiles() {
  const Box pulls[] = {{{254, 102}, {256, 105, 1}}, // sites 128 ... 255 are the tile in the middle
                       {{128, 86}, {130, 89, 1}},
                       {{160, 126}, {163, 128, 1}},
                       {{200, 64}, {203, 66, 1}},
                       {{320, 32}, {322, 34, 1}}};
  constexpr float pull = 40.0F; // pixels: further than a level's few iterations get
  Scene scene = load_scene("square", {.size = Extent{384, 192}});
  Level& full = scene.full;
  full.target = full.confidence = VectorField(scene.extent());
  for (const Box& sites : pulls) {
    for_each_site(sites.extent(), [&](int x, int y) {
      const std::size_t site = scene.extent().index(sites.first[0] + x, sites.first[1] + y);
      full.target[0][site] = &sites == &pulls[4] ? 0.0F : pull;
      full.target[1][site] = pull;
      full.confidence[0][site] = full.confidence[1][site] = 1.0F;
    });
  }
  scene.schedule.start_level = 0;
  return {.label = "sleeping tiles", .scene = std::move(scene), .tiles_sleep = true};
}

/// What they come to: the worst verdict, its reason, and the sums of what differed.
nlohmann::json worst_of(const std::vector<Comparison>& comparisons) {
  Verdict verdict = Verdict::skipped;
  std::string reason = comparisons.front().reason;
  std::int64_t differing = 0;
  std::int64_t uncertified = 0;
  std::int64_t counts = 0;
  for (const Comparison& comparison : comparisons) {
    if (comparison.verdict == Verdict::skipped) {
      continue;
    }
    if (verdict == Verdict::skipped || comparison.verdict > verdict) {
      verdict = comparison.verdict;
      reason = comparison.reason;
    }
    differing += comparison.sites_differing;
    uncertified += comparison.uncertified;
    counts += comparison.counts_differing;
  }
  return {{"verdict", name_of(verdict)},
          {"sites_differing", differing},
          {"uncertified", uncertified},
          {"counts_differing", counts},
          {"reason", reason}};
}

/// What the verdicts of its scenes come to.
void judge(Expected expected, nlohmann::json& row) {
  const auto saw = [&](std::string_view verdict) {
    return std::ranges::any_of(row["scenes"],
                               [&](const nlohmann::json& seen) { return seen["verdict"] == verdict; });
  };
  const bool caught = saw(name_of(Verdict::disagree));
  const bool ran = caught || saw(name_of(Verdict::agree)) || saw(name_of(Verdict::certified));
  const bool broke_off = saw("error");
  const bool good = expected == Expected::disagree
                        ? caught || (!ran && !broke_off)
                        : !caught && !broke_off && !saw(name_of(Verdict::mistrusted));
  row.update({{"ran", ran}, {"caught", caught}, {"as_expected", good && row["not_planted"] == ""}});
}

} // namespace

std::vector<TrialScene> trial_scenes(const std::vector<std::string>& names, std::optional<Extent> size) {
  std::vector<TrialScene> scenes;
  for (const std::string& name : names) {
    scenes.push_back(load_trial({.scene = name}, size));
    scenes.back().label = scenes.back().scene.name; // of a file
  }
  if (names.empty()) {
    for (const Case& one : usual_cases()) {
      const bool is_volume = one.size && one.size->axes() == 3; // and keeps its own size
      scenes.push_back(load_trial(one, is_volume && size && size->axes() == 2 ? std::nullopt : size));
    }
    scenes.push_back(pulled_by_2_px(load_trial({.scene = "square"}, size).scene));
    scenes.push_back(sleeping_tiles());
  }
  return scenes;
}

bool concerns(const Planted& planted, const TrialScene& scene) {
  if ((!planted.method.empty() && planted.method != scene.scene.schedule.method) ||
      (planted.axes != 0 && planted.axes != scene.scene.extent().axes()) ||
      scene.tiles_sleep != (planted.part == Part::sleep)) {
    return false;
  }
  if (planted.part != Part::levels && planted.part != Part::coarse_levels) {
    return true;
  }
  const std::optional<Pyramid> pyramid = LevelSequence(scene.scene).pyramid(); // in one piece
  return pyramid &&
         (planted.part == Part::levels ? pyramid->levels.size() > 1 : coarse_level_count(*pyramid, 8) > 0);
}

nlohmann::json try_out(const Planted& planted, const Backend& reference, std::span<const TrialScene> scenes,
                       Progress& progress) {
  nlohmann::json row{{"fault", planted.name},
                     {"what", planted.what},
                     {"backend", planted.backend},
                     {"device", ""},
                     {"layer", name_of(planted.layer)},
                     {"expected", name_of(planted.expected)},
                     {"not_planted", ""},
                     {"scenes", nlohmann::json::array()}};
  Progress silent(false);
  for (const TrialScene& trial : scenes) {
    if (!concerns(planted, trial)) {
      continue;
    }
    progress.describe(fmt::format("{} on {}: {}", planted.name, planted.backend, trial.label));
    nlohmann::json seen = with_size({{"scene", trial.label},
                                     {"method", trial.scene.schedule.method},
                                     {"exact", trial.scene.exact},
                                     {"verdict", name_of(Verdict::skipped)},
                                     {"reason", ""}},
                                    trial.scene.extent());
    try {
      const std::unique_ptr<Backend> faulty = planted.make();
      const Backend* const backends[] = {faulty.get()};
      std::vector<Comparison> comparisons =
          verify(trial.scene, reference, backends,
                 {.session = {}, .iteration_limit = iteration_limit, .explains = false}, silent);
      if (planted.bitwise) {
        std::ranges::for_each(comparisons, excuse_nothing);
      }
      row["device"] = comparisons.front().device.name;
      const auto failed = std::ranges::find(comparisons, true, &Comparison::failed);
      if (failed != comparisons.end()) {
        throw DeviceError(failed->reason);
      }
      seen.update(worst_of(comparisons));
      if (planted.require_planted && seen["verdict"] != name_of(Verdict::skipped)) {
        planted.require_planted();
      }
    } catch (const NotPlanted& error) {
      row["not_planted"] = error.what();
    } catch (const DeviceError& error) {
      seen.update({{"verdict", "error"}, {"reason", error.what()}});
    }
    row["scenes"].push_back(std::move(seen));
    progress.advance(1.0);
  }
  judge(planted.expected, row);
  return row;
}

std::vector<Planted> all_planted(const Backend& carrier) {
  std::vector<Planted> list{{.name = "fused",
                             .what = "fused multiply-adds wherever there can be one",
                             .backend = "fused C++",
                             .expected = Expected::let_through,
                             .method = "",
                             .make = make_fused}};
  for (const Fault& fault : session_faults()) {
    if (fault.name != "in-place" || carrier.supports(Update::sequential)) {
      list.push_back({.name = fault.name,
                      .what = fault.what,
                      .backend = std::string(carrier.name()),
                      .expected = fault.is_control ? Expected::let_through : Expected::disagree,
                      .method = fault.method,
                      .axes = fault.axes,
                      .make = [&carrier, fault] { return std::make_unique<FaultyBackend>(carrier, fault); }});
    }
  }
#ifdef HDMBENCH_WITH_GL
  for (const Pipeline pipeline : {Pipeline::fragment, Pipeline::compute}) {
    for (const DeviceFault& fault : device_faults(pipeline)) {
      list.push_back(plant(pipeline, fault));
    }
  }
#endif
  return list;
}

} // namespace hdmbench::faults
