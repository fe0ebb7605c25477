#pragma once

#include "harness/judge/judge.hpp"
#include "harness/scene/method.hpp"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What a method is told to do.
struct Effort {
  int iterations = 0; ///< what --iterations takes
  int stride = 1;     ///< what --stride takes
};

/// The settings a method is measured at on an image, rising, its usual effort among them unless quick.
/// `own_iterations` are the scene's, the usual effort of the methods that have none. With `quick` the two
/// smallest on the full resolution; else full multigrid also solves sampled images, the coarsest first.
[[nodiscard]] std::vector<Effort> efforts(const Method& method, int own_iterations, Extent image, bool quick);

/// "4 cycles", "1 iteration on the full resolution", "2 cycles on every 8th pixel".
[[nodiscard]] std::string effort_text(const Method& method, Effort effort);

/// The effort on every backend: the method's usual one or the scene's, less for annealing.
[[nodiscard]] int usual_effort(const Method& method, int own_iterations);

/// The method name of rows for which an accuracy was requested (harness/solve/planner.hpp).
inline constexpr std::string_view requested_name = "as-needed-elastic";

struct TradeoffOptions {
  SessionOptions session{};
  int repeats = 3; ///< samples per row, fewer where they take long
  /// Names of methods and rivals; empty: all.
  std::vector<std::string> methods{};
  bool quick = false; ///< fewer efforts, one sample
  /// The line that repeats a row of `method` on `backend`, see harness/cli/tradeoff.cpp; a rival has no
  /// effort and no backend.
  std::function<std::string(std::string_view method, std::optional<Effort> effort, std::string_view backend)>
      command{};
  /// The same of a request for an accuracy in pixels.
  std::function<std::string(double asked, std::string_view backend)> request_command{};
};

/// Every method at all its efforts on Judge::main_place() and at its usual effort on the other backends, what
/// `run --accuracy` gives, and every rival: rows by method, effort and backend, then rivals. The first
/// backend is the reference for bits. What fails is a row with the reason. Throws InputError for an unknown
/// method and as find_truths does.
[[nodiscard]] std::vector<Judged> measure_tradeoff(const Scene& scene,
                                                   std::span<const Backend* const> backends,
                                                   const TradeoffOptions& options, Progress& progress);

} // namespace hdmbench
