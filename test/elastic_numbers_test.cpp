// Where the numbers of the elastic energy end: fields at rest, weak springs, extreme contrasts and units.

#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/planner.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "test/sessions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;

Scene scene_of(Level level, std::string_view method, int effort, double poisson = 0.3) {
  Scene scene;
  scene.name = "test";
  scene.full = std::move(level);
  scene.poisson = poisson;
  use_method(scene, find_method(method, EnergyModel::elastic), effort);
  return scene;
}

Scene shipped(const char* name, int size) {
  Scene scene = load_scene(name, {.size = Extent{size, size}});
  use_method(scene, usual_method(EnergyModel::elastic));
  return scene;
}

ReferenceField truth_of(const Scene& scene) {
  return solve_finite_elements(elastic_problem(scene.full), ElementRule::plane_stress(scene.poisson));
}

Plan plan(const Scene& scene, const Request& request) {
  return solve_as_needed(scene, request, test::find("openmp"), {}, test::silent());
}

Solution solved(const Scene& scene) {
  const auto session = test::find("openmp").open_elastic({});
  return solve_elastic(scene, *session, test::silent());
}

/// Pixels between the field and the truth.
double error_of(const VectorField& field, const ReferenceField& truth) {
  return rmsd(ReferenceField(field), truth);
}

bool warns(const Scene& scene, const Solution& solution, std::string_view kind) {
  return std::ranges::any_of(diagnose(scene, solution),
                             [&](const Warning& warning) { return warning.kind == kind; });
}

/// An estimate may be a few times too low, and no field is nearer than rounding.
void expect_honest(const Solution& solution, const ReferenceField& truth, const std::string& what) {
  const double error = error_of(solution.displacement, truth);
  if (solution.estimated_error) {
    EXPECT_LE(error, 4.0 * *solution.estimated_error + 1e-5) << what;
  }
}

void expect_kept(const Scene& scene, double asked, const ReferenceField& truth, const std::string& what) {
  const Plan made = plan(scene, {.accuracy = asked});
  EXPECT_TRUE(!made.met || error_of(made.solution.displacement, truth) <= asked)
      << what << ": " << made.outcome << "; truth " << error_of(made.solution.displacement, truth);
  expect_honest(made.solution, truth, what + ", asked for " + std::to_string(asked));
}

/// Every observation of `level` as a spring of so many pixels.
void weaken(Level& level, double deviation) {
  for (std::vector<float>* const confidences : {&level.confidence.x, &level.confidence.y}) {
    for (float& confidence : *confidences) {
      confidence = confidence > 0.0F ? confidence_of_deviation(deviation) : 0.0F;
    }
  }
}

TEST(ElasticNumbers, GradientsEndWhereFloatDoes) {
  for (const auto& [name, size] :
       {std::pair{"square", 60}, std::pair{"circular", 60}, std::pair{"circular", 87},
        std::pair{"square-modified", 45}, std::pair{"circular-radial", 90}}) {
    const Scene scene = shipped(name, size);
    const Plan made = plan(scene, {.seconds = 100.0}); // as many steps as a plan takes
    const ReferenceField truth = truth_of(scene);
    EXPECT_LT(error_of(made.solution.displacement, truth), 1e-4) << name << ": " << made.outcome;
    expect_honest(made.solution, truth, name);
    const auto session = test::find("openmp").open_elastic({});
    ElasticSolver solver(scene.full, scene.poisson, *session);
    solver.full_multigrid();
    int steps = 0;
    while (steps < 400 && !solver.conjugate_gradients().ended) {
      ++steps;
    }
    EXPECT_LT(steps, 60) << name;
    EXPECT_LT(error_of(solver.displacement(), truth), 1e-4) << name << " after " << steps << " steps";
  }
}

