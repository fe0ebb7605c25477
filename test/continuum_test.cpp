// What `continuum` measures.

#include "backends/registry.hpp"
#include "harness/judge/continuum.hpp"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <vector>

namespace hdmbench {
namespace {

nlohmann::json measured(double contrast) {
  constexpr std::array sides{33, 65, 129};
  Progress silent(false);
  const auto registry = make_backends();
  return measure_continuum(contrast, sides, find_backend(registry, "openmp"), {}, silent);
}

/// Stretched evenly: bilinear elements have that displacement (the patch test), and so must our field.
TEST(Continuum, OneMaterialHasNoErrorButThatOfFloat) {
  const nlohmann::json rows = measured(1.0);
  for (const nlohmann::json& row : rows) {
    EXPECT_LT(row["discretisation"]["largest"], 2e-5) << "the border is given in float32: 25 px to 24 bits";
    EXPECT_LT(row["rounding"]["largest"], 2e-5);
  }
}

TEST(Continuum, ErrorsAreApart) {
  for (const double contrast : {0.1, 10.0}) {
    const nlohmann::json rows = measured(contrast);
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_FALSE(rows.front().contains("order"));
    EXPECT_GT(rows.back()["order"], 0.8) << contrast;
    for (const nlohmann::json& row : rows) {
      const auto rmsd = [&](const char* of) { return row[of]["rmsd"].get<double>(); };
      EXPECT_GT(rmsd("discretisation"), 100.0 * rmsd("rounding")) << row["width"];
      EXPECT_LT(rmsd("algebraic"), rmsd("discretisation")) << row["width"];
      EXPECT_LT(row["rounding"]["largest"], 2e-5) << row["width"];
      EXPECT_GT(rmsd("rounding"), 0.0) << row["width"];
    }
  }
}

} // namespace
} // namespace hdmbench
