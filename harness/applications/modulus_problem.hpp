#pragma once

#include "backends/shared/elastic_session.hpp"
#include "kernels/data/level.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// The modulus of some sites as the unknown of an elastic sheet: what deformation follows from it, and how
/// far that is from an observed one.
class ModulusProblem {
public:
  /// The level's modulus is what labels say; its conditions are prescribed (confidence 1) at all other sites.
  /// `unknown`: sites whose modulus is sought. Both must outlive this object.
  ModulusProblem(const Level& level, double poisson, const std::vector<std::size_t>& unknown,
                 ElasticSession& session);

  /// The displacement with the moduli times exp(logarithms), one per unknown site.
  [[nodiscard]] VectorField displacement(std::span<const double> logarithms);
  /// The derivative of the sum of difference * displacement over all sites (pixels^2) by the logarithms, at
  /// those of the last displacement(), which gave `found`: one solution more, as the elastic operator is
  /// symmetric.
  void slopes(const VectorField& found, const VectorField& difference, std::span<double> derivative);
  /// Half the sum of squared differences of the displacement and `observed` over the unknown sites, pixels^2,
  /// and its derivative by the logarithms.
  [[nodiscard]] double misfit(std::span<const double> logarithms, const VectorField& observed,
                              std::span<double> derivative);

private:
  Level level_;
  double poisson_;
  const std::vector<std::size_t>& unknown_;
  ElasticSession& session_;
  std::vector<float> labelled_; ///< moduli of the unknown sites, MPa
};

} // namespace hdmbench
