#pragma once

#include "harness/cli/arguments.hpp"

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

/// What `run` says of points that have moved.
namespace hdmbench::commands {

inline const Option<bool> leave_one_out("--leave-one-out",
                                        "Of points: solve also without each of them in turn, and say how far "
                                        "the displacement there is from it: what the others tell of it");

/// Throws InputError where --leave-one-out is asked for and the scene has no points.
void require_points(const Call& call, const Scene& scene);

/// Where --leave-one-out asks for it, returns for each of the scene's points how far the displacement there
/// is from it, pixels, where all others act but it does not; none where nothing holds the body without it.
/// Empty where nobody asks. `solve` gives the displacement of a scene; the scene itself has one. Adds the
/// seconds to the phases of the run.
[[nodiscard]] std::vector<std::optional<double>>
misses_left_out(Call& call, std::size_t points, const std::function<VectorField(Scene& scene)>& solve,
                nlohmann::json& phases);

/// Prints how far the displacement is from what is known at points, and puts it into the row of the run.
/// `left_out` as misses_left_out() has it.
void report_points(const Scene& scene, const VectorField& displacement,
                   const std::vector<std::optional<double>>& left_out, nlohmann::json& row);

} // namespace hdmbench::commands
