#pragma once

#include "harness/judge/tradeoff/point.hpp"

#include <optional>
#include <span>

namespace hdmbench {

/// How many times faster one point is than a rival that is as accurate.
struct SpeedRatio {
  const TradeoffPoint* rival = nullptr;
  double ratio = 0.0; ///< of the medians; above 1: ours is faster
  double low = 0.0;   ///< the rival's fastest sample over our slowest
  double high = 0.0;  ///< the rival's slowest sample over our fastest
};

/// What reaches an accuracy soonest. Points into the points it was made from.
struct EqualAccuracy {
  double target = 0.0;                   ///< RMSD to FEM with Poisson ratio 0, pixels
  const TradeoffPoint* ours = nullptr;   ///< the fastest method at most `target` away; nullptr: none is
  double nearest = 0.0;                  ///< RMSD of the most accurate method, pixels; infinite: none
  std::optional<SpeedRatio> direct{};    ///< finite elements with ratio 0 by factorisation
  std::optional<SpeedRatio> iterative{}; ///< the fastest by conjugate gradients that reaches the target
  std::optional<SpeedRatio> multigrid{}; ///< the fastest by multigrid of others that does
  std::optional<SpeedRatio> coarse{};    ///< the fastest on a coarse mesh that does
};

/// Only points of status ok count. A ratio is there where both sides reach `target`.
[[nodiscard]] EqualAccuracy compare_at(std::span<const TradeoffPoint> points, double target);

} // namespace hdmbench
