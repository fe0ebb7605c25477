#pragma once

#include "harness/scene/scene.hpp"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// Sides of volumes that ask something of what is laid out in rows, tiles and levels: the tests of bits make
/// random levels of these, too.
[[nodiscard]] std::span<const Extent> odd_volumes();

/// One problem that backends are compared on. `verify`, `golden`, `faults` and the tests take theirs from
/// tables of these; a further scene or method is a further line there.
struct Case {
  std::string scene;               ///< what load_scene() takes, or the name of what `generate` makes
  std::optional<Extent> size{};    ///< pixels or voxels; none: the scene's own
  std::string method{};            ///< of harness/scene/method.hpp; empty: the scene's own
  std::optional<int> iterations{}; ///< at most so many, in the unit of the method's effort; none: no limit
  /// Makes a scene of a size that no file describes; none: load_scene() makes it. Called with `size`.
  std::function<Scene(Extent)> generate{};

  /// "random, 257 x 130, annealing", without what is not set.
  [[nodiscard]] std::string name() const;
  /// Whether scene, size and method are the same.
  bool operator==(const Case& other) const;
};

/// The scene at its size, with its method and no more iterations. Throws what load_scene() and find_method()
/// throw.
[[nodiscard]] Scene load_case(const Case& one);

/// What a scene is, without generator: its name, its size, and method_name().
[[nodiscard]] Case case_of(const Scene& scene);

/// No more iterations than the case allows.
void limit_iterations(Scene& scene, const Case& one);

/// An image and a volume of boxes, whose cells have kernels of their own, by conjugate gradients.
[[nodiscard]] std::vector<Case> box_cases(int iterations);

/// What `verify` compares where nobody chooses: every shipped scene as its file says; what meets the tiles of
/// all backends; every other method on the scene that has another modulus at every site, so that each rule
/// and order of sites is compared; then all scenes (`quick`: two) with the elastic energy, a few steps of
/// conjugate gradients, in which all of its arithmetic is; and all of this in small volumes, one of which is
/// integrated selectively; an image and a volume of boxes.
[[nodiscard]] std::vector<Case> verify_cases(bool quick = false);

/// What `golden` has hashes of, with few iterations: every shipped scene by its own method, `square` at a
/// second size, and every other method of both energies on `random`; some scenes by conjugate gradients, too;
/// volumes of both energies; boxes.
[[nodiscard]] std::vector<Case> golden_cases();

} // namespace hdmbench
