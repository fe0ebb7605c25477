#pragma once

#include "backends/backend.hpp"
#include "harness/judge/accuracy/truths.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

enum class PointStatus {
  ok,
  unverified, ///< solved, but the field is not scalar's to the bit for the same setting
  failed,     ///< threw, not finite, or diverged
  skipped,    ///< the backend is not there or does not update in this order
};

/// The method name of points for which an accuracy was requested (harness/solve/planner.hpp).
inline constexpr std::string_view requested_name = "as-needed-elastic";

/// In results, in the order of the enumerators.
inline constexpr std::array<std::string_view, 4> status_names{"ok", "unverified", "failed", "skipped"};

[[nodiscard]] constexpr const auto& names_of(PointStatus) {
  return status_names;
}
[[nodiscard]] inline std::string_view name_of(PointStatus status) {
  return status_names.at(static_cast<std::size_t>(status));
}

/// One setting of one method or rival: a point of the chart.
struct TradeoffPoint {
  std::string method; ///< of harness/scene/method.hpp, or one of rival_names
  bool is_rival = false;
  std::string effort;                 ///< for people: "4 cycles", "tolerance 1e-04"
  bool is_usual = false;              ///< the method's usual effort
  std::optional<double> poisson_used; ///< of finite elements and elastic energy
  std::string backend;                ///< empty for rivals
  Device device;
  std::string command; ///< the line that repeats it
  PointStatus status = PointStatus::ok;
  std::string reason;          ///< why the status is not ok
  std::vector<double> seconds; ///< raw samples of the whole solution; none without a result
  Deviations deviations;       ///< where there are seconds
  double mean_energy = 0.0;    ///< where there are seconds
  std::optional<double>
      fine_sweep_equivalents;        ///< site updates over sites of the full image; none for rivals
  std::optional<double> asked{};     ///< of requested_name: the accuracy asked for, pixels
  std::optional<double> estimated{}; ///< as reached() and as the method itself estimates it, pixels
  bool is_on_front = false; ///< median seconds against RMSD to FEM nu 0, over all points of status ok
};

/// What a request is for: RMSD to finite elements with the Poisson ratio used, to the fixed point where none
/// was; pixels.
[[nodiscard]] inline double reached(const TradeoffPoint& point) {
  const Deviations& deviations = point.deviations;
  return !point.poisson_used          ? deviations.to_fixed_point
         : *point.poisson_used == 0.0 ? deviations.to_fem_no_poisson
                                      : deviations.to_fem;
}

} // namespace hdmbench
