#include "harness/cli/bench_on_ranks.hpp"

#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/measure/scaling_row.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/ranks/scaling.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::commands {

namespace {

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

/// The schedule of the scene on an image of another extent.
std::vector<PyramidLevel> levels_of(Scene scene, Extent extent) {
  scene.full.extent = extent;
  ScenePart part;
  part.scene = std::move(scene);
  return ranked_pyramid(std::move(part)).levels;
}

class ScalingBench {
public:
  ScalingBench(const CommonArguments& arguments, std::string scene, std::string kind, Extent size,
               Ranks& ranks)
      : arguments_(arguments), scene_(std::move(scene)), kind_(std::move(kind)), size_(size), ranks_(ranks),
        registry_(make_backends()),
        backends_(arguments.backends.empty() ? "openmp" : arguments.backends.front()),
        backend_(backend_of_rank(registry_, backends_, ranks.rank())),
        session_(backend_.open(options_of_rank(arguments.session, backend_, ranks))) {}

  /// Collective, as the others.
  void measure_rates() {
    ScenePart part = load(size_, ranks_.size());
    if (ranks_.largest(part.full.extent.sites() == 0 ? 1.0 : 0.0) > 0.0) {
      throw InputError("the image is too small: a rank has nothing to compute; give a larger --size");
    }
    outline_ = part.scene;
    rates_ = hdmbench::measure_rates(part.full, *session_, ranks_, AtWork::all);
    rates_alone_ = hdmbench::measure_rates(part.full, *session_, ranks_, AtWork::first);
  }

  [[nodiscard]] ScalingRow measure(int count, int repeats) {
    const Extent extent = kind_ == "weak" ? scaled(size_, std::sqrt(count)) : size_;
    ScalingRow row = modelled(extent, count, count == 1 ? rates_alone_ : rates_);
    const Sharing sharing = sharing_of(count);
    for (int i = 0; i < repeats; ++i) {
      const Traffic before = ranks_.traffic();
      const RankedSolution solution =
          solve_on_ranks(ranked_pyramid(load(extent, count)), sharing, ranks_, ranks_, *session_, false);
      double own = 0.0;
      for (const RankedLevel& level : solution.levels) {
        own += level.seconds;
      }
      row.seconds.push_back(ranks_.largest(own));
      row.messages = ranks_.sum(ranks_.traffic().messages - before.messages);
      row.bytes = ranks_.sum(ranks_.traffic().bytes - before.bytes);
    }
    return row;
  }

  [[nodiscard]] ScalingRow modelled(Extent extent, int count, const RankRates& rates) const {
    const Sharing sharing{.ranks = count, .pieces = count};
    return {.scene = scene_,
            .scaling = kind_,
            .backend = backends_,
            .ranks = count,
            .width = extent.width,
            .height = extent.height,
            .seconds = {},
            .modelled_seconds = predicted_seconds(levels_of(outline_, extent), sharing, rates)};
  }

  [[nodiscard]] const RankRates& rates() const { return rates_; }
  [[nodiscard]] const std::string& backends() const { return backends_; }

private:
  [[nodiscard]] Sharing sharing_of(int count) const { return {.ranks = ranks_.size(), .pieces = count}; }

  [[nodiscard]] ScenePart load(Extent extent, int count) const {
    const auto rank = static_cast<std::size_t>(ranks_.rank());
    ScenePart part = load_scene_part(scene_, {.size = extent},
                                     [&](Extent whole) { return sharing_of(count)(whole).loaded[rank]; });
    arguments_.schedule.apply(part.scene);
    require_shareable(part.scene);
    if (sharing_for(part.scene.schedule, sharing_of(count)) != sharing_of(count)) {
      throw InputError(
          fmt::format("bench --scaling models icm and closed-form, not {}; run tells its seconds",
                      part.scene.schedule.method));
    }
    return part;
  }

