#pragma once

#include "kernels/data/pyramid.hpp"

#include <vector>

namespace hdmbench {

/// Hands the residual of a level to the next coarser one: r_c = h^2 sum(w p r) / sum(w p) over the fine
/// sites, w the weights that prolongate() gives the coarse site at each of them, h the coarse site's width in
/// fine ones, p the stationary weights. The residual is divided by A, so it grows as h^2. With p inner forces
/// cancel in the sum; with 1 or the modulus in its place what interfaces leave over is a force to the coarse
/// level, and the first cycle after an interpolation spoils the field.
class Restriction {
public:
  Restriction(const Level& fine, Extent coarse, Alignment alignment);

  /// `residual` on the fine level, pixels; the result is rounded to float. The same for any number of
  /// threads.
  [[nodiscard]] VectorField restrict_residual(const DoubleField& residual) const;

  /// 1 where `held` is 1 at one of the fine sites that the coarse one is nearest to, else 0.
  [[nodiscard]] VectorField restrict_held(const VectorField& held) const;

private:
  /// A coarse site's share of a fine one on an axis.
  struct Share {
    int fine = 0;
    double weight = 0.0;
  };
  using Shares = std::vector<std::vector<Share>>; ///< by coarse site

  [[nodiscard]] static Shares shares(int coarse, int fine, Alignment alignment);
  /// sum(w p r) over the fine sites; r = 1 where `values` is empty.
  [[nodiscard]] std::vector<double> weighted_sums(const std::vector<float>& weights,
                                                  const std::vector<double>& values) const;
  [[nodiscard]] std::vector<double> scale_of(const std::vector<float>& weights, Alignment alignment) const;
  [[nodiscard]] std::vector<float> restrict_component(const std::vector<float>& weights,
                                                      const std::vector<double>& scale,
                                                      const std::vector<double>& residual) const;
  [[nodiscard]] std::vector<float> any_in_footprint(const std::vector<float>& held) const;

  Extent fine_;
  Extent coarse_;
  VectorField weights_; ///< p, of the fine level
  Shares columns_;
  Shares rows_;
  std::vector<double> scale_x_; ///< h^2 / sum(w p)
  std::vector<double> scale_y_;
};

} // namespace hdmbench
