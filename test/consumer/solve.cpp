// A sheet of soft tissue with a stiff disc, held on its left and pulled on its right, solved on every backend
// that is there and compared with finite elements.

#include <backends/registry.hpp>
#include <harness/scene/method.hpp>
#include <harness/solve/methods/solver.hpp>
#include <reference/finite_elements.hpp>

#include <cmath>
#include <iostream>

using namespace hdmbench;

namespace {

Scene sheet_with_disc(Extent extent) {
  Scene scene;
  scene.name = "sheet";
  Level& full = scene.full;
  full.extent = extent;
  full.modulus = ScalarField(extent, 1.0F); // MPa
  full.target = VectorField(extent);        // pixels
  full.confidence = VectorField(extent);    // 1 where a component is known
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    full.modulus.values[site] = std::hypot(x - extent.width / 2, y - extent.height / 2) < 8.0 ? 20.0F : 1.0F;
    if (x == 0 || x + 1 == extent.width) {
      full.target[0][site] = x == 0 ? 0.0F : 5.0F;
      full.confidence[0][site] = full.confidence[1][site] = 1.0F;
    }
  });
  set_inverse_modulus(full);
  use_method(scene, find_method(elastic_conjugate_gradients), 15);
  return scene;
}

} // namespace

int main() {
  const Scene scene = sheet_with_disc({48, 40});
  const ReferenceField truth =
      solve_finite_elements(elastic_problem(scene.full), ElementRule::of(scene.extent(), scene.elastic));
  int failures = 0;
  for (const auto& backend : make_backends()) {
    try {
      Progress progress;
      const Solution solution = Solver(*backend, {}).solve(scene, progress);
      double farthest = 0.0;
      for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
        farthest = std::max(farthest, std::abs(solution.displacement[0][site] - truth[0][site]));
      }
      std::cout << backend->name() << ": at most " << farthest << " px from finite elements along x\n";
      failures += farthest < 1e-4 ? 0 : 1;
    } catch (const DeviceError& error) {
      std::cout << backend->name() << " is not there: " << error.what() << '\n';
    }
  }
  return failures;
}
