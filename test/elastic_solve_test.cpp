// The methods of the elastic energy against finite elements by a direct factorisation in double.

#include "backends/registry.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "test/elastic_checks.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;

double distance(const VectorField& field, const ReferenceField& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.x.size(); ++i) {
    sum += std::pow(static_cast<double>(field.x[i]) - truth.x[i], 2.0) +
           std::pow(static_cast<double>(field.y[i]) - truth.y[i], 2.0);
  }
  return std::sqrt(sum / static_cast<double>(truth.x.size()));
}

SessionOptions two_threads() {
  SessionOptions options;
  options.threads = 2;
  return options;
}

std::unique_ptr<ElasticSession> open_session() {
  return find_backend(make_backends(), "openmp").open_elastic(two_threads());
}

ReferenceField truth_of(const Level& level, double poisson) {
  return solve_finite_elements(elastic_problem(level), ElementRule::plane_stress(poisson));
}

/// Pixels from the truth after full multigrid and at most `steps` of conjugate gradients.
double solved(const Level& level, double poisson, int steps) {
  const auto session = open_session();
  ElasticSolver solver(level, poisson, *session);
  solver.full_multigrid();
  for (int i = 0; i < steps; ++i) {
    if (solver.conjugate_gradients().ended) {
      break;
    }
  }
  return distance(solver.displacement(), truth_of(level, poisson));
}

/// Targets reach 5 pixels. Thin layers of very different moduli take longest: their coarse modulus is a mean.
TEST(ElasticSolve, ConvergesWhateverTheTissue) {
  for (const Tissue tissue : test::all_tissues) {
    for (const Held held : test::all_held) {
      for (const double contrast : {1.0, 10.0, 1000.0}) {
        for (const double poisson : {0.0, 0.3, 0.49}) {
          const Level level = elastic_level({49, 38}, tissue, held, contrast, 5);
          const int steps = contrast == 1.0            ? (held == Held::springs ? 12 : 6)
                            : contrast == 10.0         ? 10
                            : tissue == Tissue::layers ? 70
                                                       : 30;
          EXPECT_LT(solved(level, poisson, steps), 1e-4)
              << "tissue " << static_cast<int>(tissue) << ", held " << static_cast<int>(held) << ", contrast "
              << contrast << ", Poisson ratio " << poisson;
        }
      }
    }
  }
}

TEST(ElasticSolve, FullMultigridAloneIsAsRightAsThePixels) {
  EXPECT_LT(solved(elastic_level({97, 80}, Tissue::inclusion, Held::border, 3.0, 6), 0.3, 0), 5e-3);
  EXPECT_LT(solved(elastic_level({97, 80}, Tissue::inclusion, Held::regions, 3.0, 6), 0.3, 0), 5e-2);
}

TEST(ElasticSolve, OddAndThinImages) {
  for (const Extent extent :
       {Extent{2, 2}, Extent{5, 4}, Extent{8, 8}, Extent{33, 64}, Extent{2, 60}, Extent{61, 3}}) {
    const Level level = elastic_level(extent, Tissue::noise, Held::border, 30.0, 8);
    EXPECT_LT(solved(level, 0.3, 30), 1e-4) << extent.width << " x " << extent.height;
  }
}

/// A sheet of one tissue that is stretched, sheared and turned at its border only is so everywhere.
TEST(ElasticSolve, PatchTest) {
  const Extent extent{60, 45};
  Level level = elastic_level(extent, Tissue::inclusion, Held::border, 1.0, 9);
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const bool border = x == 0 || y == 0 || x + 1 == extent.width || y + 1 == extent.height;
      const std::size_t at = extent.index(x, y);
      level.target.x[at] = 0.1F * static_cast<float>(x) - 0.03F * static_cast<float>(y);
      level.target.y[at] = 0.07F * static_cast<float>(y) + 0.02F * static_cast<float>(x);
      level.confidence.x[at] = level.confidence.y[at] = border ? 1.0F : 0.0F;
    }
  }
  const auto session = open_session();
  ElasticSolver solver(level, 0.3, *session);
  solver.full_multigrid();
  (void)solver.conjugate_gradients();
  EXPECT_LT(distance(solver.displacement(), ReferenceField(level.target)), 1e-5);
}

Scene scene_of(Level level, std::string_view method, int effort) {
  Scene scene;
  scene.full = std::move(level);
  use_method(scene, find_method(method, EnergyModel::elastic), effort);
  return scene;
}

