#include "harness/applications/physical_registration.hpp"

#include "harness/applications/gray_values.hpp"
#include "harness/applications/picture.hpp"
#include "harness/solve/methods/solver.hpp"

#include <cmath>

namespace hdmbench {

namespace {

constexpr double blur = 1.0;          // of pictures, pixels
constexpr double patch = 3.0;         // what a site's confidence is made from, standard deviation, pixels
constexpr float most_believed = 0.5F; // a spring as stiff as the tissue
constexpr float least_believed = 1e-4F;

} // namespace

VectorField confidence_of(const ScalarField& source, const ScalarField& target,
                          const VectorField& displacement, const ScalarField& unseen) {
  const Extent extent = source.extent;
  const ScalarField smooth = blurred(source, blur);
  const ScalarField seen = pulled_back(blurred(target, blur), displacement);
  const ScalarField expected = with_values_of(smooth, seen);
  const VectorField slope = gradient(smooth);
  ScalarField along_x(extent);
  ScalarField along_y(extent);
  ScalarField mismatch(extent);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const float difference = expected.values[site] - seen.values[site];
    along_x.values[site] = slope.x[site] * slope.x[site];
    along_y.values[site] = slope.y[site] * slope.y[site];
    mismatch.values[site] = difference * difference;
  }
  along_x = blurred(along_x, patch);
  along_y = blurred(along_y, patch);
  mismatch = blurred(mismatch, patch);
  // What the blur leaves of white noise; it makes slopes of its own.
  const double left = noise_of(source) / (2.0 * std::sqrt(M_PI) * blur);
  const double contrast =
      static_cast<double>(std::ranges::max(source.values) - std::ranges::min(source.values));
  const auto noise = static_cast<float>(std::max(left * left, 1e-4 * contrast * contrast));
  VectorField confidence(extent);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    if (!unseen.values.empty() && unseen.values[site] != 0.0F) {
      continue;
    }
    const float match = 1.0F / (1.0F + mismatch.values[site] / (8.0F * noise));
    const auto believed = [&](float structure) {
      const float excess = std::max(structure - 0.5F * noise, 0.0F);
      const float share = most_believed * match * match * excess / (excess + 4.0F * noise);
      return share < least_believed ? 0.0F : share;
    };
    confidence.x[site] = believed(along_x.values[site]);
    confidence.y[site] = believed(along_y.values[site]);
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
  Solver solver(backend, session);
  return solver.solve(observed, progress);
}

} // namespace hdmbench
