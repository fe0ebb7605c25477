// The forces of tissues with laws of large strains: to the bit those of the host on every backend.

#include "harness/check/compare.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "test/random_level.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

namespace hdmbench {
namespace {

/// What kernels of laws ask of a level.
struct LawCase {
  Extent extent;
  std::array<double, 3> sides{1.0, 1.0, 1.0};
  bool has_fibres = false;
  bool has_walls = false; ///< and void, which half cells beside it are, too
};

/// Returns a level with moduli from 1 to 100, one site in five linear, one component in ten prescribed.
Level level_of(const LawCase& of, std::uint64_t seed) {
  Level level = test::plain_level(of.extent);
  level.sides = of.sides;
  level.has_walls = of.has_walls;
  level.law_parameter = ScalarField(of.extent);
  test::Uniform uniform(seed);
  if (of.has_fibres) {
    level.fibre = VectorField(of.extent);
    level.fibre_compression = ScalarField(of.extent);
  }
  for (std::size_t site = 0; site < of.extent.sites(); ++site) {
    const bool is_void = of.has_walls && uniform() < 0.05;
    level.modulus.values[site] = is_void ? 1e-9F : static_cast<float>(std::pow(10.0, 2.0 * uniform()));
    const double kind = uniform();
    level.law_parameter.values[site] = kind < 0.2   ? -1.0F
                                       : kind < 0.5 ? 0.0F
                                                    : static_cast<float>(5.0 * uniform());
    for (std::size_t axis = 0; axis < of.extent.axes(); ++axis) {
      level.confidence[axis][site] = uniform() < 0.1 ? 1.0F : 0.0F;
      if (of.has_fibres) {
        level.fibre[axis][site] = static_cast<float>(uniform() - 0.5);
      }
    }
    if (of.has_fibres) {
      level.fibre_compression.values[site] = uniform() < 0.5 ? 0.0F : 1.0F;
    }
  }
  return level;
}

/// Returns a displacement with slopes to `slope`: above .5 cells are turned over.
VectorField displacement_of(Extent extent, double slope, std::uint64_t seed) {
  test::Uniform uniform(seed);
  VectorField displacement(extent);
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    for (float& value : displacement[axis]) {
      value = static_cast<float>(50.0 + 2.0 * slope * (uniform() - 0.5));
    }
  }
  return displacement;
}

class LawBits : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, LawBits, testing::ValuesIn(test::backend_names()), test::parameter_name);

TEST_P(LawBits, AreThoseOfTheHost) {
  const Backend& backend = test::find(GetParam());
  if (const std::string why = test::why_absent(backend); !why.empty()) {
    GTEST_SKIP() << why;
  }
  const auto session = backend.open_elastic({});
  std::uint64_t seed = 1;
  // The last two are computed in several slabs.
  for (const LawCase& of :
       {LawCase{{37, 29}}, LawCase{{2, 2}},
        LawCase{.extent = {33, 18}, .sides = {1.0, 2.5, 1.0}, .has_fibres = true},
        LawCase{.extent = {70, 31}, .has_walls = true}, LawCase{{19, 14, 17}}, LawCase{{2, 2, 2}},
        LawCase{.extent = {35, 9, 12}, .sides = {1.0, 1.5, 3.0}, .has_fibres = true},
        LawCase{.extent = {18, 21, 11}, .has_fibres = true, .has_walls = true}, LawCase{{1201, 470}},
        LawCase{{130, 131, 34}}}) {
    const Level level = level_of(of, ++seed);
    const LawForces tissues(level, 0.3);
    session->load(ElasticBody{level, 0.3, Springs::none});
    for (const double slope : {1e-3, 0.2, 0.8}) {
      const VectorField displacement = displacement_of(of.extent, slope, ++seed);
      VectorField expected;
      VectorField found;
      const LeastVolume host = tissues(displacement, expected);
      const std::optional<LeastVolume> least = session->law_forces(tissues, displacement, found);
      if (!least) {
        GTEST_SKIP() << backend.name() << " has the host's forces of laws";
      }
      EXPECT_EQ(compare(expected, found).sites, 0U) << of.extent.text() << ", slopes to " << slope;
      EXPECT_EQ(std::pair(host.share, host.site), std::pair(least->share, least->site)) << of.extent.text();
      EXPECT_GT(largest_magnitude(found), 0.0) << of.extent.text();
    }
  }
}

} // namespace
} // namespace hdmbench
