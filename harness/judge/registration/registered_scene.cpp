#include "harness/judge/registration/registered_scene.hpp"

#include "harness/scene/row_fields.hpp"

namespace hdmbench {

void RegisteredScene::set_scene(const Scene& registered) {
  scene = registered.name;
  width = registered.extent().width;
  height = registered.extent().height;
}

void list_fields(Fields& fields, RegisteredScene& row) {
  fields("scene", row.scene);
  fields("width", row.width);
  fields("height", row.height);
}

} // namespace hdmbench
