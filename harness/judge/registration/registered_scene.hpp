#pragma once

#include "harness/scene/scene.hpp"

#include <cstdint>
#include <string>

namespace hdmbench {

class Fields;

/// How every row of registration and detection begins: whose picture it was.
struct RegisteredScene {
  std::string scene;
  std::int64_t width = 0; ///< sites
  std::int64_t height = 0;

  void set_scene(const Scene& registered);
};
void list_fields(Fields& fields, RegisteredScene& row);

} // namespace hdmbench
