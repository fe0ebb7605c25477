#pragma once

#include "harness/scene/scene.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// How much of a scene a level of the pyramid can show.
struct Resolution {
  Extent extent;
  double materials = 0.0;  ///< share of the full image's sites whose modulus the level's nearest site has
  double conditions = 0.0; ///< share of its observed components that the level's nearest site observes too

  /// Whether a solution there is a fair start for the finer levels (thesis 9.4).
  [[nodiscard]] bool is_fair() const { return materials >= 0.9 && conditions >= 0.5; }
};

/// Shares are of so many sites a side: they need no more, and must cost less than a sweep.
inline constexpr int usual_per_side = 97;

/// `extents`: the full resolution first, then ever coarser. Shares are of at most per_side x per_side sites
/// spread over the image.
[[nodiscard]] std::vector<Resolution> resolutions(const Scene& scene, std::span<const Extent> extents,
                                                  int per_side = usual_per_side);

/// Position in `levels` of the coarsest one that is a fair start, all finer ones being fair too.
[[nodiscard]] std::size_t fair_start(std::span<const Resolution> levels);

/// What a scene asks of a solver, for people, from all of its sites.
struct Survey {
  double smallest_modulus = 0.0; ///< MPa
  double largest_modulus = 0.0;
  double smallest_target = 0.0; ///< of the observed components, pixels
  double largest_target = 0.0;
  double observed = 0.0; ///< share of all components with confidence > 0
  double partly = 0.0;   ///< share of all components with 0 < confidence < 1
  double uniform = 0.0;  ///< share of the sites whose 3 x 3 has one modulus, of at most 97 x 97
};

[[nodiscard]] Survey survey(const Scene& scene);

} // namespace hdmbench
