// What `continuum` measures.

#include "backends/registry.hpp"
#include "harness/judge/continuum.hpp"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <vector>

namespace hdmbench {
namespace {

std::vector<ContinuumRow> measured(double contrast) {
  constexpr std::array sides{33, 65, 129};
  Progress silent(false);
  const auto registry = make_backends();
  return measure_continuum(contrast, sides, find_backend(registry, "openmp"), {}, silent);
}

/// Stretched evenly: bilinear elements have that displacement (the patch test), and so must our field.
TEST(Continuum, OneMaterialHasNoErrorButThatOfFloat) {
  for (const ContinuumRow& row : measured(1.0)) {
    EXPECT_LT(row.discretisation.largest, 2e-5) << "the border is given in float32: 25 px to 24 bits";
    EXPECT_LT(row.rounding.largest, 2e-5);
  }
}

TEST(Continuum, ErrorsAreApart) {
  for (const double contrast : {0.1, 10.0}) {
    const std::vector<ContinuumRow> rows = measured(contrast);
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows.front().order, std::nullopt);
    EXPECT_GT(rows.back().order.value(), 0.8) << contrast;
    for (const ContinuumRow& row : rows) {
      EXPECT_GT(row.discretisation.rmsd, 100.0 * row.rounding.rmsd) << row.width;
      EXPECT_LT(row.algebraic.rmsd, row.discretisation.rmsd) << row.width;
      EXPECT_LT(row.rounding.largest, 2e-5) << row.width;
      EXPECT_GT(row.rounding.rmsd, 0.0) << row.width;
    }
  }
}

} // namespace
} // namespace hdmbench
