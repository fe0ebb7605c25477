#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"

#include <span>
#include <vector>

namespace hdmbench {

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

} // namespace hdmbench
