#pragma once

#include "harness/solve/methods/level_parts.hpp"

#include <vector>

namespace hdmbench {

/// Hands the residual of a level to the next coarser one: r_c = h^2 sum(w p r) / sum(w p) over the fine
/// sites, w the weights that prolongate() gives the coarse site at each of them, h the coarse site's width in
/// fine ones, p the stationary weights. The residual is divided by A, so it grows as h^2. With p inner forces
/// cancel in the sum; with 1 or the modulus in its place what interfaces leave over is a force to the coarse
/// level, and the first cycle after an interpolation spoils the field.
class Restriction {
public:
  /// `fine`: what `parts`, which must outlive this object, loads of the level of extent `from`. Throws what
  /// they throw.
  Restriction(const Level& fine, Extent from, Extent coarse, Alignment alignment, const LevelParts& parts);

  /// `residual` on the fine level, pixels; the result, on the coarse one, is rounded to float. The same for
  /// any number of threads.
  [[nodiscard]] VectorField restrict_residual(const DoubleField& residual) const;

  /// 1 where `held` is 1 at one of the fine sites that the coarse one is nearest to, else 0.
  [[nodiscard]] VectorField restrict_held(const VectorField& held) const;

private:
  /// A coarse site's share of a fine one on an axis.
  struct Share {
    int fine = 0; ///< index into what is loaded
    double weight = 0.0;
  };
  using Shares = std::vector<std::vector<Share>>; ///< by coarse site
  struct Axis {
    int sites = 0; ///< of the level
    int first = 0; ///< of those that are here
    int count = 0;
  };

  [[nodiscard]] static Shares shares(const Axis& coarse, const Axis& fine, Alignment alignment);
  /// sum(w p r) over the fine sites; r = 1 where `values` is empty.
  [[nodiscard]] std::vector<double> weighted_sums(const std::vector<float>& weights,
                                                  const std::vector<double>& values) const;
  [[nodiscard]] std::vector<double> scale_of(const std::vector<float>& weights, Alignment alignment) const;
  [[nodiscard]] std::vector<float> restrict_component(const std::vector<float>& weights,
                                                      const std::vector<double>& scale,
                                                      const std::vector<double>& residual) const;
  [[nodiscard]] std::vector<float> any_in_footprint(const std::vector<float>& held) const;

  const LevelParts& parts_;
  Alignment alignment_;
  Extent fine_level_;
  Extent coarse_level_;
  Extent fine_;         ///< what is loaded
  Rectangle made_;      ///< what is made here of the coarse level
  VectorField weights_; ///< p, of the fine level
  Shares columns_;
  Shares rows_;
  std::vector<double> scale_x_; ///< h^2 / sum(w p)
  std::vector<double> scale_y_;
};

} // namespace hdmbench
