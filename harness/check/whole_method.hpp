#pragma once

#include "harness/check/verify.hpp"

namespace hdmbench {

/// A backend that computes methods as a whole in a way of its own, as several ranks do: what the host makes
/// between levels is more than the sweeps that verify follows.
class WholeMethod {
public:
  WholeMethod() = default;
  WholeMethod(const WholeMethod&) = delete;
  WholeMethod& operator=(const WholeMethod&) = delete;
  virtual ~WholeMethod() = default;

  /// Returns the displacement, pixels. Throws what sessions throw.
  [[nodiscard]] virtual VectorField solve(const Scene& scene) const = 0;
};

/// Whether the scene's method is compared as a whole on backends that are a WholeMethod: of the thesis's
/// energy, with something between the levels that a Pyramid has not.
[[nodiscard]] bool is_compared_whole(const Scene& scene);

/// The displacement of each backend that is a WholeMethod, and the reference's, which computes the method in
/// one process: a comparison each, of Mode::pyramid.
[[nodiscard]] std::vector<Comparison> verify_whole(const Scene& scene, const Backend& reference,
                                                   std::span<const Backend* const> backends,
                                                   const VerifyOptions& options, Progress& progress);

} // namespace hdmbench
