#include "harness/cli/run_on_ranks.hpp"

#include "harness/check/compare.hpp"
#include "harness/cli/rank_rows.hpp"
#include "harness/judge/run_row.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/ranks/elastic_solution.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/ranks/ranked_file.hpp"
#include "harness/ranks/ranked_solution.hpp"
#include "harness/ranks/scaling.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

/// Throws InputError where the arithmetic would not be that of one piece.
void require_halo(int halo, bool elastic) {
  const int granule = elastic ? 2 : 4;
  if (halo % granule != 0) {
    throw InputError(fmt::format("--halo {}: a multiple of {}{}, or 0", halo, granule,
                                 elastic ? " for the elastic energy" : ""));
  }
}

/// Collective.
std::vector<SharedLevelRow> rows_of(const std::vector<RankedLevel>& levels, bool counted, Ranks& ranks) {
  std::vector<SharedLevelRow> rows;
  for (const RankedLevel& level : levels) {
    const auto pieces = static_cast<std::int64_t>(level.pieces);
    rows.push_back({.width = level.extent.width,
                    .height = level.extent.height,
                    .columns = level.columns,
                    .rows = pieces / level.columns,
                    .halo = level.halo,
                    .sweeps = level.sweeps,
                    .changed = counted ? std::optional(level.changed) : std::nullopt,
                    .renewals = level.renewals,
                    .messages = ranks.sum(level.halos.messages),
                    .bytes = ranks.sum(level.halos.bytes),
                    .seconds = counted ? std::optional(ranks.largest(level.seconds)) : std::nullopt,
                    .message_seconds = ranks.largest(level.halos.seconds)});
  }
  return rows;
}

void print_levels(const std::vector<SharedLevelRow>& levels, int sweeps_together, bool is_elastic) {
  Table table({"size", "iterations", "still moving", "pieces", "halo", "renewals", "messages", "bytes", "ms",
               "ms in messages"});
  const auto milliseconds = [](const std::optional<double>& seconds) {
    return seconds ? fmt::format("{:.2f}", 1e3 * *seconds) : "-";
  };
  for (const SharedLevelRow& level : levels) {
    table.add({fmt::format("{} x {}", level.width, level.height),
               std::to_string(level.sweeps / sweeps_together),
               level.changed ? fmt::format("{} sites", *level.changed) : "-",
               fmt::format("{} x {}", level.columns, level.rows), std::to_string(level.halo),
               std::to_string(level.renewals), grouped(level.messages), grouped(level.bytes),
               milliseconds(level.seconds), milliseconds(level.message_seconds)});
  }
  fmt::print(
      "{}  pieces: columns x rows, each on a rank of its own; halo: sites that a rank computes beyond "
      "its own;\n  messages and bytes: of all ranks, to renew halos{};\n"
      "  ms: of the slowest rank; in messages: of the one that was the longest in them, with waiting for "
      "others\n",
      table.text(), is_elastic ? ", and to a level in one piece and back" : "");
}

HaloCostsRow row_of(const HaloCosts& costs) {
  const auto rate = [](double seconds) { return seconds > 0.0 ? 1.0 / seconds : 0.0; };
  return {.sites_per_second = rate(costs.site),
          .rim_sites_per_second = rate(costs.rim),
          .message_seconds = costs.message,
          .bytes_per_second = rate(costs.byte)};
}

void print_ranks(const std::vector<RankRow>& rows) {
  Table table(
      {"rank", "<machine", "<backend", "<device", "threads", "own sites", "messages", "MB sent", "peak MB"});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const RankRow& row = rows[i];
    table.add(
        {std::to_string(i), row.machine, row.backend, row.device,
         row.threads > 0 ? std::to_string(row.threads) : "-", grouped(row.sites), grouped(row.messages),
         fmt::format("{:.2f}", static_cast<double>(row.bytes) / 1e6),
         row.peak_memory > 0 ? fmt::format("{:.0f}", static_cast<double>(row.peak_memory) / 1e6) : "-"});
  }
  fmt::print("\n{}", table.text());
}