  const CommonArguments& arguments_;
  std::string scene_;
  std::string kind_;
  Extent size_;
  Ranks& ranks_;
  std::vector<std::unique_ptr<Backend>> registry_;
  std::string backends_;
  const Backend& backend_;
  std::unique_ptr<Session> session_;
  Scene outline_; ///< without fields
  RankRates rates_;
  RankRates rates_alone_; ///< of a rank that has the machine for itself
};

void print_measured(const std::vector<ScalingRow>& rows) {
  Table table({"ranks", "size", "seconds", "speed-up", "efficiency", "fastest", "modelled", "it is off by",
               "messages", "MB sent"});
  const double one = median(rows.front().seconds);
  for (const ScalingRow& row : rows) {
    const double seconds = median(row.seconds);
    const double work = static_cast<double>(row.width) * static_cast<double>(row.height) /
                        (static_cast<double>(rows.front().width) * static_cast<double>(rows.front().height));
    const double speed_up = work * one / seconds;
    table.add({std::to_string(row.ranks), fmt::format("{} x {}", row.width, row.height),
               fmt::format("{:.4f}", seconds), fmt::format("{:.2f}", speed_up),
               fmt::format("{:.0f} %", 100.0 * speed_up / static_cast<double>(row.ranks)),
               fmt::format("{:.4f}", std::ranges::min(row.seconds)),
               fmt::format("{:.4f}", row.modelled_seconds),
               fmt::format("{:+.0f} %", 100.0 * model_error(row)), grouped(row.messages),
               fmt::format("{:.2f}", static_cast<double>(row.bytes) / 1e6)});
  }
  fmt::print("{}", table.text());
}

void print_modelled(const std::vector<ScalingRow>& rows) {
  Table table({"ranks", "seconds", "speed-up", "efficiency"});
  const double one = rows.front().modelled_seconds;
  for (const ScalingRow& row : rows) {
    const double speed_up = one / row.modelled_seconds;
    table.add({std::to_string(row.ranks), fmt::format("{:.4g}", row.modelled_seconds),
               fmt::format("{:.1f}", speed_up),
               fmt::format("{:.0f} %", 100.0 * speed_up / static_cast<double>(row.ranks))});
  }
  const WorthRanks worth = worth_ranks(rows);
  fmt::print("\nModelled, not measured: {} x {}, every rank and the network as fast as here\n{}"
             "  twice as many ranks save less than a tenth beyond {}{}\n",
             rows.front().width, rows.front().height, table.text(), worth.ranks,
             worth.ends ? "" : ", or later: the table ends");
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
  Progress progress(ranks.is_first());
  progress.describe("measure the rates of a rank");
  const Extent size = arguments.sizes.empty() ? Extent{1024, 1024} : parse_size(arguments.sizes.front());
  ScalingBench bench(arguments, arguments.scenes.empty() ? "square" : arguments.scenes.front(), kind, size,
                     ranks);
  bench.measure_rates();
  std::vector<ScalingRow> measured;
  const std::vector<int> counts = counts_up_to(ranks.size());
  progress.set_total(static_cast<double>(counts.size()));
  for (const int count : counts) {
    progress.describe(fmt::format("{} ranks", count));
    measured.push_back(bench.measure(count, repeats));
    progress.advance(1.0);
  }
  progress.clear();
  if (!ranks.is_first()) {
    return success;
  }
  constexpr Extent large{65536, 65536};
  std::vector<ScalingRow> modelled;
  constexpr int most = 10'000;
  for (const int count : counts_up_to(most)) {
    modelled.push_back(bench.modelled(large, count, bench.rates()));
  }
  const RankRates& rates = bench.rates();
  fmt::print(
      "{} scaling, {} on 1 ... {} ranks of this run; medians of {} samples, without making the scene\n", kind,
      bench.backends(), ranks.size(), repeats);
  print_measured(measured);
  for (const PieceRates& piece : rates.pieces) {
    fmt::print(
        "  a rank with {} sites while all work: {:.1f} Msites/s of sweeps, {:.1f} sampled, {:.1f} projected, "
        "{:.1f} loaded, {:.1f} read and written\n",
        grouped(static_cast<std::int64_t>(piece.sites)), piece.sweep / 1e6, piece.sample / 1e6,
        piece.project / 1e6, piece.load / 1e6, piece.copy / 1e6);
  }
  fmt::print("  a message: {:.1f} us, {:.2f} GB/s\n", rates.latency * 1e6, rates.bandwidth / 1e9);
  print_modelled(modelled);
  nlohmann::json rows = nlohmann::json::array();
  for (const auto* const list : {&measured, &modelled}) {
    for (const ScalingRow& row : *list) {
      rows.push_back(to_json_row(row));
    }
  }
  write_results(arguments.json, "scaling", run_context(line, false), std::move(rows));
  return success;
}

} // namespace hdmbench::commands
