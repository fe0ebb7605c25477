#include "harness/ranks/sleeping_pieces.hpp"

#include "harness/ranks/sharing.hpp"

namespace hdmbench {

Scene sleeping_pieces(int ranks) {
  constexpr Extent extent{124, 120};
  constexpr float pull = 1000.0F; // pixels: further than the iterations get
  Scene scene = load_scene("square", {.size = extent});
  scene.name = "sleeping-pieces";
  scene.source.clear();
  Level& level = scene.full;
  level.target = level.confidence = VectorField(extent);
  level.modulus = ScalarField(extent, 1.0F);
  set_inverse_modulus(level);
  // A neighbour of what has moved is best moved by a quarter as far: a front that goes on by a site a sweep.
  level.steps = StepSet::parse("0,-16,16,-4,4,-1,1,-0.25,0.25,-0.0625,0.0625,-0.015625,0.015625");
  scene.schedule.start_level = 0;
  scene.schedule.iterations = 12; // three renewals

  const Cut cut = Sharing{.ranks = ranks, .pieces = ranks, .fewest_sites = 1}.level(extent, false).cut;
  const Rectangle& first = cut.pieces.front().owned;
  const std::size_t site = extent.index(first.width - cut.halo - 1, first.height - cut.halo - 1);
  level.target.x[site] = level.target.y[site] = pull;
  level.confidence.x[site] = level.confidence.y[site] = 1.0F;
  return scene;
}

} // namespace hdmbench
