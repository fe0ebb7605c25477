#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/applications/picture.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace hdmbench {

/// The value of a function, and its gradient into the second argument.
using Objective = std::function<double(std::span<const double>, std::span<double>)>;

/// Where ITK's L-BFGS-B (vnl's) finds the minimum, from 0, with every one of the `unknowns` within +- `bound`
/// and at most so many iterations. What the objective throws ends it. Throws MissingFile where the build has
/// no ITK.
[[nodiscard]] std::vector<double> minimise(const Objective& objective, std::size_t unknowns, double bound,
                                           int iterations);

/// a - b at some sites, 0 elsewhere.
[[nodiscard]] VectorField difference_at(const std::vector<std::size_t>& sites, const VectorField& a,
                                        const VectorField& b);

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

/// The part of a scene around a region of interest, as an elastic sheet: what the displacement around the
/// region, and the moduli in it, make of the inside. Fields are of this part unless they are "of the image".
class RegionSheet {
public:
  /// `region`: not 0 is inside. All must outlive this object. Throws InputError where the region is empty or
  /// the whole image, or of another size than the scene.
  RegionSheet(const ScalarField& region, const Scene& scene, ElasticSession& session);

  [[nodiscard]] Extent extent() const { return sheet_.extent; }
  /// The sites inside the region.
  [[nodiscard]] const std::vector<std::size_t>& inside() const { return inside_; }
  /// The place of an inside site in inside(), -1 for the others.
  [[nodiscard]] int index(std::size_t site) const { return index_[site]; }
  [[nodiscard]] std::size_t site_of_image(std::size_t site) const;
  [[nodiscard]] int label(std::size_t site) const { return labels_[site]; }
  [[nodiscard]] const ScalarField& modulus() const { return sheet_.modulus; }
  [[nodiscard]] double poisson() const { return poisson_; }
  [[nodiscard]] ElasticSession& session() const { return session_; }

  [[nodiscard]] VectorField part_of(const VectorField& of_image) const;
  /// Replaces this part of the image.
  void put_back(const VectorField& part, VectorField& of_image) const;

  /// The sheet with `observed` prescribed outside the region, but for most of its noise: springs hold it to a
  /// sheet as the labels say.
  [[nodiscard]] Level with_border(const VectorField& observed) const;
  /// What with_border prescribes is held as gently as it was smoothed; the rim of the part stays.
  void loosen(Level& level) const;
  /// What follows from `level`'s conditions with its moduli times exp(logarithms), one per inside site; none:
  /// as they are. `poisson`: in place of the scene's.
  [[nodiscard]] VectorField displacement(const Level& level, double poisson,
                                         std::vector<double> logarithms = {}) const;
  /// RMS of |a - b| over the inside, pixels.
  [[nodiscard]] double distance(const VectorField& a, const VectorField& b) const;

private:
  [[nodiscard]] float gentle_hold(std::size_t site) const; ///< confidence

  double poisson_;
  Extent image_;
  int left_ = 0; ///< of this part in the image
  int top_ = 0;
  Level sheet_; ///< moduli of the labels, no conditions
  std::vector<int> labels_;
  std::vector<std::size_t> inside_;
  std::vector<int> index_;
  ElasticSession& session_;
};

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
  /// The scores of the discs around every site, one field per radius; only inside sites mean something.
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

struct DetectionOptions {
  double smoothness =
      4.0;             ///< weight of the total variation of log modulus against squared differences / noise^2
  int iterations = 40; ///< of L-BFGS
  int fields = 40;     ///< displacements with noise and nothing hidden, which significance is measured by
  int pairs = 19;      ///< the same of simulated pictures: each is registered. At least 3, as fields
  std::uint32_t seed = 1;
};

struct Detection {
  ScalarField modulus; ///< MPa; outside the region that of the labels
  /// The most significant disc around each site, in standard deviations of what is found where nothing is
  /// hidden: above 0 stiffer than the label says, below softer.
  ScalarField significance;
  double noise = 0.0; ///< of the displacement, standard deviation of a component, pixels
  double unexplained_before =
      0.0;                  ///< RMS difference to the observed displacement with the labels' moduli, pixels
  double unexplained = 0.0; ///< the same with the moduli that were found
  /// The largest significance of the sign that the disc has which explains the displacement best.
  double largest = 0.0;
  double x = 0.0; ///< of the centre of the disc that explains the displacement best, pixels
  double y = 0.0;
  double contrast = 1.0; ///< of that disc, modulus over the label's
  double radius = 0.0;   ///< of it, pixels
  // By white noise of the displacement alone, standard deviations. The bias of a registration is larger, so
  // that these are no interval of what is true.
  double position_deviation = 0.0; ///< of x, y, pixels
  double contrast_deviation = 0.0; ///< of the logarithm of the contrast
  /// The largest magnitude, of either sign, in each simulation in which nothing is hidden: where one of them
  /// comes near, the above may be chance.
  std::vector<double> by_chance;
  double seconds = 0.0;
};

/// Thesis Algorithm 7: in `region` (not 0) the modulus is not what labels say. What of the observed
/// displacement (pixels, on the scene's grid) the labels' moduli leave unexplained is searched for the
/// pattern of a stiffer or softer disc, of any place and of several sizes; how much of it is chance is
/// measured by the same search where nothing is hidden but white noise. The moduli that explain the
/// displacement are least squares over the noise plus total variation of the logarithm, by L-BFGS with the
/// gradient of the adjoint. Throws InputError for an empty region, one without enough tissue for the smallest
/// disc, one that leaves the sheet free, and where nothing deformed.
[[nodiscard]] Detection detect_modulus(const VectorField& observed, const ScalarField& region,
                                       const Scene& scene, const DetectionOptions& options,
                                       ElasticSession& session, Progress& progress);

/// The same from two pictures and what Algorithm 6 made of them. The error of a registration is no white
/// noise: it is the same over many pixels, and a bias. So chance is measured by `pairs` of pictures in which
/// nothing is hidden: the source, moved by the registration as the labels' moduli continue it into the
/// region, with gray values and noise as the target has, is registered again.
[[nodiscard]] Detection detect_modulus(const ScalarField& source, const ScalarField& target,
                                       const VectorField& registered, const ScalarField& region,
                                       const Scene& scene, const DetectionOptions& options,
                                       ElasticSession& session, Progress& progress);

} // namespace hdmbench
