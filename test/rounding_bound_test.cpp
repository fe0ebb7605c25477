// The derived bound of float32 rounding: never exceeded, not much larger than what happens, and what it is
// used for: a choice of a candidate that rounding explains passes, another does not.

#include "harness/check/certificate.hpp"

#include "harness/check/faults/faulty_backend.hpp"
#include "harness/judge/arithmetic.hpp"
#include "kernels/data/gather.hpp"
#include "reference/thesis_energy.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {
namespace {

using test::Texture;

/// x component of the energy change as the kernels compute it.
float computed_change(const HdmInFloat::Site& site, float step) {
  return HdmInFloat::energy_change(step, HdmInFloat::prior_of(site).gradient_x,
                                   HdmInFloat::prior_of(site).curvature_x, site.target_x - site.dx.centre,
                                   site.penalty * site.confidence_x);
}

double exact_change(const ThesisEnergy& energy, const VectorField& field, int x, int y, float step) {
  const auto i = field.extent.index(x, y);
  const ThesisEnergy::Value moved{static_cast<double>(field.x[i]) + static_cast<double>(step), field.y[i]};
  return energy.at(x, y, moved).x - energy.at(x, y).x;
}

TEST(RoundingBound, IsNeverExceededAndIsReached) {
  for (const Texture texture : {Texture::smooth, Texture::tie_rich}) {
    double largest_share = 0.0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto [level, field] = test::random_problem({60, 50}, texture, seed);
      const ThesisEnergy energy(level, field);
      for (int y = 0; y < level.extent.height; ++y) {
        for (int x = 0; x < level.extent.width; ++x) {
          for (const float step : {-1.0F, 0.1F}) {
            const float computed = computed_change(gather<Hdm<float>>(level, field, x, y), step);
            const double error =
                std::abs(static_cast<double>(computed) - exact_change(energy, field, x, y, step));
            const double bound = energy_change_bound(level, field, x, y, step, step).x;
            ASSERT_LE(error, bound) << "seed " << seed << ", x = " << x << ", y = " << y << ", step " << step;
            largest_share = std::max(largest_share, error / bound);
          }
        }
      }
    }
    EXPECT_GE(largest_share, 0.1) << "a bound that nothing comes near lets mistakes pass";
  }
}

TEST(RoundingBound, IsTheSameForBothComponentsOfATransposedProblem) {
  const auto [level, field] = test::random_problem({9, 9}, Texture::smooth, 5);
  Level transposed = level;
  VectorField transposed_field = field;
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      const auto from = level.extent.index(x, y);
      const auto to = level.extent.index(y, x);
      transposed.modulus.values[to] = level.modulus.values[from];
      transposed.target.x[to] = level.target.y[from];
      transposed.confidence.x[to] = level.confidence.y[from];
      transposed_field.x[to] = field.y[from];
    }
  }
  set_inverse_modulus(transposed);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      const double here = energy_change_bound(level, field, x, y, 0.0F, 0.1F).y;
      const double there = energy_change_bound(transposed, transposed_field, y, x, 0.1F, 0.0F).x;
      EXPECT_NEAR(here, there, 0.2 * here); // the diagonals are summed in another order
    }
  }
}

Scene scene_of(Texture texture) {
  return test::textured_scene("arithmetic", {80, 60}, texture, 8, 12);
}

ArithmeticError measure(const Scene& scene, const Backend& backend) {
  return measure_arithmetic(scene, backend, {}, 1, test::silent());
}

class Arithmetic : public testing::TestWithParam<Texture> {};

TEST_P(Arithmetic, OfTheKernelsIsExplainedByRounding) {
  for (const auto& backend : test::backends()) {
    ArithmeticError error;
    try {
      error = measure(scene_of(GetParam()), *backend);
    } catch (const DeviceError&) {
      continue; // `devices` says why
    }
    EXPECT_GT(error.steps_compared, 100000);
    EXPECT_EQ(error.beyond_bound, 0) << backend->name();
    EXPECT_LE(error.largest_gap_over_bound, 1.0) << backend->name();
    if (GetParam() == Texture::tie_rich) {
      EXPECT_GT(error.steps_differing, 0) << "nothing was judged";
    }
  }
}

TEST_P(Arithmetic, OfAFaultIsNot) {
  using faults::Fault;
  const std::vector<Fault> faults{
      {.name = "moduli_off_by_a_thousandth",
       .in_level =
           [](Level& level) {
             for (std::size_t i = 0; i < level.inverse_modulus.values.size(); i += 3) {
               level.inverse_modulus.values[i] *= 1.001F;
             }
           }},
      {.name = "candidate_missing",
       .in_level = [](Level& level) { level.steps = StepSet::parse("0,-1,-0.1,1"); }},
      {.name = "one_site_off", .in_read = [](VectorField& field) { field.x.back() += 0.05F; }},
      {.name = "not_a_number", .in_read = [](VectorField& field) { field.y.front() = NAN; }},
      {.name = "skipped_sweep", .in_step = [](int) { return 0; }}};
  for (const Fault& fault : faults) {
    const ArithmeticError error = measure(scene_of(GetParam()), faults::FaultyBackend(test::scalar(), fault));
    EXPECT_GT(error.beyond_bound, 0) << fault.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Textures, Arithmetic, testing::Values(Texture::smooth, Texture::tie_rich),
                         [](const auto& parameter) {
                           return parameter.param == Texture::smooth ? "smooth" : "tie_rich";
                         });

} // namespace
} // namespace hdmbench
