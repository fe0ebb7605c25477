#include "harness/cli/bench_on_ranks.hpp"

#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/measure/scaling_row.hpp"
#include "harness/ranks/elastic_solution.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/ranks/scaling.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

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
        options_(options_of_rank(arguments.session, backend_, ranks)),
        outline_(load(size, [](Extent) { return Rectangle{}; }).scene) {
    if (!is_elastic()) {
      session_ = backend_.open(options_);
      halo_costs_ = measure_halo_costs(*session_, ranks);
    } else if (const std::string why = why_not_solved(outline_, backend_); !why.empty()) {
      throw InputError(fmt::format("{} {}", backend_.name(), why));
    }
  }

  /// Whose scaling is not modelled.
  [[nodiscard]] bool is_elastic() const { return outline_.energy == EnergyModel::elastic; }

  /// Collective, as the others.
  void measure_rates() {
    const ScenePart part = load(size_, owner(sharing_of(ranks_.size())));
    if (ranks_.largest(part.full.extent.sites() == 0 ? 1.0 : 0.0) > 0.0) {
      throw InputError("the image is too small: a rank has nothing to compute; give a larger --size");
    }
    rates_ = hdmbench::measure_rates(part.full, *session_, ranks_, AtWork::all);
    rates_alone_ = hdmbench::measure_rates(part.full, *session_, ranks_, AtWork::first);
  }

  [[nodiscard]] ScalingRow measure(int count, int repeats) {
    const Extent extent = kind_ == "weak" ? scaled(size_, std::sqrt(count)) : size_;
    ScalingRow row =
        is_elastic() ? row_of(extent, count) : modelled(extent, count, count == 1 ? rates_alone_ : rates_);
    for (int i = 0; i < repeats; ++i) {
      const Traffic before = ranks_.traffic();
      const RankedSolution solution = is_elastic() ? solve_elastic(extent, count) : solve(extent, count);
      double own = 0.0;
      for (const RankedLevel& level : solution.levels) {
        own += level.seconds;
      }
      row.seconds.push_back(ranks_.largest(own));
      row.messages = ranks_.sum(ranks_.traffic().messages - before.messages);
      row.bytes = ranks_.sum(ranks_.traffic().bytes - before.bytes);
      const double in_messages = ranks_.largest(ranks_.traffic().seconds - before.seconds);
      row.message_seconds = std::min(in_messages, row.message_seconds.value_or(in_messages));
    }
    return row;
  }

  [[nodiscard]] ScalingRow modelled(Extent extent, int count, const RankRates& rates) const {
    ScalingRow row = row_of(extent, count);
    Sharing sharing = sharing_of(count);
    sharing.ranks = count;
    row.modelled_seconds = predicted_seconds(levels_of(outline_, extent), sharing, rates);
    return row;
  }

  [[nodiscard]] const RankRates& rates() const { return rates_; }
  [[nodiscard]] const std::string& backends() const { return backends_; }

