// Of all suites. A suite asks drivers as hdmbench does, so that one that aborts is skipped and ends nothing.

#include "backends/registry.hpp"

#include <gmock/gmock.h>

int main(int argc, char** argv) {
  hdmbench::ask_drivers_apart(argc, argv);
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
