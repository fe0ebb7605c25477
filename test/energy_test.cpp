// The specification against the thesis: the texts of kernels/specification beside (4.5)-(4.17) as printed.

#include "harness/scene/sites.hpp"
#include "reference/thesis_energy.hpp"
#include "test/counted_operations.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

double total(ThesisEnergy::Value value) {
  return value.x + value.y + value.z;
}

TEST(Energy, MeanEnergyIsTheMeanOfTheThesisEnergy) {
  for (const Extent extent : {Extent{31, 12}, {7, 6, 5}}) {
    const auto [level, start] = test::random_problem(extent, test::Texture::smooth, 3);
    const ThesisEnergy thesis(level, start);
    double sum = 0.0;
    for_each_site(extent, [&](int x, int y, int z) { sum += total(thesis.at(x, y, z)); });
    const double expected = sum / static_cast<double>(extent.sites());
    // Around 40 float operations a site, errors of either sign.
    EXPECT_NEAR(mean_energy(level, start), expected, 40 * std::numeric_limits<float>::epsilon() * expected);
  }
}

/// Without observations U_t is a parabola in each component: two energies beside the centre's have its
/// gradient and curvature.
TEST(Energy, GradientAndCurvatureAreThoseOfTheThesis) {
  for (const Extent extent : {Extent{23, 17}, {6, 5, 4}}) {
    test::Problem problem = test::random_problem(extent, test::Texture::smooth, 13);
    problem.level.confidence = VectorField(extent);
    const ThesisEnergy thesis(problem.level, problem.start);
    for_each_site(extent, [&](int x, int y, int z) {
      const PriorAtSite prior = problem.level.energy->host->prior(problem.level, problem.start, x, y, z);
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        const auto energy = [&](double step) {
          std::array<double, 3> centre{};
          for (std::size_t i = 0; i < extent.axes(); ++i) {
            centre[i] =
                static_cast<double>(problem.start[i][extent.index(x, y, z)]) + (i == axis ? step : 0.0);
          }
          return total(thesis.at(x, y, {centre[0], centre[1], centre[2]}, z));
        };
        const double gradient = (energy(1.0) - energy(-1.0)) / 4.0;
        const double curvature = (energy(1.0) + energy(-1.0) - 2.0 * energy(0.0)) / 2.0;
        EXPECT_NEAR(prior.gradient[axis], gradient, 1e-5 * (curvature * 20.0)) << x << ", " << y << ", " << z;
        EXPECT_NEAR(prior.curvature[axis], curvature, 1e-5 * curvature) << x << ", " << y << ", " << z;
      }
    });
  }
}

/// Every operation is exact on dyadic levels, so a tie is a tie in any order of summation.
TEST(ThesisIcm, EverySiteTakesTheFirstBestCandidateOfTheThesisEnergy) {
  int tied = 0;
  for (const Extent extent :
       {Extent{29, 31}, {1, 1}, {1, 7}, {6, 1}, {2, 2}, {5, 7, 3}, {2, 2, 2}, {9, 6, 8}}) {
    test::Problem problem =
        test::random_problem(extent, test::Texture::dyadic, 6, StepSet::parse("0,-1,1,-0.25,0.25,-0.5,0.5"));
    for (int iteration = 0; iteration < 20; ++iteration) {
      const VectorField next = test::swept(problem, 1);
      const ThesisEnergy energy(problem.level, problem.start);
      for_each_site(extent, [&](int x, int y, int z) {
        const std::size_t site = extent.index(x, y, z);
        std::array<double, 3> lowest{1e300, 1e300, 1e300};
        std::array<double, 3> best{};
        for (const float step : problem.level.steps.values()) {
          std::array<double, 3> to{};
          for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
            to[axis] = double{problem.start[axis][site]} + double{step};
          }
          const auto [in_x, in_y, in_z] = energy.at(x, y, {to[0], to[1], to[2]}, z);
          const std::array found{in_x, in_y, in_z};
          for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
            tied += found[axis] == lowest[axis] ? 1 : 0;
            best[axis] = found[axis] < lowest[axis] ? to[axis] : best[axis];
            lowest[axis] = std::min(found[axis], lowest[axis]);
          }
        }
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          ASSERT_EQ(next[axis][site], best[axis])
              << x << ", " << y << ", " << z << ", iteration " << iteration;
        }
      });
      problem.start = next;
    }
  }
  EXPECT_GT(tied, 0) << "no two candidates ever tied";
}

/// Operations of an update of one site, as they stand in the texts with the scalar counted::real.
int counted_operations(SiteKind kind, int candidates) {
  using Counted = Hdm<counted::real>;
  using counted::Knowledge;
  counted::numbers.clear();
  counted::compared.clear();
  int next = 0;
  const auto given = [&](Knowledge knowledge) { return counted::real::given(next++, knowledge); };
  const auto neighbours = [&](Knowledge knowledge) {
    const auto one = [&] { return given(knowledge); };
    return Counted::Neighbours{one(), one(), one(), one(), one(), one(), one(), one(), one()};
  };
  const bool uniform = kind == SiteKind::uniform || kind == SiteKind::uniform_unobserved;
  const bool observed = kind == SiteKind::general || kind == SiteKind::uniform;
  Counted::Site site{};
  site.dx = neighbours(Knowledge::varying);
  site.dy = neighbours(Knowledge::varying);
  const counted::real same = given(Knowledge::invariant);
  site.inverse_modulus = uniform ? Counted::Neighbours{same, same, same, same, same, same, same, same, same}
                                 : neighbours(Knowledge::varying);
  site.modulus = given(uniform ? Knowledge::invariant : Knowledge::varying);
  site.target_x = given(Knowledge::varying);
  site.target_y = given(Knowledge::varying);
  site.confidence_x = observed ? given(Knowledge::varying) : counted::real(0);
  site.confidence_y = observed ? given(Knowledge::varying) : counted::real(0);
  site.penalty = given(Knowledge::invariant);
  counted::real steps[StepSet::maximum_count];
  for (counted::real& step : steps) {
    step = given(Knowledge::invariant);
  }
  const auto moved =
      Counted::moved_displacement(Counted::rule_steps, observed, site, {}, {}, steps, candidates);
  std::set<int> needed = counted::compared;
  for (const std::set<int>* const more : {&moved.x.operations(), &moved.y.operations()}) {
    needed.insert(more->begin(), more->end());
  }
  return static_cast<int>(needed.size());
}

// What `bench` divides by seconds.
TEST(Energy, OperationsAreThoseOfTheTexts) {
  for (std::size_t i = 0; i < site_kinds; ++i) {
    for (int candidates = 2; candidates <= StepSet::maximum_count; ++candidates) {
      EXPECT_EQ(thesis_energy.costs[i].operations(candidates),
                counted_operations(static_cast<SiteKind>(i), candidates))
          << "kind " << i << ", " << candidates << " candidates";
    }
  }
}

} // namespace
} // namespace hdmbench
