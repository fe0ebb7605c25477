#include "harness/cli/bench_on_ranks.hpp"

#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::commands {

namespace {

/// One row of `bench --scaling` on ranks: a number of ranks.
struct ScalingRow {
  std::string scene;
  std::string energy = "hdm"; ///< of energy_names
  std::string scaling;        ///< "strong" or "weak"
  std::string backend;
  std::int64_t ranks = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<double> seconds{}; ///< raw samples of the slowest rank
  std::int64_t messages = 0;     ///< of all ranks, in one solution
  std::int64_t bytes = 0;
  std::optional<double> message_seconds{}; ///< in messages, of the rank that was the longest in them, the
                                           ///< least of the samples
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ScalingRow, scene, energy, scaling, backend, ranks, width, height, seconds,
                                   messages, bytes, message_seconds)

/// 1, 2, 4 ... and all.
std::vector<int> counts_up_to(int ranks) {
  std::vector<int> counts;
  for (int count = 1; count < ranks; count *= 2) {
    counts.push_back(count);
  }
  counts.push_back(ranks);
  return counts;
}

/// With sides `factor` times as long, multiples of 4.
Extent scaled(Extent extent, double factor) {
  const auto side = [&](int sites) {
    return factor == 1.0 ? sites : 4 * static_cast<int>(std::lround(sites * factor / 4.0));
  };
  return {side(extent.width), side(extent.height)};
}

/// Samples of whole solutions, without making the scene and opening sessions. Collective.
ScalingRow measure(const Scene& scene, const std::string& kind, const RankBackend& backend, int repeats,
                   Ranks& ranks) {
  ScalingRow row{.scene = scene.name,
                 .energy = std::string(energy_names[static_cast<std::size_t>(scene.energy)]),
                 .scaling = kind,
                 .backend = backend.backends(),
                 .ranks = backend.ranks(),
                 .width = scene.extent().width,
                 .height = scene.extent().height};
  Progress silent(false);
  Solver solver(backend, {});
  for (int i = 0; i <= repeats; ++i) { // the first time is slower: shaders are compiled, memory is new
    const Traffic before = ranks.traffic();
    const double seconds = ranks.largest(solver.solve(scene, silent).timings.total());
    row.messages = ranks.sum(ranks.traffic().messages - before.messages);
    row.bytes = ranks.sum(ranks.traffic().bytes - before.bytes);
    const double in_messages = ranks.largest(ranks.traffic().seconds - before.seconds);
    if (i > 0) {
      row.seconds.push_back(seconds);
      row.message_seconds = std::min(in_messages, row.message_seconds.value_or(in_messages));
    }
  }
  return row;
}

void print_measured(const std::vector<ScalingRow>& rows) {
  Table table({"ranks", "size", "seconds", "speed-up", "efficiency", "fastest", "messages", "MB sent",
               "ms in messages"});
  const double one = median(rows.front().seconds);
  for (const ScalingRow& row : rows) {
    const double seconds = median(row.seconds);
    const double work = static_cast<double>(row.width) * static_cast<double>(row.height) /
                        (static_cast<double>(rows.front().width) * static_cast<double>(rows.front().height));
    const double speed_up = work * one / seconds;
    table.add({std::to_string(row.ranks), fmt::format("{} x {}", row.width, row.height),
               fmt::format("{:.4f}", seconds), fmt::format("{:.2f}", speed_up),
               fmt::format("{:.0f} %", 100.0 * speed_up / static_cast<double>(row.ranks)),
               fmt::format("{:.4f}", std::ranges::min(row.seconds)), grouped(row.messages),
               fmt::format("{:.2f}", static_cast<double>(row.bytes) / 1e6),
               fmt::format("{:.2f}", 1e3 * row.message_seconds.value_or(0.0))});
  }
  fmt::print(
      "{}  in messages: the rank that was the longest in them, with waiting for others, the least of the "
      "samples\n",
      table.text());
}

} // namespace

int bench_scaling_on_ranks(CommonArguments arguments, bool scaling, int repeats, const std::string& line,
                           Ranks& ranks) {
  const std::string kind = arguments.scenes.empty() ? "" : arguments.scenes.front();
  if (!scaling || (kind != "strong" && kind != "weak")) {
    throw InputError("on several ranks: bench --scaling strong (the same image on more ranks) or bench "
                     "--scaling weak (an image that grows with them), then a scene");
  }
  arguments.scenes.erase(arguments.scenes.begin());
  if (arguments.scenes.size() > 1 || arguments.sizes.size() > 1 || arguments.backends.size() > 1) {
    throw InputError("bench --scaling on ranks takes one scene, one size and one backend");
  }
  if (ranks.is_first()) {
    require_results_writable(arguments.json);
  }
  const Extent size = arguments.sizes.empty() ? Extent{1024, 1024} : parse_size(arguments.sizes.front());
  const std::string name = arguments.scenes.empty() ? "square" : arguments.scenes.front();
  const std::string backends = arguments.backends.empty() ? "openmp" : arguments.backends.front();
  const auto registry = make_backends();
  Progress progress(ranks.is_first());
  const std::vector<int> counts = counts_up_to(ranks.size());
  progress.set_total(static_cast<double>(counts.size()));
  std::vector<ScalingRow> rows;
  for (const int count : counts) {
    progress.describe(fmt::format("{} ranks", count));
    Scene scene = load_scene(name, {.size = kind == "weak" ? scaled(size, std::sqrt(count)) : size});
    arguments.schedule.apply(scene);
    const RankBackend backend(ranks, registry, backends, arguments.session, {.pieces = count});
    rows.push_back(measure(scene, kind, backend, repeats, ranks));
    progress.advance(1.0);
  }
  progress.clear();
  if (!ranks.is_first()) {
    return success;
  }
  fmt::print("{} scaling, {} on 1 ... {} ranks of this run; medians of {} samples, without making the scene "
             "and opening sessions\n",
             kind, backends, ranks.size(), repeats);
  print_measured(rows);
  nlohmann::json list = nlohmann::json::array();
  for (const ScalingRow& row : rows) {
    list.push_back(to_json_row(row));
  }
  write_results(arguments.json, "scaling", run_context(line, false), std::move(list));
  return success;
}

} // namespace hdmbench::commands
