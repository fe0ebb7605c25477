#pragma once

#include "backends/backend.hpp"
#include "harness/scene/schedule_overrides.hpp"
#include "harness/solve/planner.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>

/// How the command line and Python solve one scene as it was asked for.
namespace hdmbench {

/// Returns pixels, > 0, of "0.2px" or "0.2"; where it is known how many millimetres a pixel has, also of
/// "0.1mm". Throws InputError.
[[nodiscard]] double parse_pixels(const std::string& text, std::optional<double> spacing = {});
/// Returns seconds, > 0, of "10ms", "2s" or "2". Throws InputError.
[[nodiscard]] double parse_seconds(const std::string& text);

/// Returns what is asked for in the words of the command line, nothing of empty ones, of a scene whose pixels
/// have sides of `spacing` millimetres. Throws InputError.
[[nodiscard]] Request parse_request(const std::string& accuracy, const std::string& within, double spacing);

/// Whether something is asked for: the scene is solved by a plan, else by its own method.
[[nodiscard]] inline bool asks(const Request& request) {
  return request.accuracy || request.seconds;
}

/// Throws InputError for a request with an energy, which `says` asks for, that does not come near to finite
/// elements.
void require_near_finite_elements(const RegisteredEnergy& energy, std::string_view says);

/// Returns the scene that `load` gives with the `schedule`, which gets an energy that comes near to finite
/// elements where something `is_asked` and it has none. Throws InputError where the scene file names another
/// one, and what `load` throws.
[[nodiscard]] Scene load_to_solve(ScheduleOverrides& schedule, bool is_asked,
                                  const std::function<Scene()>& load);

/// Throws InputError for a body that nothing holds, pulls or has moved: any displacement would do.
void require_held(const Scene& scene);

/// Returns the backend of that name. Throws InputError where it is unknown or cannot update as the scene
/// wants.
[[nodiscard]] const Backend& choose_backend(const std::vector<std::unique_ptr<Backend>>& registry,
                                            std::string_view name, const Scene& scene);

/// What a scene was solved by: a plan where an accuracy or a time was asked for, else its own method.
struct Answer {
  std::optional<Plan> plan;
  Solution unplanned;

  [[nodiscard]] const Solution& solution() const { return plan ? plan->solution : unplanned; }
};

/// Solves the scene, which is as it was in the end. Throws InputError as require_held() and Solver do, and
/// what Session throws.
[[nodiscard]] Answer solve_request(Scene& scene, const Request& request, const Backend& backend,
                                   const SessionOptions& session, Progress& progress);

} // namespace hdmbench
