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
  struct Pictures {
    std::string before{};
    std::string after{};
    std::string grid{};
    std::string magnitude{};
    std::string jacobian{};
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
  nlohmann::json plan{}; ///< plan_row() of a run that was asked for an accuracy or a time
  std::string field{};   ///< file of the displacement; empty: none was written
  std::optional<Pictures> pictures{};
  std::optional<std::int64_t> ranks{}; ///< none: one process
  std::vector<RankRow> by_rank{};
  std::vector<std::string> strains{}; ///< files of `run --strains`
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunRow::Pictures, before, after, grid, magnitude, jacobian)
inline void to_json(nlohmann::json& nlohmann_json_j, const RunRow& nlohmann_json_t) {
  NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_TO, scene, title, width, height, backend, device,
                                           method, energy, seconds, levels, iterations, mean_energy,
                                           largest_displacement, spacing, placement, warnings, plan, field,
                                           pictures, ranks, by_rank, strains))
}

/// {scene, met, fine_sweep_equivalents, asked_px, asked_seconds, estimated_px, steps: [{width, height,
/// action, reason, moved, seconds, expected_error}]}; null is what is not known.
[[nodiscard]] nlohmann::json plan_row(const Scene& scene, const Request& request, const Plan& plan);

} // namespace hdmbench
