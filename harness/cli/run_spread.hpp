#pragma once

#include "harness/applications/spread.hpp"
#include "harness/cli/arguments.hpp"

#include <optional>
#include <string>
#include <vector>

/// How sure `run` is of its displacement.
namespace hdmbench::commands {

/// Returns where a place among the sites lies in the patient, mm (LPS).
[[nodiscard]] Placement::Vector place_of(const Scene& scene, const std::array<double, 3>& at);

/// The options --uncertainty, --uncertain-moduli, --spread and --mean.
[[nodiscard]] Options spread_options();

struct SpreadOfRun {
  std::optional<SpreadRequest> asked{}; ///< none: nobody asks how sure the displacement is
  std::optional<Spread> found{};        ///< draw_spread()
};

/// Returns what --uncertainty, --uncertain-moduli and --seed ask for. The seed is taken out of the call's
/// schedule, where it would be that of annealing. Throws InputError for a seed or a number of draws that is
/// none.
[[nodiscard]] SpreadOfRun asked_spread(Call& call);

/// Throws InputError where what is asked for means nothing to the scene, or its files cannot be written.
/// `names` are those that run writes anyway into its folder.
void require_spread(const Call& call, const Scene& scene, const SpreadOfRun& how_sure,
                    const std::vector<std::string>& names);

/// Finds the spread where one is asked for, and adds the seconds to the phases of the run. `solution` is the
/// scene's displacement, pixels.
void draw_spread(const Scene& scene, const VectorField& solution, const Backend& backend,
                 const SessionOptions& session, Progress& progress, SpreadOfRun& how_sure,
                 nlohmann::json& phases);

/// Prints how sure the displacement is and where it is least so, writes the files of --spread and --mean, and
/// puts all into the row of the run; nothing where no spread was asked for.
void report_spread(const Call& call, const Scene& scene, const SpreadOfRun& how_sure, nlohmann::json& row);

} // namespace hdmbench::commands
