// The specification against the thesis: the texts of kernels/specification beside (4.5)-(4.17) as printed.

#include "backends/cpu/elastic_serial.hpp"
#include "backends/shared/elastic_costs.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/volume_costs.hpp"
#include "kernels/specification/hdm/energy.hpp"
#include "reference/thesis_energy.hpp"
#include "test/distinct_operations.hpp"
#include "test/sessions.hpp"

#include <bit>

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

/// Operations of an update of each site after the first, as they stand in the texts: what is the same at all
/// sites is done by then.
template <int axes>
int operations_of_update(SiteKind kind, int candidates) {
  using Counted = Hdm<distinct::real, axes>;
  using distinct::real;
  distinct::numbers.clear();
  float next = 1.0F;
  const auto given = [&] { return real(next += 1.0F); };
  const auto neighbours = [&] { return Counted::neighbours_of([&](int /*number*/) { return given(); }); };
  const bool uniform = kind == SiteKind::uniform || kind == SiteKind::uniform_unobserved;
  const bool observed = kind == SiteKind::general || kind == SiteKind::uniform;
  const real same = given();
  const real modulus = given();
  const real penalty = given();
  real steps[StepSet::maximum_count];
  std::ranges::generate(steps, given);
  for (int site_number = 0; site_number < 2; ++site_number) {
    distinct::operations = 0;
    typename Counted::Site site{};
    for (const auto& of : Counted::of_axis) {
      site.*of.displacement = neighbours();
      site.*of.target = given();
      site.*of.confidence = observed ? given() : real();
    }
    site.inverse_modulus =
        uniform ? Counted::neighbours_of([&](int /*number*/) { return same; }) : neighbours();
    site.modulus = uniform ? modulus : given();
    site.penalty = penalty;
    (void)Counted::moved_displacement(Counted::rule_steps, observed, site, {}, {}, steps, candidates);
  }
  const int unused = observed ? 0 : axes; // the ways to targets that nobody has
  return static_cast<int>(distinct::operations) - unused;
}

// What `bench` divides by seconds.
TEST(Energy, OperationsAreThoseOfTheTexts) {
  for (std::size_t i = 0; i < site_kinds; ++i) {
    const auto kind = static_cast<SiteKind>(i);
    for (int candidates = 2; candidates <= StepSet::maximum_count; ++candidates) {
      SCOPED_TRACE(fmt::format("kind {}, {} candidates", i, candidates));
      EXPECT_EQ(thesis_energy.costs[i].operations(candidates), operations_of_update<2>(kind, candidates));
      EXPECT_EQ(thesis_costs_in_volumes[i].operations(candidates), operations_of_update<3>(kind, candidates));
    }
  }
}

/// Another modulus at every site, and prescribed all around.
Level held_level(Extent extent) {
  Level level = test::plain_level(extent);
  test::Uniform uniform(1);
  std::ranges::generate(level.modulus.values, [&] { return static_cast<float>(1.0 + uniform()); });
  set_inverse_modulus(level);
  for_each_site(extent, [&](int x, int y, int z) {
    const bool is_inside = x > 0 && y > 0 && x < extent.width - 1 && y < extent.height - 1 &&
                           (extent.depth == 1 || (z > 0 && z < extent.depth - 1));
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      level.confidence[axis][extent.index(x, y, z)] = is_inside ? 0.0F : 1.0F;
    }
  });
  return level;
}

/// Operations of a step, from how they grow with the image: those at its border are no part of it.
double operations_a_site(const MethodStep& step, std::size_t axes) {
  const int smaller = axes == 2 ? 25 : step.level == 0 ? 5 : 9;
  const int larger = smaller + (axes == 2 ? 8 : step.level == 0 ? 2 : 4);
  double sum = 0.0;
  double sites = 0.0;
  for (std::size_t corner = 0; corner < std::size_t{1} << axes; ++corner) {
    const auto side = [&](std::size_t axis) { return (corner >> axis & 1) != 0 ? larger : smaller; };
    const Extent extent{side(0), side(1), axes == 3 ? side(2) : 1};
    ElasticHierarchy hierarchy = make_elastic_hierarchy({held_level(extent), 0.3});
    const auto sites_of = [&](int level) {
      return hierarchy.levels.at(static_cast<std::size_t>(level)).grid.sites;
    };
    const Extent here = sites_of(step.level);
    const Extent coarser = sites_of(step.level + 1);
    ElasticSerial<distinct::real> session;
    session.load(std::move(hierarchy));
    for (std::size_t i = 0; i < elastic_fields; ++i) {
      const auto field = static_cast<ElasticField>(i);
      if (has_field(step.level, field)) {
        session.write(step.level, field, test::random_field(here, 3 + i));
      }
    }
    session.write(step.level + 1, ElasticField::correction, test::random_field(coarser, 17));
    distinct::numbers.clear();
    distinct::operations = 0;
    session.take(step);
    const bool is_added = std::popcount(corner) % 2 == static_cast<int>(axes) % 2;
    sum += (is_added ? 1.0 : -1.0) * static_cast<double>(distinct::operations);
    sites += (is_added ? 1.0 : -1.0) * static_cast<double>(here.sites());
  }
  return sum / sites;
}

TEST(ElasticEnergy, OperationsOfStepsAreThoseOfTheTexts) {
  using Kind = MethodStep::Kind;
  using enum ElasticField;
  for (const std::size_t axes : {std::size_t{2}, std::size_t{3}}) {
    for (const MethodStep& step :
         {MethodStep{.kind = Kind::relax, .level = 0, .to = displacement},
          {.kind = Kind::relax, .level = 0, .to = correction},
          {.kind = Kind::relax, .level = 1, .to = correction},
          {.kind = Kind::relax_from_zero, .level = 1, .to = correction},
          {.kind = Kind::forces, .level = 0, .to = load, .from = displacement},
          {.kind = Kind::restrict_residual, .level = 0, .to = load, .from = displacement},
          {.kind = Kind::restrict_residual, .level = 1, .to = load, .from = correction},
          {.kind = Kind::restrict_load, .level = 0, .to = load},
          {.kind = Kind::interpolate, .level = 0, .to = correction},
          {.kind = Kind::correct, .level = 0, .to = displacement},
          {.kind = Kind::advance,
          .level = 0,
          .to = load,
          .from = load,
          .direction = direction,
          .factor = 0.3F}}) {
      EXPECT_DOUBLE_EQ(step_cost(step, axes).operations, operations_a_site(step, axes))
          << step.name() << " of level " << step.level << ", " << axes << " axes";
    }
  }
}

TEST(ElasticEnergy, OperationsOfASumAreThoseOfTheTexts) {
  for (const Extent extent : {Extent{8, 8}, {4, 4, 4}}) {
    const std::size_t axes = extent.axes();
    ElasticSerial<distinct::real> session;
    session.load(make_elastic_hierarchy({held_level(extent), 0.3}));
    session.write(0, ElasticField::load, test::random_field(extent, 3));
    session.write(0, ElasticField::direction, test::random_field(extent, 4));
    distinct::numbers.clear();
    distinct::operations = 0;
    (void)session.dot(ElasticField::load, ElasticField::direction);
    const auto sites = static_cast<double>(extent.sites());
    EXPECT_EQ(dot_cost(axes).operations * sites - 1.0, static_cast<double>(distinct::operations)) << axes;
  }
}

} // namespace
} // namespace hdmbench
