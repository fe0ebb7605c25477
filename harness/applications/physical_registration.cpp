#include "harness/applications/physical_registration.hpp"

#include "harness/applications/picture.hpp"
#include "harness/solve/methods/solver.hpp"

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
  ScalarField along_x; ///< squared slope, gray values^2 per pixel^2
  ScalarField along_y;
  ScalarField match;  ///< 0 ... 1: 1 where the pictures look the same
  float noise = 0.0F; ///< variance, gray values^2
};

Evidence evidence_of(const ScalarField& source, const ScalarField& target, const VectorField& displacement,
                     const ScalarField& unseen) {
  const ScalarField smooth = blurred(source, blur);
  const ScalarField seen = pulled_back(blurred(target, blur), displacement);
  const ScalarField expected = with_values_of(smooth, seen, unseen);
  const VectorField slope = gradient(smooth);
  Evidence evidence{ScalarField(source.extent), ScalarField(source.extent), ScalarField(source.extent)};
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    const float difference = expected.values[site] - seen.values[site];
    evidence.along_x.values[site] = slope[0][site] * slope[0][site];
    evidence.along_y.values[site] = slope[1][site] * slope[1][site];
    evidence.match.values[site] = difference * difference;
  }
  evidence.along_x = blurred(evidence.along_x, patch);
  evidence.along_y = blurred(evidence.along_y, patch);
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
  double sum = 0.0;
  double sites = 0.0;
  for (std::size_t site = 0; site < region.values.size(); ++site) {
    if (region.values[site] != 0.0F) {
      sum += static_cast<double>(evidence.match.values[site]);
      sites += 1.0;
    }
  }
  const auto match = static_cast<float>(sites > 0.0 ? sum / sites : 1.0);
  return std::max(match * match * match, least_resistance);
}

} // namespace

VectorField confidence_of(const ScalarField& source, const ScalarField& target,
                          const VectorField& displacement, const ScalarField& unseen) {
  const Evidence evidence = evidence_of(source, target, displacement, unseen);
  VectorField confidence(source.extent);
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    if (!unseen.values.empty() && unseen.values[site] != 0.0F) {
      continue;
    }
    const float match = evidence.match.values[site];
    const auto believed = [&](float structure) {
      const float excess = std::max(structure - 0.5F * evidence.noise, 0.0F);
      const float share = most_believed * match * match * excess / (excess + 4.0F * evidence.noise);
      return share < least_believed ? 0.0F : share;
    };
    confidence[0][site] = believed(evidence.along_x.values[site]);
    confidence[1][site] = believed(evidence.along_y.values[site]);
  }
  return confidence;
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
