#include "harness/cli/bench.hpp"

#include "harness/measure/median.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"

#include <cmath>
#include <limits>

namespace hdmbench::commands {

namespace {

/// With sides `factor` times as long, multiples of 4.
Extent scaled(Extent extent, double factor) {
  const auto side = [&](int sites) {
    return factor == 1.0 ? sites : 4 * static_cast<int>(std::lround(sites * factor / 4.0));
  };
  return {side(extent.width), side(extent.height)};
}

/// A row of results: samples of whole solutions without making the scene and opening sessions, and messages
/// and bytes of all ranks in one of them. "message_seconds" are those of the rank that was the longest in
/// messages, the least of the samples. Collective.
json measure(const Scene& scene, const std::string& kind, const RankBackend& backend, int repeats,
             Ranks& ranks) {
  json row{{"scene", scene.name},
           {"energy", scene.energy->name},
           {"scaling", kind},
           {"backend", backend.backends()},
           {"ranks", backend.ranks()},
           {"width", scene.extent().width},
           {"height", scene.extent().height},
           {"seconds", json::array()}};
  Progress silent(false);
  Solver solver(backend, {});
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= repeats; ++i) { // the first time is slower: shaders are compiled, memory is new
    const Traffic before = ranks.traffic();
    const double seconds = ranks.largest(solver.solve(scene, silent).timings.total());
    row["messages"] = ranks.sum(ranks.traffic().messages - before.messages);
    row["bytes"] = ranks.sum(ranks.traffic().bytes - before.bytes);
    const double in_messages = ranks.largest(ranks.traffic().seconds - before.seconds);
    if (i > 0) {
      row["seconds"].push_back(seconds);
      least = std::min(least, in_messages);
    }
  }
  row["message_seconds"] = least;
  return row;
}

/// The rows, each with what it comes to beside the first one in place of its samples.
json judged(json rows) {
  const double pixels = rows[0]["width"].get<double>() * rows[0]["height"].get<double>();
  const double first = median(rows[0]["seconds"].get<std::vector<double>>());
  for (json& row : rows) {
    const double seconds = median(row["seconds"].get<std::vector<double>>());
    const double speed_up =
        row["width"].get<double>() * row["height"].get<double>() / pixels * first / seconds;
    row.update({{"seconds", seconds},
                {"speed-up", speed_up},
                {"efficiency", speed_up / row["ranks"].get<double>()}});
  }
  return rows;
}

} // namespace

int bench_on_ranks(const BenchArguments& arguments, const Call& call, Ranks& ranks) {
  const std::string kind = arguments.scenes.empty() ? "" : arguments.scenes.front();
  if (!arguments.scaling || (kind != "strong" && kind != "weak")) {
    throw InputError("on several ranks: bench --scaling strong (the same image on more ranks) or bench "
                     "--scaling weak (an image that grows with them), then a scene");
  }
  if (arguments.scenes.size() > 2 || arguments.sizes.size() > 1 || arguments.backends.size() > 1) {
    throw InputError("bench --scaling on ranks takes one scene, one size and one backend");
  }
  const Extent size = arguments.sizes.empty() ? Extent{1024, 1024} : parse_size(arguments.sizes.front());
  const std::string name = arguments.scenes.size() > 1 ? arguments.scenes[1] : "square";
  const std::string backends = arguments.backends.empty() ? "openmp" : arguments.backends.front();
  const auto registry = make_backends();
  Progress progress(ranks.is_first());
  json rows = json::array();
  for (int count = 1; count <= ranks.size();) { // 1, 2, 4 ... and all
    progress.describe(fmt::format("{} ranks", count));
    Scene scene = load_scene(name, {.size = kind == "weak" ? scaled(size, std::sqrt(count)) : size});
    arguments.schedule.apply(scene);
    const RankBackend backend(ranks, registry, backends, arguments.session, {.pieces = count});
    rows.push_back(measure(scene, kind, backend, arguments.repeats, ranks));
    count = count == ranks.size() ? count + 1 : std::min(2 * count, ranks.size());
  }
  progress.clear();
  if (!ranks.is_first()) {
    return success;
  }
  fmt::print(
      "{} scaling, {} on 1 ... {} ranks of this run; medians of {} samples, without making the scene "
      "and opening sessions\n{}"
      "  in messages: the rank that was the longest in them, with waiting for others, the least of the "
      "samples\n",
      kind, backends, ranks.size(), arguments.repeats,
      table_text(judged(rows), "ranks|size|seconds|speed-up|efficiency|messages|bytes:bytes sent|"
                               "message_seconds:s in messages"));
  call.write(std::move(rows), false, "scaling");
  return success;
}

} // namespace hdmbench::commands
