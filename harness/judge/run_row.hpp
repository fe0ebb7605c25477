#pragma once

#include "harness/judge/diagnosis/warning.hpp"
#include "harness/solve/planner.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

/// What one rank did of a run on several.
struct RankRow {
  std::string machine;
  std::string backend;
  std::string device;
  std::int64_t threads = 0;     ///< of its own, 0: its driver decides
  std::int64_t sites = 0;       ///< that it owns of the full resolution
  std::int64_t messages = 0;    ///< that it sent
  std::int64_t bytes = 0;       ///< in these
  std::int64_t peak_memory = 0; ///< bytes; 0: the system does not tell
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RankRow, machine, backend, device, threads, sites, messages, bytes,
                                   peak_memory)

/// A level as several ranks shared it out; messages and bytes are those of all ranks, to renew halos. Of the
/// elastic energy's first level in one piece: to bring loads there and corrections back, `renewals` times.
struct SharedLevelRow {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t columns = 1; ///< of pieces
  std::int64_t rows = 1;
  std::int64_t halo = 0; ///< sites
  std::int64_t sweeps = 0;
  std::optional<std::int64_t> changed{}; ///< sites, by the last sweep; none where nobody counts
  std::int64_t renewals = 0;
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
  std::optional<double> seconds{};         ///< of the slowest rank; none: of the elastic energy
  std::optional<double> message_seconds{}; ///< in messages, of the rank that was the longest in them; with
                                           ///< waiting for others
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SharedLevelRow, width, height, columns, rows, halo, sweeps, changed,
                                   renewals, messages, bytes, seconds, message_seconds)

/// What was measured to choose the width of halos.
struct HaloCostsRow {
  double sites_per_second = 0.0;     ///< of a sweep
  double rim_sites_per_second = 0.0; ///< read and written; 0: too fast to tell
  double message_seconds = 0.0;
  double bytes_per_second = 0.0;
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HaloCostsRow, sites_per_second, rim_sites_per_second, message_seconds,
                                   bytes_per_second)

/// The row of `run`: what came out of one solution. Paths are relative to the result file.
struct RunRow {
  struct Pictures { ///< empty: not written
    std::string before{};
    std::string after{};
    std::string grid{};
    std::string magnitude{};
    std::string jacobian{};
  };
  /// Of a run that was asked for an accuracy or a time.
  struct PlanRow {
    std::string scene;
    bool met = false;
    double fine_sweep_equivalents = 0.0;
    std::vector<PlanStep> steps{};
    std::optional<double> asked_px{};
    std::optional<double> asked_seconds{};
    std::optional<double> estimated_px{};
  };
  std::string scene;
  std::string title;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string method;         ///< method_name(), or "as needed"
  std::string energy = "hdm"; ///< of energy_names
  double seconds = 0.0;
  std::int64_t levels = 0;
  std::int64_t iterations = 0;
  std::optional<double> mean_energy{};
  std::optional<double> largest_displacement{}; ///< pixels
  double spacing = 1.0;                         ///< millimetres per pixel
  Placement placement{};                        ///< of the field and its pictures in the patient
  std::vector<Warning> warnings{};
  std::optional<PlanRow> plan{};
  std::string field{}; ///< file of the displacement; empty: none was written
  std::optional<Pictures> pictures{};
  std::optional<std::int64_t> ranks{}; ///< none: one process
  std::vector<RankRow> by_rank{};
  std::vector<SharedLevelRow> shared_levels{};
  std::optional<HaloCostsRow> halo_costs{}; ///< none: nothing was measured for it
  std::vector<std::string> strains{};       ///< files of `run --strains`
};

void to_json(nlohmann::json& written, const RunRow& row);

[[nodiscard]] RunRow::PlanRow plan_row(const Scene& scene, const Request& request, const Plan& plan);

} // namespace hdmbench