private:
  using Part = std::function<Rectangle(Extent)>;

  [[nodiscard]] ScalingRow row_of(Extent extent, int count) const {
    return {.scene = scene_,
            .energy = std::string(energy_names[static_cast<std::size_t>(outline_.energy)]),
            .scaling = kind_,
            .backend = backends_,
            .ranks = count,
            .width = extent.width,
            .height = extent.height};
  }

  [[nodiscard]] Sharing sharing_of(int count) const {
    return {.ranks = ranks_.size(),
            .pieces = count,
            .fewest_sites = is_elastic() ? elastic_sites_per_rank : Sharing{}.fewest_sites,
            .costs = halo_costs_};
  }
  [[nodiscard]] Part owner(const Sharing& sharing) const {
    return [this, sharing](Extent whole) {
      return sharing(whole).loaded[static_cast<std::size_t>(ranks_.rank())];
    };
  }

  [[nodiscard]] RankedSolution solve(Extent extent, int count) {
    const Sharing sharing = sharing_of(count);
    return solve_on_ranks(ranked_pyramid(load(extent, owner(sharing))), sharing, ranks_, ranks_, *session_,
                          false);
  }
  /// As of one process: from the cells of all levels to the displacement on the host.
  [[nodiscard]] RankedSolution solve_elastic(Extent extent, int count) {
    const ElasticShare share = share_elastic(extent, sharing_of(count));
    const ScenePart part =
        load(extent, [&](Extent) { return share.image().loaded[static_cast<std::size_t>(ranks_.rank())]; });
    RankedElastic steps(share, ranks_, ranks_, [&] { return backend_.open_elastic(options_); });
    Progress silent(false);
    return solve_elastic_on_ranks(part, steps, ranks_, silent);
  }

  [[nodiscard]] ScenePart load(Extent extent, const Part& loaded) const {
    ScenePart part = load_scene_part(scene_, {.size = extent}, loaded);
    arguments_.schedule.apply(part.scene);
    require_shareable(part.scene);
    if (part.scene.energy == EnergyModel::hdm &&
        sharing_for(part.scene.schedule, Sharing{}) != Sharing{}) { // whose pieces are rows
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
  SessionOptions options_;
  Scene outline_;                    ///< without fields
  std::unique_ptr<Session> session_; ///< none for the elastic energy
  std::optional<HaloCosts> halo_costs_;
  RankRates rates_;
  RankRates rates_alone_; ///< of a rank that has the machine for itself
};

void print_measured(const std::vector<ScalingRow>& rows) {
  Table table({"ranks", "size", "seconds", "speed-up", "efficiency", "fastest", "modelled", "it is off by",
               "messages", "MB sent", "ms in messages"});
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
               row.modelled_seconds ? fmt::format("{:.4f}", *row.modelled_seconds) : "-",
               model_error_text(row), grouped(row.messages),
               fmt::format("{:.2f}", static_cast<double>(row.bytes) / 1e6),
               fmt::format("{:.2f}", 1e3 * row.message_seconds.value_or(0.0))});
  }
  fmt::print(
      "{}  in messages: the rank that was the longest in them, with waiting for others, the least of the "
      "samples\n",
      table.text());
}

void print_modelled(const std::vector<ScalingRow>& rows) {
  Table table({"ranks", "seconds", "speed-up", "efficiency"});
  const double one = rows.front().modelled_seconds.value();
  for (const ScalingRow& row : rows) {
    const double speed_up = one / row.modelled_seconds.value();
    table.add({std::to_string(row.ranks), fmt::format("{:.4g}", row.modelled_seconds.value()),
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
  const Extent size = arguments.sizes.empty() ? Extent{1024, 1024} : parse_size(arguments.sizes.front());
  ScalingBench bench(arguments, arguments.scenes.empty() ? "square" : arguments.scenes.front(), kind, size,
                     ranks);
  if (!bench.is_elastic()) {
    progress.describe("measure the rates of a rank");
    bench.measure_rates();
  }
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
  for (const int count : bench.is_elastic() ? std::vector<int>{} : counts_up_to(most)) {
    modelled.push_back(bench.modelled(large, count, bench.rates()));
  }
  const RankRates& rates = bench.rates();
  fmt::print("{} scaling, {} on 1 ... {} ranks of this run; medians of {} samples, without making the scene "
             "and opening sessions\n",
             kind, bench.backends(), ranks.size(), repeats);
  print_measured(measured);
  for (const PieceRates& piece : rates.pieces) {
    fmt::print(
        "  a rank with {} sites while all work: {:.1f} Msites/s of sweeps, {:.1f} sampled, {:.1f} projected, "
        "{:.1f} loaded, {:.1f} read and written\n",
        grouped(static_cast<std::int64_t>(piece.sites)), piece.sweep / 1e6, piece.sample / 1e6,
        piece.project / 1e6, piece.load / 1e6, piece.copy / 1e6);
  }
  if (!modelled.empty()) {
    fmt::print("  a message: {:.1f} us, {:.3f} ns a byte\n", rates.halos.message * 1e6,
               rates.halos.byte * 1e9);
    print_modelled(modelled);
  }
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