Sharing sharing_of(const Ranks& ranks, const Scene& scene, const RankArguments& arguments) {
  Sharing sharing{.ranks = ranks.size(), .pieces = ranks.size(), .halo = arguments.halo};
  const bool is_elastic = scene.energy == EnergyModel::elastic;
  if (arguments.sites_per_rank > 0) {
    sharing.fewest_sites = arguments.sites_per_rank;
  } else if (is_elastic) {
    sharing.fewest_sites = elastic_sites_per_rank;
  }
  return is_elastic ? sharing : sharing_for(scene.schedule, sharing);
}

RankedSolution solve(ScenePart part, const Backend& backend, const SessionOptions& options,
                     const Sharing& sharing, Ranks& ranks, Progress& progress) {
  if (part.scene.energy == EnergyModel::elastic) {
    if (const std::string why = why_not_solved(part.scene, backend); !why.empty()) {
      throw InputError(fmt::format("{} {}", backend.name(), why));
    }
    RankedElastic steps(share_elastic(part.scene.extent(), sharing), ranks, ranks,
                        [&] { return backend.open_elastic(options); });
    return solve_elastic_on_ranks(part, steps, ranks, progress);
  }
  const int together = sweeps_per_iteration(part.scene.full);
  const auto session = backend.open(options);
  return solve_on_ranks(ranked_pyramid(std::move(part)), sharing, ranks, ranks, *session, true,
                        [&](double site_updates) { progress.advance(site_updates / together); });
}

} // namespace

