// Strains and stresses read from a displacement: closed forms, and the change of area as the same text.

#include "harness/judge/diagnosis/deformation.hpp"
#include "harness/scene/images/images.hpp"
#include "reference/circular_inclusion.hpp"
#include "test/elastic_checks.hpp"
#include "test/files.hpp"
#include "test/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace hdmbench {
namespace {

using test::sampled;
using test::Vector;
using testing::HasSubstr;

constexpr Extent extent{9, 7};
constexpr double modulus = 20.0;

Strains of(const test::Displacement& displacement, double poisson) {
  return strains_of(sampled(extent, displacement).to_float(),
                    ScalarField(extent, static_cast<float>(modulus)), poisson);
}

void expect_everywhere(const ScalarField& field, double expected) {
  for (const float value : field.values) {
    EXPECT_NEAR(static_cast<double>(value), expected, 1e-6 * (1.0 + std::abs(expected)));
  }
}

TEST(Strains, OfAffineFieldsAreThoseOfTheTextbook) {
  for (const double nu : {0.0, 0.3, 0.5}) {
    const double pull = 0.0625; // uniaxial stress along x: contracts by nu across
    const Strains stretched = of([&](double x, double y) { return Vector{pull * x, -nu * pull * y}; }, nu);
    expect_everywhere(stretched.xx, pull);
    expect_everywhere(stretched.yy, -nu * pull);
    expect_everywhere(stretched.xy, 0.0);
    expect_everywhere(stretched.von_mises, modulus * pull);
    const Strains sheared = of([](double, double y) { return Vector{0.125 * y, 0.0}; }, nu);
    expect_everywhere(sheared.xy, 0.0625);
    expect_everywhere(sheared.von_mises, std::sqrt(3.0) * modulus / (2.0 * (1.0 + nu)) * 0.125);
    const Strains swollen = of([](double x, double y) { return Vector{0.25 * x, 0.25 * y}; }, nu);
    expect_everywhere(swollen.von_mises, modulus * 0.25 / (1.0 - nu));
    const Strains turned = of([](double x, double y) { return Vector{-0.5 * y, 0.5 * x}; }, nu);
    expect_everywhere(turned.von_mises, 0.0);
  }
}

/// x^2 is not affine: where in its pixel a site is looked at shows. Elements take (x, x + 1) as 2 x + 1.
TEST(Strains, OfASiteAreTheMeanOverTheCellsAround) {
  const Strains strains = of([](double x, double) { return Vector{x * x, 0.0}; }, 0.0);
  EXPECT_FLOAT_EQ(strains.xx.values[extent.index(0, 3)], 1.0F);
  EXPECT_FLOAT_EQ(strains.xx.values[extent.index(4, 3)], 8.0F);
  const Strains across = of([](double x, double y) { return Vector{x * y, 0.0}; }, 0.0);
  EXPECT_FLOAT_EQ(across.xx.values[extent.index(4, 3)], 3.0F);
  EXPECT_NEAR(across.xx.values[extent.index(4, 0)], 0.5 * (1.0 - 1.0 / std::sqrt(3.0)), 1e-6)
      << "at a border the Gauss point of the only cell";
  const Strains down = of([](double x, double y) { return Vector{0.0, x * y}; }, 0.0);
  EXPECT_NEAR(down.yy.values[extent.index(0, 3)], 0.5 * (1.0 - 1.0 / std::sqrt(3.0)), 1e-6);
}

/// Inside a round inclusion the stress is the same everywhere.
TEST(Strains, OfFiniteElementsAreTheStressOfTheClosedForm) {
  const int side = 129;
  for (const double contrast : {0.1, 10.0}) {
    const CircularInclusion truth({.radius = 0.2 * (side - 1),
                                   .modulus_inside = contrast * modulus,
                                   .modulus_outside = modulus,
                                   .poisson = 0.3,
                                   .stretch = 0.1});
    const ElasticProblem problem = truth.on_pixels(side);
    ScalarField moduli({side, side});
    std::ranges::transform(problem.modulus, moduli.values.begin(),
                           [](double value) { return static_cast<float>(value); });
    const Strains strains =
        strains_of(solve_finite_elements(problem, ElementRule::plane_stress(0.3)).to_float(), moduli, 0.3);
    for (const std::complex<double> z : {std::complex(0.0, 0.0), std::complex(9.0, -4.0),
                                         std::complex(40.0, 7.0), std::complex(-8.0, 45.0)}) {
      const auto stress = truth.stress(z);
      const double expected = std::sqrt(stress.xx * stress.xx - stress.xx * stress.yy +
                                        stress.yy * stress.yy + 3.0 * stress.xy * stress.xy);
      const std::size_t at =
          problem.extent.index(side / 2 + static_cast<int>(z.real()), side / 2 + static_cast<int>(z.imag()));
      EXPECT_NEAR(static_cast<double>(strains.von_mises.values[at]), expected, 0.04 * expected)
          << "contrast " << contrast << " at " << z.real() << ", " << z.imag();
    }
  }
}

/// det(I + grad d) = 1 + trace + det, and for small strains the trace is what the area gains.
TEST(Strains, AndChangeOfAreaAreOneText) {
  const test::Displacement small = [](double x, double y) {
    return Vector{1e-3 * x + 2e-3 * y, -3e-3 * x + 4e-3 * y};
  };
  const ScalarField area = area_change_map(sampled(extent, small).to_float());
  const Strains strains = of(small, 0.3);
  for (std::size_t i = 0; i < area.values.size(); ++i) {
    EXPECT_NEAR(area.values[i], strains.xx.values[i] + strains.yy.values[i] + 1e-3 * 4e-3 + 2e-3 * 3e-3,
                1e-6);
  }
}

TEST(Strains, AreWrittenOnRequest) {
  if (!have_images()) {
    test::expect_run(2, "run square --size 20 --strains", HasSubstr("needs image support"));
    return;
  }
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string();
  test::expect_run(
      0, "run square --energy elastic --size 40 --strains --output " + at + " --json " + at + "/r.json",
      HasSubstr("von-mises: MPa, plane stress, Poisson ratio 0.3"));
  const nlohmann::json row = test::read_json(folder.path() / "r.json")["results"][0];
  ASSERT_EQ(row["strains"].size(), 9U);
  for (const std::string name : row["strains"]) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / name)) << name;
  }
  const ScalarField stress = read_scalar(folder.path() / "square-von-mises.nrrd").pixels;
  EXPECT_EQ(stress.extent, (Extent{40, 40}));
  EXPECT_GT(*std::ranges::max_element(stress.values), 0.0F);
  test::expect_run(0, "run square --size 20 --output " + at + "/without --json " + at + "/w.json");
  EXPECT_TRUE(test::read_json(folder.path() / "w.json")["results"][0]["strains"].empty());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "without/square-von-mises.nrrd"));
}

} // namespace
} // namespace hdmbench
