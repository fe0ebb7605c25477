#pragma once

#include "harness/judge/tradeoff/equal_accuracy.hpp"
#include "harness/judge/tradeoff/tradeoff.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

class Fields;

/// The "kind" of the rows of `tradeoff`.
inline constexpr std::array<std::string_view, 2> tradeoff_kinds{"point", "equal accuracy"};

/// Of either kind.
struct TradeoffKind {
  std::string kind;
};
void list_fields(Fields& fields, TradeoffKind& row);

/// What a row of `tradeoff` is about.
struct TradeoffScene {
  std::string scene;
  std::string title{};
  std::int64_t width = 0;
  std::int64_t height = 0;
  double poisson = 0.0; ///< the scene's
};

/// A row of kind "point": one setting of one method or rival, see TradeoffPoint. Of a point without samples
/// only the status and the reason are there.
struct TradeoffRow : TradeoffScene {
  std::string method{};
  bool is_rival = false;
  std::string effort{};
  bool is_usual = false;
  std::optional<double> poisson_used{};
  std::string backend{};
  std::string device{};
  std::string command{};
  PointStatus status = PointStatus::ok;
  bool valid = true;
  std::string reason{};
  bool is_on_front = false;
  std::vector<double> seconds{};
  std::optional<double> seconds_median{};
  std::optional<double> mean_energy{};
  std::optional<double> fine_sweep_equivalents{};
  std::optional<double> asked{};
  std::optional<double> estimated{};
  std::optional<double> to_fem_nu0{}; ///< RMSD in pixels, as the next two; all three there where ok
  std::optional<double> to_fem{};
  std::optional<double> to_fixed_point{};
};

void list_fields(Fields& fields, TradeoffRow& row);

/// The row of kind "equal accuracy": the fastest method of ours at an accuracy against finite elements, see
/// EqualAccuracy.
struct EqualAccuracyRow : TradeoffScene {
  struct Ours {
    std::string method{};
    std::string effort{};
    std::string backend{};
    double seconds_median = 0.0;
    std::optional<double> to_fem_nu0{};
  };
  struct Rival : Ours {
    double ratio = 1.0; ///< its seconds over ours, with what the samples allow
    double ratio_low = 1.0;
    double ratio_high = 1.0;
  };
  double target = 0.0;
  std::optional<double> nearest{};
  std::optional<Ours> ours{};
  std::optional<Rival> direct{};
  std::optional<Rival> iterative{};
  std::optional<Rival> multigrid{};
  std::optional<Rival> coarse{};
};

void list_fields(Fields& fields, EqualAccuracyRow& row);

[[nodiscard]] TradeoffRow tradeoff_row(const Scene& scene, const TradeoffPoint& point);
[[nodiscard]] EqualAccuracyRow equal_accuracy_row(const Scene& scene, const EqualAccuracy& equal);

} // namespace hdmbench