int run_scene_on_ranks(const SceneArguments& arguments, const RankArguments& rank_arguments,
                       const std::string& line, Ranks& ranks) {
  const PeakMemory memory;
  Progress progress(ranks.is_first());
  progress.describe(fmt::format("prepare {}", arguments.scene));
  const auto rank = static_cast<std::size_t>(ranks.rank());
  const auto registry = make_backends();
  const Backend& backend = backend_of_rank(registry, arguments.backend, ranks.rank());
  const SessionOptions options = options_of_rank(arguments.session, backend, ranks);
  const Device device = backend.device(options);
  std::optional<HaloCosts> costs; // measured once, where they are needed
  const auto sharing_by = [&](const Scene& scene) {
    const bool is_elastic = scene.energy == EnergyModel::elastic;
    require_halo(rank_arguments.halo, is_elastic);
    Sharing sharing = sharing_of(ranks, scene, rank_arguments);
    if (!is_elastic && sharing.halo == 0) {
      costs = costs ? costs : measure_halo_costs(*backend.open(options), ranks);
      sharing.costs = costs;
    }
    return sharing;
  };
  const auto load = [&](const Sharing& sharing, EnergyModel energy) {
    return arguments.load_part([&](Extent extent) {
      return energy == EnergyModel::elastic ? share_elastic(extent, sharing).image().loaded[rank]
                                            : sharing(extent).loaded[rank];
    });
  };
  Scene expected; // by what is known before it is loaded
  expected.energy = arguments.schedule.energy.value_or(EnergyModel::hdm);
  Sharing sharing = sharing_by(expected);
  ScenePart part = load(sharing, expected.energy);
  const Sharing by_method = sharing_by(part.scene);
  if (part.scene.energy != expected.energy || by_method != sharing) {
    sharing = by_method;
    part = load(sharing, part.scene.energy);
  }
  const Scene scene = part.scene;
  require_shareable(scene);
  const bool made_whole = part.made_whole;
  const fs::path file = rank_arguments.output / (scene.name + ".nrrd");
  if (ranks.is_first()) {
    require_results_writable(rank_arguments.json);
    require_folder(rank_arguments.output, std::vector{file.filename().string()}, arguments.files());
  }

  const bool is_elastic = scene.energy == EnergyModel::elastic;
  const int together = is_elastic ? 1 : sweeps_per_iteration(scene.full);
  progress.set_total(site_updates(scene), WorkUnit::site_updates);
  progress.describe(fmt::format("run {} on {} ranks", scene.name, ranks.size()));
  const double given = ranks.largest(largest_given(part.full, part.start));
  const RankedSolution solution = solve(std::move(part), backend, options, sharing, ranks, progress);
  progress.describe(fmt::format("write {}", file.string()));
  write_displacement_on_ranks(file, scene.extent(), solution.owned, solution.displacement, scene.spacing,
                              scene.placement, ranks);
  progress.clear();

  const double largest = ranks.largest(largest_magnitude(solution.displacement));
  const std::string absurd =
      why_absurd(scene.extent(), given, ranks.largest(largest_found(solution.displacement)));
  const int status = absurd.empty() ? success : disagreement;
  std::int64_t iterations = 0;
  double own_seconds = 0.0;
  for (const RankedLevel& level : solution.levels) {
    iterations += level.sweeps / together;
    own_seconds += level.seconds;
  }
  const double seconds = ranks.largest(own_seconds);
  const Traffic traffic = ranks.traffic();
  RunRow row{.scene = scene.name,
             .title = scene.title,
             .width = scene.extent().width,
             .height = scene.extent().height,
             .backend = arguments.backend,
             .device = device.name,
             .method = method_name(scene),
             .energy = std::string(energy_names[static_cast<std::size_t>(scene.energy)]),
             .seconds = seconds,
             .levels = std::ssize(solution.levels),
             .iterations = iterations,
             .largest_displacement = largest,
             .spacing = scene.spacing,
             .placement = scene.placement,
             .ranks = ranks.size()};
  row.by_rank = gather_rows<RankRow>({{.machine = machine_name(),
                                       .backend = std::string(backend.name()),
                                       .device = device.name,
                                       .threads = backend.threads(options),
                                       .sites = static_cast<std::int64_t>(solution.owned.extent().sites()),
                                       .messages = traffic.messages,
                                       .bytes = traffic.bytes,
                                       .peak_memory = static_cast<std::int64_t>(memory.bytes().value_or(0))}},
                                     ranks);
  if (sharing.costs) {
    row.halo_costs = row_of(*sharing.costs);
  }
  row.shared_levels = rows_of(solution.levels, !is_elastic, ranks);
  if (!ranks.is_first()) {
    return status;
  }
  fmt::print("{}\n{} x {} pixels of {:.4g} mm, {} on {} ranks ({})\n\n", scene.title, scene.extent().width,
             scene.extent().height, scene.spacing, method_name(scene), ranks.size(), arguments.backend);
  print_levels(row.shared_levels, together, is_elastic);
  if (row.halo_costs) {
    fmt::print(
        "  widths of halos by measurement: {:.0f} Msites/s of sweeps, {:.0f} of a rim read and written, "
        "a message {:.1f} us and {:.2f} GB/s; --halo for one of your own\n",
        row.halo_costs->sites_per_second / 1e6, row.halo_costs->rim_sites_per_second / 1e6,
        row.halo_costs->message_seconds * 1e6, row.halo_costs->bytes_per_second / 1e9);
  }
  print_ranks(row.by_rank);
  fmt::print("\n  largest displacement {:.4g} px, {} iterations in {:.3g} s\n", largest, iterations, seconds);
  if (!absurd.empty()) {
    fmt::print("  NO RESULT: {}; look for extreme moduli or targets, or take another --method\n", absurd);
  }
  if (made_whole) {
    fmt::print("  Every rank had the whole scene in memory while it was made: it comes from an image, or a "
               "condition is on what is outside.\n");
  }
  fmt::print("  Not diagnosed, and no pictures: no rank has the whole image.\n"
             "  {}: the displacement in millimetres\n",
             file.string());
  if (!rank_arguments.json.empty()) {
    row.field = fs::proximate(file, fs::absolute(rank_arguments.json).parent_path()).string();
  }
  write_results(rank_arguments.json, "run", run_context(line, false),
                nlohmann::json::array({to_json_row(row)}));
  return status;
}

} // namespace hdmbench::commands
