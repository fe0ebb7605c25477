// A round organ in a smooth hole along which it slides, of a law of large strains, under its own weight: what
// a scene file says, with the labels in memory, solved as accurately as is asked for.

#include <backends/registry.hpp>
#include <harness/scene/scene_of_images.hpp>
#include <harness/solve/request.hpp>

#include <cmath>
#include <iostream>

using namespace hdmbench;

namespace {

constexpr Extent extent{60, 50};

images::Pixels labels() {
  images::Pixels pixels{.geometry = {.size = {extent.width, extent.height, 1},
                                     .spacing = {2.0, 2.0, 2.0}, // mm
                                     .axes = Placement{}.axes}};
  for_each_site(extent, [&](int x, int y) {
    pixels.values.push_back(std::hypot((x - 30.0) / 26.0, (y - 25.0) / 18.0) < 1.0 ? 1.0F : 0.0F);
  });
  return pixels;
}

constexpr const char* text = R"(
[[tissue]]
label = 0
modulus = 0.0

[[tissue]]
label = 1
modulus = 0.003
density = 1000.0
law = "neo-hookean"

[[condition]]
where = "labels"
labels = [0]
slide = true

[[load]]
gravity = [9.81, 0.0, 0.0]
)";

} // namespace

int main() {
  Scene scene = make_scene(text, {{"labels", labels()}});
  Progress progress;
  const auto backends = make_backends();
  const Backend& backend = choose_backend(backends, "openmp", scene);
  const Answer answer =
      solve_request(scene, parse_request("0.02mm", "", scene.spacing), backend, {}, progress);
  const Solution& solution = answer.solution();
  const double moved = scene.spacing * largest_component(solution.displacement, tissue_of(scene));
  std::cout << answer.plan->outcome << "\nit moves by at most " << moved << " mm\n";
  return answer.plan->met && doubt_about(solution).empty() && moved > 0.5 ? 0 : 1;
}
