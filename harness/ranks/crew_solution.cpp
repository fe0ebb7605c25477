#include "harness/ranks/crew_solution.hpp"

#include "harness/ranks/hand_out.hpp"
#include "harness/scene/method.hpp"

#include <utility>

namespace hdmbench {

void put_outline(const Scene& scene, RankMessage& message) {
  const Schedule& schedule = scene.schedule;
  message.put(scene.extent());
  message.put(schedule.method);
  message.put(schedule.iterations);
  message.put(schedule.stop);
  message.put(schedule.start_level.value_or(-1));
  message.put(schedule.alignment);
  message.put(schedule.relaxation);
  message.put(scene.full.penalty);
  message.put(std::vector<float>(scene.full.steps.values().begin(), scene.full.steps.values().end()));
  message.put(scene.full.update);
  message.put(scene.start.has_value());
}

namespace {

/// Its level has the extent and no fields.
Scene get_outline(RankMessage& message, bool& has_start) {
  Scene scene;
  scene.full.extent = message.get<Extent>();
  const auto method = message.get<std::string>();
  use_method(scene, find_method(method), message.get<int>());
  scene.schedule.stop = message.get<Stop>();
  if (const int level = message.get<int>(); level >= 0) {
    scene.schedule.start_level = level;
  }
  scene.schedule.alignment = message.get<Alignment>();
  scene.schedule.relaxation = message.get<Relaxation>();
  scene.full.penalty = message.get<float>();
  scene.full.steps = StepSet(message.get<std::vector<float>>());
  scene.full.update = message.get<Update>();
  has_start = message.get<bool>();
  return scene;
}

} // namespace

void solve_scene(RankMessage& message, const CrewGiven& given, Ranks& ranks, const Sharing& sharing,
                 const std::string& fault, const Backend& backend, const SessionOptions& options) {
  ScenePart part;
  bool has_start = false;
  part.scene = get_outline(message, has_start);
  const auto rank = static_cast<std::size_t>(ranks.rank());
  const Extent extent = part.scene.extent();
  const Sharing by_method = sharing_for(part.scene.schedule, sharing);
  const LevelShare share = by_method(extent);
  part.sites = share.loaded[rank];
  part.full = without_fields(part.scene.full);
  hand_out(ranks, extent, share.loaded, given.level, false,
           static_cast<std::size_t>(part.full.energy->inputs), part.full);
  if (has_start) {
    part.start = hand_out(ranks, extent, share.loaded, given.field);
  }
  const faults::RankFault planted = faults::find_rank_fault(fault);
  if (planted.in_level) {
    planted.in_level(part.full, rank);
  }
  faults::FaultyExchange halos(ranks, planted, rank);
  const auto session = backend.open(options);
  const RankedSolution solution =
      solve_on_ranks(ranked_pyramid(std::move(part)), by_method, ranks, halos, *session, false);
  collect(ranks, extent, share.owned, solution.displacement, given.result);
}

} // namespace hdmbench
