#include "harness/applications/registration.hpp"

#include "harness/applications/picture.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

constexpr double blur = 1.0;          // of pictures, pixels
constexpr double patch = 3.0;         // what a site's confidence is made from, standard deviation, pixels
constexpr float most_believed = 0.5F; // a spring as stiff as the tissue
constexpr float least_resistance = 0.05F;
constexpr float least_believed = 1e-4F;

/// What speaks for a displacement, around every site.
struct Evidence {
  VectorField structure; ///< squared slope along each axis, gray values^2 per pixel^2
  ScalarField match;     ///< 0 ... 1: 1 where the pictures look the same
  float noise = 0.0F;    ///< variance, gray values^2
};

Evidence evidence_of(const ScalarField& source, const ScalarField& target, const VectorField& displacement,
                     const ScalarField& unseen) {
  const ScalarField smooth = blurred(source, blur);
  const ScalarField seen = pulled_back(blurred(target, blur), displacement);
  const ScalarField expected = with_values_of(smooth, seen, unseen);
  Evidence evidence{gradient(smooth), ScalarField(source.extent)};
  for (std::size_t axis = 0; axis < source.extent.axes(); ++axis) {
    std::ranges::for_each(evidence.structure[axis], [](float& slope) { slope *= slope; });
  }
  evidence.structure = blurred(evidence.structure, patch);
  std::ranges::transform(expected.values, seen.values, evidence.match.values.begin(),
                         [](float a, float b) { return (a - b) * (a - b); });
  evidence.match = blurred(evidence.match, patch);
  // What the blur leaves of white noise; it makes slopes of its own.
  const double left = noise_of(source) / (2.0 * std::sqrt(M_PI) * blur);
  const auto [low, high] = std::ranges::minmax(source.values);
  const double contrast = static_cast<double>(high - low);
  evidence.noise = static_cast<float>(std::max(left * left, 1e-4 * contrast * contrast));
  for (float& match : evidence.match.values) {
    match = 1.0F / (1.0F + match / (8.0F * evidence.noise));
  }
  return evidence;
}

/// A region that looks as before resists as its tissue does. In one that looks different something happened,
/// a growth or a resection, which drives the rest.
float resistance_of(const Evidence& evidence, const ScalarField& region) {
  const auto match = static_cast<float>(mean_inside(evidence.match, region, 1.0));
  return std::max(match * match * match, least_resistance);
}

} // namespace

VectorField confidence_of(const ScalarField& source, const ScalarField& target,
                          const VectorField& displacement, const ScalarField& unseen) {
  const Evidence evidence = evidence_of(source, target, displacement, unseen);
  VectorField confidence(source.extent);
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    const float match = evidence.match.values[site];
    for (std::size_t axis = 0; axis < source.extent.axes() && is_seen(unseen, site); ++axis) {
      const float excess = std::max(evidence.structure[axis][site] - 0.5F * evidence.noise, 0.0F);
      const float share = most_believed * match * match * excess / (excess + 4.0F * evidence.noise);
      confidence[axis][site] = share < least_believed ? 0.0F : share;
    }
  }
  return confidence;
}

void require_labels(const Scene& scene) {
  const std::vector<int>& labels = scene.labels.values;
  if (labels.empty() || std::ranges::count(labels, labels.front()) == std::ssize(labels)) {
    throw InputError(
        fmt::format("the scene {} has no labels, or one label everywhere: give it [image] labels "
                    "and a [[tissue]] with a modulus for each",
                    scene.name));
  }
}

Solution make_physical(const ScalarField& source, const ScalarField& target, const VectorField& displacement,
                       const ScalarField& unseen, const Scene& scene, const Backend& backend,
                       const SessionOptions& session, VectorField& confidence, Progress& progress) {
  Scene observed = scene;
  observed.start.reset();
  observed.full.target = displacement;
  observed.full.confidence = confidence_of(source, target, displacement, unseen);
  confidence = observed.full.confidence;
  blend_moduli(observed.full.modulus, unseen,
               resistance_of(evidence_of(source, target, displacement, unseen), unseen));
  set_inverse_modulus(observed.full);
  Solver solver(backend, session);
  return solver.solve(observed, progress);
}

} // namespace hdmbench