/// Nothing but springs holds the sheet, and hardly.
TEST(ElasticNumbers, WeakSpringsAreEstimatedOrSolved) {
  int without_truth = 0;
  for (const double deviation : {30.0, 300.0, 1000.0, 2500.0}) {
    for (const auto& [tissue, contrast] : {std::pair{Tissue::inclusion, 3.0}, std::pair{Tissue::noise, 100.0},
                                           std::pair{Tissue::inclusion, 1e4}}) {
      for (const Extent extent : {Extent{60, 60}, Extent{71, 38}}) {
        for (const Held held : {Held::border, Held::scattered, Held::supports}) {
          Scene scene = scene_of(elastic_level(extent, tissue, held, contrast, 21),
                                 elastic_conjugate_gradients, 20, tissue == Tissue::noise ? 0.45 : 0.3);
          weaken(scene.full, deviation);
          ReferenceField truth;
          try {
            truth = truth_of(scene);
          } catch (const InputError&) { // held so weakly that a factorisation in double finds no truth
            ++without_truth;
            continue;
          }
          const std::string what =
              "deviation " + std::to_string(deviation) + ", contrast " + std::to_string(contrast) +
              ", tissue " + std::to_string(static_cast<int>(tissue)) + ", held " +
              std::to_string(static_cast<int>(held)) + ", width " + std::to_string(extent.width);
          expect_kept(scene, 0.001, truth, what);
          expect_kept(scene, 0.1, truth, what);
          expect_honest(solved(scene), truth, what + ", method");
        }
      }
    }
  }
  EXPECT_LT(without_truth, 30);
}

TEST(ElasticNumbers, ExtremeContrastsAreNotPromised) {
  for (const double contrast : {1e3, 1e5, 1e10}) {
    for (const Held held : {Held::border, Held::scattered, Held::springs, Held::supports}) {
      for (const std::uint64_t seed : {31, 32}) {
        const Scene scene = scene_of(elastic_level({53, 60}, Tissue::noise, held, contrast, seed),
                                     elastic_conjugate_gradients, 30);
        const ReferenceField truth = truth_of(scene);
        for (const double asked : {0.1, 0.01, 0.001}) {
          expect_kept(scene, asked, truth,
                      "contrast " + std::to_string(contrast) + ", held " +
                          std::to_string(static_cast<int>(held)));
        }
      }
    }
  }
}

/// A hole is filled by what is around it, however soft it is: until float no longer tells how.
TEST(ElasticNumbers, HolesAreFilledOrNotPromised) {
  const auto with_hole = [](float modulus) {
    Scene scene = shipped("circular", 100);
    for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
      float& own = scene.full.modulus.values[site];
      own = scene.labels.values[site] == 2 ? modulus : own;
    }
    set_inverse_modulus(scene.full);
    return scene;
  };
  const ReferenceField truth = truth_of(with_hole(1e-5F));
  for (const float modulus : {1e-6F, 1e-12F, 1e-25F, 1e-35F}) {
    const Scene scene = with_hole(modulus);
    const Plan made = plan(scene, {.accuracy = 0.01});
    EXPECT_EQ(made.met, modulus > 1e-30F) << modulus << ": " << made.outcome;
    EXPECT_EQ(solved(scene).estimated_error.has_value(), modulus > 1e-30F) << modulus;
    if (made.met) {
      EXPECT_LT(error_of(made.solution.displacement, truth), 0.01) << modulus;
    }
  }
}

/// Two phases 5 : 60, observations that are springs.
TEST(ElasticNumbers, CyclesAreEstimatedByTheirOwnPace) {
  for (const Tissue tissue : test::all_tissues) {
    for (const Held held : test::all_held) {
      for (const int cycles : {2, 3, 5, 9}) {
        Scene scene =
            scene_of(elastic_level({80, 73}, tissue, held, 12.0, 41), elastic_full_multigrid, cycles);
        for (const double deviation : {0.0, 3.0}) {
          if (deviation > 0.0) {
            weaken(scene.full, deviation);
          }
          expect_honest(solved(scene), truth_of(scene),
                        "tissue " + std::to_string(static_cast<int>(tissue)) + ", held " +
                            std::to_string(static_cast<int>(held)) + ", cycles " + std::to_string(cycles) +
                            ", deviation " + std::to_string(deviation));
        }
      }
    }
  }
}

