#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hdmbench {

namespace {

class CeilingsTest : public testing::TestWithParam<std::string> {};

// The loops check what they compute, so that no compiler can leave them out.
TEST_P(CeilingsTest, EverySampleIsARateThatADeviceCanHave) {
  const Backend& backend = test::find(GetParam());
  try {
    (void)backend.device({});
  } catch (const DeviceError& error) {
    GTEST_SKIP() << error.what();
  }
  const std::optional<Ceilings> ceilings = backend.ceilings({});
  ASSERT_TRUE(ceilings);
  ASSERT_EQ(ceilings->copy_bytes_per_second.size(), static_cast<std::size_t>(ceiling_samples));
  ASSERT_EQ(ceilings->operations_per_second.size(), static_cast<std::size_t>(ceiling_samples));
  for (const double rate : ceilings->copy_bytes_per_second) {
    EXPECT_GT(rate, 1e7);
    EXPECT_LT(rate, 1e14);
  }
  for (const double rate : ceilings->operations_per_second) {
    EXPECT_GT(rate, 1e8);
    EXPECT_LT(rate, 1e16);
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, CeilingsTest, testing::ValuesIn(test::backend_names()),
                         test::parameter_name);

} // namespace

} // namespace hdmbench