TEST(ElasticSolve, EveryMethodAndBackendOfAScene) {
  const auto registry = make_backends();
  const Level level = elastic_level({70, 53}, Tissue::inclusion, Held::scattered, 10.0, 10);
  const ReferenceField truth = truth_of(level, 0.3);
  Progress progress(false);
  double before = 1e9;
  for (const auto& [method, effort] :
       {std::pair{elastic_sweeps, 20}, std::pair{elastic_full_multigrid, 1},
        std::pair{elastic_full_multigrid, 3}, std::pair{elastic_conjugate_gradients, 6}}) {
    const Scene scene = scene_of(level, method, effort);
    const Solution scalar = Solver(find_backend(registry, "scalar"), {}).solve(scene, progress);
    const Solution threaded = Solver(find_backend(registry, "openmp"), two_threads()).solve(scene, progress);
    EXPECT_EQ(scalar.displacement.x, threaded.displacement.x) << method;
    EXPECT_EQ(scalar.displacement.y, threaded.displacement.y) << method;
    const double now = distance(threaded.displacement, truth);
    EXPECT_LT(now, before) << method << " " << effort;
    before = now;
    for (std::size_t i = 0; i < level.extent.sites(); ++i) { // conditions stand to the bit
      if (level.confidence.x[i] > 0.0F) {
        ASSERT_EQ(threaded.displacement.x[i], level.target.x[i]);
      }
    }
  }
  EXPECT_LT(before, 1e-4);
}

/// Pixels between our field at rest and a curved one that is in balance without any force: Muskhelishvili's
/// potentials phi = w^5 and psi = 0 of w = z / side (a cubic one is met exactly at the nodes). `kappa` is (3
/// - nu) / (1 + nu) where all is right.
double smooth_error(int n, double poisson, double kappa) {
  const double side = n - 1;
  const ReferenceField exact = test::sampled({n, n}, [&](double x, double y) {
    const std::complex<double> w(x / side - 0.5, y / side - 0.5);
    const std::complex<double> moved = 50.0 * (kappa * std::pow(w, 5) - 5.0 * w * std::conj(std::pow(w, 4)));
    return test::Vector{moved.real(), moved.imag()};
  });
  Level level{.extent = exact.extent,
              .target = exact.to_float(),
              .confidence = VectorField(exact.extent),
              .modulus = ScalarField(exact.extent, 20.0F)};
  for_each_site(level.extent, [&](int x, int y) {
    const bool border = x == 0 || y == 0 || x + 1 == n || y + 1 == n;
    const std::size_t at = level.extent.index(x, y);
    level.confidence.x[at] = level.confidence.y[at] = border ? 1.0F : 0.0F;
  });
  set_inverse_modulus(level);
  const auto session = open_session();
  ElasticSolver solver(level, poisson, *session);
  solver.full_multigrid();
  for (int i = 0; i < 40 && !solver.conjugate_gradients().ended; ++i) {
  }
  return distance(solver.displacement(), exact);
}

TEST(ElasticSolve, ASampledImageIsInterpolated) {
  Scene scene = load_scene("circular", {.size = Extent{131, 120}});
  use_method(scene, usual_method(EnergyModel::elastic));
  Progress progress(false);
  const auto solved_by = [&](const char* backend, int stride) {
    scene.schedule.stride = stride;
    return Solver(find_backend(make_backends(), backend), two_threads()).solve(scene, progress).displacement;
  };
  const ReferenceField truth = truth_of(scene.full, scene.poisson);
  const VectorField field = solved_by("openmp", 4);
  const double nearest = distance(solved_by("openmp", 1), truth);
  EXPECT_EQ(field.extent, scene.extent());
  EXPECT_EQ(field.x, solved_by("scalar", 4).x);
  EXPECT_LT(nearest, distance(field, truth));
  EXPECT_LT(distance(field, truth), distance(solved_by("openmp", 16), truth));
  for (std::size_t i = 0; i < scene.extent().sites(); ++i) {
    if (scene.full.confidence.x[i] > 0.0F) {
      ASSERT_EQ(field.x[i], scene.full.target.x[i]) << i;
    }
  }
  EXPECT_THROW((void)solved_by("openmp", 64), InputError) << "3 x 3 sites";
  const auto observed = std::ranges::find(scene.full.confidence.y, 1.0F);
  ASSERT_NE(observed, scene.full.confidence.y.end());
  *observed = 0.5F; // a spring
  EXPECT_THROW((void)solved_by("openmp", 4), InputError);
}

TEST(ElasticSolve, ASmoothFieldIsMetWithOrderTwo) {
  for (const double poisson : {0.0, 0.3, 0.49}) {
    const double kappa = (3.0 - poisson) / (1.0 + poisson);
    double coarser = smooth_error(17, poisson, kappa);
    for (const int n : {33, 65}) {
      const double finer = smooth_error(n, poisson, kappa);
      EXPECT_GT(std::log2(coarser / finer), 1.9) << n << ", nu " << poisson;
      EXPECT_LT(std::log2(coarser / finer), 2.1) << n << ", nu " << poisson;
      coarser = finer;
    }
    EXPECT_LT(coarser, 2e-3);
  }
  const double plane_strain = 3.0 - 4.0 * 0.3;
  EXPECT_LT(std::log2(smooth_error(17, 0.3, plane_strain) / smooth_error(33, 0.3, plane_strain)), 0.5)
      << "a field that is not in balance";
}