TEST(ElasticNumbers, OnlyRatiosOfModuliMatter) {
  for (const Held held : {Held::border, Held::springs}) {
    for (const std::string_view method :
         {elastic_conjugate_gradients, elastic_full_multigrid, elastic_sweeps}) {
      const Scene scene = scene_of(elastic_level({50, 47}, Tissue::noise, held, 100.0, 51), method, 4);
      const Solution usual = solved(scene);
      for (const int exponent : {-100, -66, -30, -1, 7, 50, 100}) {
        Scene scaled = scene;
        for (float& modulus : scaled.full.modulus.values) {
          modulus = std::ldexp(modulus, exponent);
        }
        set_inverse_modulus(scaled.full);
        const Solution found = solved(scaled);
        EXPECT_EQ(found.displacement.x, usual.displacement.x) << method << ", 2^" << exponent;
        EXPECT_EQ(found.displacement.y, usual.displacement.y) << method << ", 2^" << exponent;
        EXPECT_EQ(found.estimated_error, usual.estimated_error) << method << ", 2^" << exponent;
      }
    }
  }
}

TEST(ElasticNumbers, UnitsOfModuliBreakNoPromise) {
  for (const float unit : {1e15F, 1e30F, 1e-20F, 1e-30F}) {
    for (const auto& [name, size] : {std::pair{"square", 60}, std::pair{"circular", 131}}) {
      Scene scene = shipped(name, size);
      const ReferenceField truth = truth_of(scene);
      for (float& modulus : scene.full.modulus.values) {
        modulus *= unit;
      }
      set_inverse_modulus(scene.full);
      for (const double asked : {1.0, 0.01}) {
        const Plan made = plan(scene, {.accuracy = asked});
        EXPECT_TRUE(made.met) << made.outcome;
        EXPECT_LE(error_of(made.solution.displacement, truth), asked) << name << " times " << unit;
      }
    }
  }
}

TEST(ElasticNumbers, AFieldThatCannotBeOneMeetsNothing) {
  const Scene scene = shipped("square", 40);
  Plan made;
  made.solution.displacement = VectorField(scene.extent());
  const Request request{.accuracy = 0.1, .seconds = 10.0};
  made.solution.estimated_error = 0.01;
  conclude(made, scene, request, 1.0);
  EXPECT_TRUE(made.met);
  for (const float value :
       {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), 1e18F}) {
    made.solution.displacement.x[70] = value;
    for (const Request& wanted : {request, Request{.seconds = 10.0}}) {
      made.solution.estimated_error = 0.01;
      conclude(made, scene, wanted, 1.0);
      EXPECT_FALSE(made.met) << value;
      EXPECT_THAT(made.outcome, testing::HasSubstr("(the field ")) << value;
    }
    EXPECT_TRUE(warns(scene, made.solution, std::isfinite(value) ? "divergence" : "not-finite")) << value;
  }
}

/// Nothing is left to be done, so the field is as near as float can be.
TEST(ElasticNumbers, FieldsWithoutStrainAreKnown) {
  for (const float way : {0.0F, 3.0F}) {
    for (const bool sprung : {false, true}) {
      for (const std::string_view method : {elastic_conjugate_gradients, elastic_full_multigrid}) {
        Scene scene = scene_of(elastic_level({40, 33}, Tissue::inclusion, Held::border, 5.0, 61), method, 8);
        std::ranges::fill(scene.full.target.x, way);
        std::ranges::fill(scene.full.target.y, -way);
        if (sprung) {
          weaken(scene.full, 1.0);
        }
        const Solution solution = solved(scene);
        ASSERT_TRUE(solution.estimated_error) << method << " " << way;
        EXPECT_LT(*solution.estimated_error, 1e-5) << method << " " << way;
        EXPECT_FALSE(warns(scene, solution, "no-estimate")) << method << " " << way;
        const Plan made = plan(scene, {.accuracy = 0.001});
        EXPECT_TRUE(made.met) << made.outcome;
      }
    }
  }
}

} // namespace
} // namespace hdmbench
