#include "harness/scene/scene.hpp"
#include "kernels/data/pyramid.hpp"

namespace hdmbench {

VectorField Scene::start_field() const {
  return start ? *start : VectorField(extent());
}

VectorField Scene::start_at(Extent level) const {
  return start ? sample_field(*start, level, schedule.alignment) : VectorField(level);
}

} // namespace hdmbench
