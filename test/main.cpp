// Of all suites. A suite asks drivers and reads images as hdmbench does: a driver that aborts is skipped, a
// damaged image is refused, and neither ends the suite.

#include "backends/registry.hpp"
#include "harness/scene/images/images.hpp"

#include <gmock/gmock.h>

int main(int argc, char** argv) {
  hdmbench::ask_drivers_apart(argc, argv);
  hdmbench::read_images_apart(argc, argv);
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
