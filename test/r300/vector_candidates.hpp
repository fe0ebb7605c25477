#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

/// The thesis's shader as it may have been: a site's whole energy for every candidate VECTOR (its Algorithms
/// 1 to 4 have Gamma as a set of vectors), in the direct form, unrolled because fragment programs of its time
/// had no loops. Its source is not printed; these are ours, in GLSL 1.20, with the textures and the border of
/// kernels/shaders/sweep.frag.
namespace hdmbench::test {

enum class Energy {
  as_printed, ///< (4.7)-(4.17) line by line on two-vectors, with their divisions, m of the neighbours fetched
  site_energy, ///< that of energy.inc, 1 / m given, the candidate a two-vector
  /// The same with the candidate's x and y apart: a compiler can see that half of the terms depend on x
  /// alone.
  site_energy_on_scalars
};

/// A candidate vector, as two GLSL expressions.
using Candidate = std::array<std::string, 2>;

/// `count` step sizes as uniforms that the compiler knows nothing of.
[[nodiscard]] std::vector<std::string> uniform_steps(int count);
/// The thesis's own: {-1, -0.1, 1, 0.1} and, for 6, {-1, -0.1, -0.01, 1, 0.1, 0.01} (misprints of the sign
/// mended); `count` is 4 or 6.
[[nodiscard]] std::vector<std::string> literal_steps(int count);

/// Every step size of x with every one of y: count^2 vectors.
[[nodiscard]] std::vector<Candidate> product_set(std::span<const std::string> steps);
/// The same step in x and y: count vectors.
[[nodiscard]] std::vector<Candidate> diagonal_set(std::span<const std::string> steps);

/// A fragment shader that moves a site to the best of `candidates`.
[[nodiscard]] std::string vector_candidates_shader(Energy energy, std::span<const Candidate> candidates);

} // namespace hdmbench::test
