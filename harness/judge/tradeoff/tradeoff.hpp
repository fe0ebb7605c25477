#pragma once

#include "backends/backend.hpp"
#include "harness/judge/tradeoff/efforts.hpp"
#include "harness/judge/tradeoff/point.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

struct TradeoffOptions {
  SessionOptions session{};
  int repeats = 3;           ///< samples per point, >= 1 ...
  double most_seconds = 0.6; ///< ... fewer once those of a point add up to this
  /// Names of methods and rivals; empty: all.
  std::vector<std::string> methods{};
  bool quick = false; ///< fewer efforts, one sample
  /// The line that repeats a point of `method` on `backend`, see harness/cli/tradeoff.cpp; a rival has no
  /// effort and no backend.
  std::function<std::string(std::string_view method, std::optional<Effort> effort, std::string_view backend)>
      command{};
  /// The same of a request for an accuracy in pixels.
  std::function<std::string(double asked, std::string_view backend)> request_command{};
};

struct SceneTradeoff {
  Truths truths;
  std::vector<TradeoffPoint> points; ///< methods by effort and backend, then rivals
};

/// Every method at all its efforts on openmp (scalar where that cannot, the first that can where openmp is
/// not among `backends`) and at its usual effort on the others, and every rival, each timed and measured
/// against the truths. The first backend is the reference for bits. What fails is a point with the reason.
/// Throws InputError for an unknown method and as find_truths does.
[[nodiscard]] SceneTradeoff measure_tradeoff(const Scene& scene, std::span<const Backend* const> backends,
                                             const TradeoffOptions& options, Progress& progress);

/// Sets is_on_front of all points.
void mark_front(std::vector<TradeoffPoint>& points);

} // namespace hdmbench
