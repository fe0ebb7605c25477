#pragma once

#include "harness/judge/diagnosis/diagnosis.hpp"
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
  std::int64_t messages = 0;    ///< that it sent
  std::int64_t bytes = 0;       ///< in these
  std::int64_t peak_memory = 0; ///< bytes; 0: the system does not tell
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RankRow, machine, backend, device, threads, messages, bytes, peak_memory)

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
  std::vector<std::string> strains{}; ///< files of `run --strains`
};

void to_json(nlohmann::json& written, const RunRow& row);

[[nodiscard]] RunRow::PlanRow plan_row(const Scene& scene, const Request& request, const Plan& plan);

} // namespace hdmbench
