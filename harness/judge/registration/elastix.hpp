#pragma once

#include "kernels/data/field.hpp"

#include <filesystem>
#include <string_view>

/// The registration program elastix, as people use it: it is run as it is installed, nothing of it is linked.
namespace hdmbench {

struct ElastixRegistration {
  VectorField displacement; ///< pixels; tissue at x of the source is at x + d(x) of the target
  double seconds = 0.0;     ///< of the registration, files and start included
};

/// Whether `program` is on PATH as a file that can be run.
[[nodiscard]] bool is_installed(std::string_view program);

/// Cubic B-splines, Mattes mutual information, four resolutions, adaptive stochastic gradient descent from a
/// fixed seed, one thread. Where `unseen` is not 0 it does not look; empty: everywhere. Its files are in a
/// temporary folder. Throws InputError where elastix or transformix is not installed, or fails, with its own
/// last words.
[[nodiscard]] ElastixRegistration register_with_elastix(const ScalarField& source, const ScalarField& target,
                                                        const ScalarField& unseen);

} // namespace hdmbench
