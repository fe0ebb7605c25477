#pragma once

#include "harness/applications/picture.hpp"
#include "harness/applications/region_sheet.hpp"

#include <array>
#include <span>
#include <vector>

namespace hdmbench {

/// Moduli are sought between a 20th and 20 times the label's: the logarithm of the factor.
inline constexpr double largest_logarithm = 3.0;

/// A disc whose modulus is another than its label's.
struct Inclusion {
  double x = 0.0; ///< of the centre, sites of the sheet
  double y = 0.0;
  double radius = 0.0;    ///< pixels
  double logarithm = 0.0; ///< of its modulus over the label's
  // Standard deviations by white noise, as far as the model is right.
  double position_deviation = 0.0; ///< of the centre, pixels
  double logarithm_deviation = 0.0;
};

/// Looks for discs whose modulus is not their label's. A disc's score is the slope of -|what the labels'
/// moduli leave unexplained|^2 / 2 by the logarithm of its modulus: unexplained displacement times what a
/// stiffer disc would do, summed over the region. That is the matched filter; divided by its deviation where
/// nothing is hidden it is the score test of that disc. One adjoint solution gives the scores of all discs.
class InclusionScan {
public:
  static constexpr std::array<double, 6> radii{3.0, 4.25, 6.0, 8.5, 12.0, 15.0}; ///< pixels
  /// Of the discs around every site, one field per radius; only inside sites mean something.
  using Scores = std::array<ScalarField, radii.size()>;

  /// `reference` is the observed displacement, whose border says how the region is strained. The sheet must
  /// outlive this object.
  InclusionScan(const RegionSheet& sheet, const VectorField& reference);

  /// What the labels' moduli leave of a displacement, 0 outside the region. What an error in Poisson's ratio
  /// or in a label's modulus could explain counts for nothing.
  [[nodiscard]] VectorField unexplained(const VectorField& observed) const;
  /// Linear in what is unexplained.
  [[nodiscard]] Scores scores(const VectorField& unexplained) const;

  /// The disc that explains most of it, by Levenberg's and Marquardt's method from the given one, whose sign
  /// it keeps: softer or stiffer. `noise`: white, of the displacement, pixels.
  [[nodiscard]] Inclusion fit(Inclusion start, const VectorField& unexplained, double noise) const;

  /// What a disc would leave unexplained by the labels' moduli.
  [[nodiscard]] VectorField response(const Inclusion& disc) const;

  /// With Poisson's ratio, the labels' moduli and their borders a little different, inside the region and
  /// around it: none of them is known better.
  [[nodiscard]] VectorField nothing_hidden(GaussianNoise& random) const;

private:
  void add_excuse(const VectorField& more, const VectorField& less);
  /// a - b inside, less what the excuses explain of it; 0 outside.
  [[nodiscard]] VectorField inexcusable(const VectorField& a, const VectorField& b) const;
  [[nodiscard]] VectorField with_disc(const Inclusion& disc) const;

  const RegionSheet& sheet_;
  Level level_; ///< its border
  mutable ModulusProblem problem_;
  VectorField expected_;             ///< with the labels' moduli
  std::vector<VectorField> excuses_; ///< orthonormal
};

/// A scan measured by scans of the same region where nothing is hidden.
struct ScanResult {
  ScalarField significance; ///< of each site's most significant disc, deviations; above 0: stiffer
  /// A disc that is more significant than all others of its sign.
  struct Peak {
    double significance = 0.0; ///< 0: there is none
    std::size_t site = 0;
    double radius = 0.0; ///< pixels
  };
  Peak stiffest;
  Peak softest;
  /// Magnitude of the largest, of either sign, in each of the others, measured by the rest.
  std::vector<double> by_chance;
};

/// `nothing`: at least 3 scans.
[[nodiscard]] ScanResult measure_scan(const RegionSheet& sheet, const InclusionScan::Scores& found,
                                      std::span<const InclusionScan::Scores> nothing);

/// The deviation of the scores in `these` over that in `those`, the median of all discs.
[[nodiscard]] double deviation_ratio(const RegionSheet& sheet, std::span<const InclusionScan::Scores> these,
                                     std::span<const InclusionScan::Scores> those);

} // namespace hdmbench