TEST(ElasticSolve, EstimatesItsError) {
  for (const double contrast : {3.0, 100.0}) {
    const Level level = elastic_level({80, 80}, Tissue::noise, Held::border, contrast, 11);
    const auto session = open_session();
    Progress progress(false);
    const Scene scene = scene_of(level, elastic_conjugate_gradients, 4);
    const Solution solution = solve_elastic(scene, *session, progress);
    const double truth = distance(solution.displacement, truth_of(level, scene.poisson));
    ASSERT_TRUE(solution.estimated_error);
    EXPECT_GT(*solution.estimated_error, truth / 5.0);
    EXPECT_LT(*solution.estimated_error, truth * 10.0 + 1e-5);
  }
}

std::string refusal(const Level& level) {
  try {
    require_held(level);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ElasticConditions, AFreeSheetIsAnErrorThatSaysWhere) {
  const Extent extent{12, 9};
  Level level = elastic_level(extent, Tissue::inclusion, Held::border, 1.0, 1);
  EXPECT_EQ(refusal(level), "");
  level.confidence = VectorField(extent);
  EXPECT_THAT(refusal(level), testing::HasSubstr("all 12 x 9 sites can move in x"));
  level.confidence.x[extent.index(3, 4)] = 1.0F;
  EXPECT_THAT(refusal(level), testing::HasSubstr("can move in y"));
  level.confidence.y[extent.index(5, 7)] = 1.0F;
  EXPECT_THAT(refusal(level), testing::HasSubstr("all 12 x 9 sites can turn about x = 5, y = 4"));
  level.confidence.y[extent.index(5, 1)] = 1.0F;
  EXPECT_THAT(refusal(level), testing::HasSubstr("can turn about"));
  level.confidence.y[extent.index(6, 1)] = 1.0F;
  EXPECT_EQ(refusal(level), "");
  EXPECT_THAT(refusal(elastic_level({1, 9}, Tissue::noise, Held::border, 1.0, 1)),
              testing::HasSubstr("at least 2 x 2"));
}

/// A frame that is held, void inside, and a block of 4 x 3 pixels in it.
Level island(float void_modulus) {
  const Extent extent{20, 18};
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, void_modulus)};
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t at = extent.index(x, y);
      const bool frame = x < 2 || y < 2 || x >= 18 || y >= 16;
      const bool block = x >= 8 && x < 12 && y >= 7 && y < 10;
      level.modulus.values[at] = frame || block ? 10.0F : void_modulus;
      level.confidence.x[at] = level.confidence.y[at] = x == 0 || y == 0 ? 1.0F : 0.0F;
    }
  }
  return level;
}

TEST(ElasticConditions, AFreePartIsAnErrorThatSaysWhere) {
  EXPECT_EQ(refusal(island(1e-4F)), "") << "soft is not void";
  Level level = island(1e-7F);
  EXPECT_THAT(refusal(level), testing::AllOf(testing::HasSubstr("12 pixels at x = 8 ... 11, y = 7 ... 9"),
                                             testing::HasSubstr("it can move in x")));
  const Extent extent = level.extent;
  level.confidence.x[extent.index(5, 5)] = level.confidence.y[extent.index(5, 5)] = 1.0F;
  EXPECT_THAT(refusal(level), testing::HasSubstr("it can move in x"))
      << "a condition in the void holds nothing";
  level.confidence.x[extent.index(9, 8)] = 1.0F;
  EXPECT_THAT(refusal(level), testing::HasSubstr("it can move in y"));
  level.confidence.y[extent.index(9, 8)] = 0.5F;
  EXPECT_THAT(refusal(level), testing::HasSubstr("it can turn about x = 9, y = 8"));
  level.confidence.y[extent.index(11, 9)] = 1.0F;
  EXPECT_EQ(refusal(level), "");
}

TEST(ElasticConditions, APartThatTouchesAHeldOneIsHeld) {
  const auto joined_by = [](std::initializer_list<std::pair<int, int>> pixels) {
    Level level = island(1e-7F);
    for (const auto& [x, y] : pixels) {
      level.modulus.values[level.extent.index(x, y)] = 10.0F;
    }
    return refusal(level);
  };
  EXPECT_EQ(joined_by({{2, 8}, {3, 8}, {4, 8}, {5, 8}, {6, 8}, {7, 8}}), "");
  EXPECT_EQ(joined_by({{2, 8}, {3, 8}, {4, 8}, {5, 8}, {6, 8}}), "") << "one void pixel between";
  EXPECT_NE(joined_by({{2, 8}, {3, 8}, {4, 8}, {5, 8}}), "") << "two";
  EXPECT_EQ(joined_by({{2, 2}, {3, 3}, {4, 4}, {5, 5}, {6, 6}, {7, 7}}), "") << "diagonally";
}

TEST(ElasticConditions, ExtensionKeepsThemAndStaysBetweenThem) {
  const Level level = elastic_level({61, 47}, Tissue::noise, Held::supports, 1.0, 2);
  const VectorField field = extended_conditions(level);
  for (std::size_t i = 0; i < level.extent.sites(); ++i) {
    if (level.confidence.x[i] > 0.0F) {
      EXPECT_EQ(field.x[i], level.target.x[i]);
    }
    EXPECT_LE(std::abs(field.x[i]), 5.01F);
  }
}

} // namespace
} // namespace hdmbench
