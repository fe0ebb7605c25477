// Backends that really are compiled with freedoms ours have not, fused multiply-adds and sums in any order,
// land in the third tier: no more differs than rounding explains, and nothing where all is exact.

#include "backends/cpu/cpu.hpp"
#include "harness/scene/method.hpp"
#include "test/scenes.hpp"

namespace hdmbench::energies::Hdm::contracted {
/// row.cpp built with fused multiply-adds.
std::int64_t sweep_row(const openmp::RowPart& part);
} // namespace hdmbench::energies::Hdm::contracted

namespace hdmbench::energies::Hdm::reordered {
/// row.cpp built with sums in any order.
std::int64_t sweep_row(const openmp::RowPart& part);
} // namespace hdmbench::energies::Hdm::reordered

namespace hdmbench {
namespace {

using test::Texture;

/// Candidates nearly tie everywhere, and no two neighbours in a row have one modulus. Where all have, a
/// compiler with -ffast-math takes the ratio out of the sums and is left with d_s - 2 d_t + d_u: that is no
/// other order but the expanded form, which cancels.
Scene make_tie_rich_scene() {
  Scene scene = test::textured_scene("certified", {72, 60}, Texture::tie_rich, 11, 20);
  for_each_site(scene.extent(), [&](int x, int y) {
    scene.full.modulus.values[scene.extent().index(x, y)] = (x + y) % 2 == 0 ? 1.0F : 2.0F;
  });
  set_inverse_modulus(scene.full);
  return scene;
}

struct FreeRow {
  const char* name;
  openmp::SweepRow sweep_row;

  friend void PrintTo(const FreeRow& row, std::ostream* stream) { *stream << row.name; }
};

/// A backend whose compiler had a freedom that ours have not.
class FreeBackend : public testing::TestWithParam<FreeRow> {
protected:
  void SetUp() override {
    if (__builtin_cpu_supports("fma") == 0 || __builtin_cpu_supports("avx2") == 0) {
      GTEST_SKIP() << "this processor has no fused multiply-add";
    }
  }
  std::unique_ptr<Backend> backend_ =
      make_openmp_with(GetParam().name, GetParam().sweep_row, GetParam().name);
};

INSTANTIATE_TEST_SUITE_P(Compiled, FreeBackend,
                         testing::Values(FreeRow{"contracted", energies::Hdm::contracted::sweep_row},
                                         FreeRow{"reordered", energies::Hdm::reordered::sweep_row}),
                         [](const auto& information) { return information.param.name; });

TEST_P(FreeBackend, LandsInTheThirdTierWhereCandidatesNearlyTie) {
  for (const Comparison& comparison : test::verified(make_tie_rich_scene(), *backend_)) {
    if (test::is_idle(comparison)) {
      continue;
    }
    EXPECT_EQ(comparison.verdict, Verdict::certified) << name_of(comparison.mode);
    EXPECT_EQ(comparison.tier, Tier::certified);
    EXPECT_GT(comparison.certified_ties, 10);
    EXPECT_EQ(comparison.certified_ties, comparison.sites_differing);
    EXPECT_EQ(comparison.uncertified, 0);
    EXPECT_LE(comparison.largest_gap_over_bound, 1.0);
    EXPECT_GT(comparison.largest_gap_over_bound, 0.0);
    EXPECT_EQ(comparison.counts_differing, 0);
    ASSERT_TRUE(comparison.first.has_value());
    EXPECT_TRUE(comparison.first->certificate.holds);
    if (comparison.mode == Mode::free) {
      EXPECT_GT(comparison.sites_drifted, 2 * comparison.sites_differing) << "drift is no difference";
    }
  }
}

TEST_P(FreeBackend, WhatTheCompilerDidIsNamed) {
  Scene scene = make_tie_rich_scene();
  use_method(scene, find_method("closed-form"), 4);
  const bool is_fused = std::string_view(GetParam().name) == "contracted";
  for (const Comparison& comparison : test::verified(scene, *backend_)) {
    if (comparison.mode == Mode::resync) {
      EXPECT_THAT(comparison.why,
                  testing::AllOf(testing::StartsWith(is_fused ? "every product is fused"
                                                              : "terms are added in another order"),
                                 testing::HasSubstr("that makes all")));
    }
  }
}

TEST_P(FreeBackend, HasTheBitsOfScalarWhereAllIsExact) {
  std::vector<Scene> scenes{test::textured_scene("dyadic", {72, 60}, Texture::dyadic, 11, 20)};
  for (const char* const name : {"exact-textures", "exact-pyramid", "exact-square"}) {
    scenes.push_back(load_scene(name));
  }
  for (Scene& scene : scenes) {
    scene.schedule.iterations = std::min(scene.schedule.iterations, 8);
    for (const Comparison& comparison : test::verified(scene, *backend_)) {
      if (test::is_idle(comparison)) {
        continue;
      }
      EXPECT_EQ(comparison.verdict, Verdict::agree) << scene.name;
      EXPECT_EQ(comparison.tier, scene.exact ? Tier::exact : Tier::bitwise) << scene.name;
    }
  }
}

} // namespace
} // namespace hdmbench
