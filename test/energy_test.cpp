// The specification against the thesis: the texts of kernels/specification in float and in double beside
// (4.5)-(4.17) as printed.

#include "harness/scene/sites.hpp"
#include "kernels/data/gather.hpp"
#include "reference/thesis_energy.hpp"
#include "test/counted_operations.hpp"
#include "test/random_level.hpp"
#include "test/suite.hpp"

namespace hdmbench {
namespace {

/// The texts once more with double as their scalar: what remains against the thesis is algebra, not rounding.
using in_double = Hdm<double>;

double total(ThesisEnergy::Value value) {
  return value.x + value.y + value.z;
}

in_double::Neighbours widen(const HdmInFloat::Neighbours& n) {
  return {n.north_west, n.north, n.north_east, n.west, n.centre, n.east, n.south_west, n.south, n.south_east};
}

/// The same site in double, with 1 / m exact to double instead of rounded to float.
in_double::Site widen(const HdmInFloat::Site& site, const Level& level, int x, int y) {
  in_double::Site wide{};
  wide.dx = widen(site.dx);
  wide.dy = widen(site.dy);
  wide.modulus = site.modulus;
  wide.target_x = site.target_x;
  wide.target_y = site.target_y;
  wide.confidence_x = site.confidence_x;
  wide.confidence_y = site.confidence_y;
  wide.penalty = site.penalty;
  const auto inverse = [&](int dx, int dy) {
    const bool inside =
        x + dx >= 0 && x + dx < level.extent.width && y + dy >= 0 && y + dy < level.extent.height;
    const auto at = inside ? level.extent.index(x + dx, y + dy) : level.extent.index(x, y);
    return 1.0 / static_cast<double>(level.modulus.values[at]);
  };
  wide.inverse_modulus = {inverse(-1, -1), inverse(0, -1), inverse(1, -1), inverse(-1, 0), inverse(0, 0),
                          inverse(1, 0),   inverse(-1, 1), inverse(0, 1),  inverse(1, 1)};
  return wide;
}

TEST(Energy, DifferenceFormEqualsThesisForEveryCandidate) {
  const auto [level, start] = test::random_problem({23, 17}, test::Texture::smooth, 11);
  const ThesisEnergy thesis(level, start);
  for (int y = 0; y < level.extent.height; ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      const in_double::Site site = widen(gather<HdmInFloat>(level, start, x, y), level, x, y);
      const double before = total(thesis.at(x, y));
      // Rounding of a few dozen double operations on the site's energy.
      const double tolerance = 1e-12 * (1.0 + std::abs(before));
      EXPECT_NEAR(in_double::site_energy(site), before, tolerance) << "x = " << x << ", y = " << y;
      for (const double step : {-1.0, 0.3, 2.0}) {
        const in_double::Prior prior = in_double::prior_of(site);
        const double change =
            in_double::energy_change(step, prior.gradient_x, prior.curvature_x,
                                     site.target_x - site.dx.centre, site.penalty * site.confidence_x);
        const double after = total(thesis.at(x, y, {site.dx.centre + step, site.dy.centre}));
        EXPECT_NEAR(change, after - before, 10.0 * tolerance + 1e-12 * std::abs(after))
            << "x = " << x << ", y = " << y << ", step " << step;
      }
    }
  }
}

TEST(Energy, FirstCandidateWinsATie) {
  // A homogeneous field at rest is symmetric: +1 and -1 cost the same.
  const HdmInFloat::Site site = gather<HdmInFloat>(test::plain_level({3, 3}), VectorField({3, 3}), 1, 1);
  for (const auto& [text, expected] :
       {std::pair{"1,-1", 1.0F}, std::pair{"-1,1", -1.0F}, std::pair{"2,-1,1", -1.0F}}) {
    const StepSet steps = StepSet::parse(text);
    const HdmInFloat::Displacement next = HdmInFloat::moved_displacement(
        HdmInFloat::rule_steps, true, site, {}, {}, steps.padded().data(), steps.count());
    EXPECT_EQ(next.x, expected) << text;
    EXPECT_EQ(next.y, expected) << text;
  }
}

TEST(Energy, MeanEnergyIsTheMeanOfTheThesisEnergy) {
  for (const Extent extent : {Extent{31, 12}, {7, 6, 5}}) {
    const auto [level, start] = test::random_problem(extent, test::Texture::smooth, 3);
    const ThesisEnergy thesis(level, start);
    double sum = 0.0;
    for (int row = 0; row < extent.rows(); ++row) {
      for (int x = 0; x < extent.width; ++x) {
        sum += total(thesis.at(x, row % extent.height, row / extent.height));
      }
    }
    const double expected = sum / static_cast<double>(extent.sites());
    // Around 40 float operations a site, errors of either sign.
    EXPECT_NEAR(mean_energy(level, start), expected, 40 * std::numeric_limits<float>::epsilon() * expected);
  }
}

/// In a volume U_t is a parabola in each component: two energies beside the centre's have its gradient and
/// curvature.
TEST(Energy, GradientAndCurvatureOfAVolumeAreThoseOfTheThesis) {
  auto [level, start] = test::random_problem({6, 5, 4}, test::Texture::smooth, 13);
  level.confidence = VectorField(level.extent);
  const ThesisEnergy thesis(level, start);
  for (int row = 0; row < level.extent.rows(); ++row) {
    for (int x = 0; x < level.extent.width; ++x) {
      const int y = row % level.extent.height;
      const int z = row / level.extent.height;
      const PriorAtSite prior = level.energy->host->prior(level, start, x, y, z);
      const std::size_t site = level.extent.index(x, y, z);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto energy = [&](double step) {
          std::array<double, 3> centre{start[0][site], start[1][site], start[2][site]};
          centre[axis] += step;
          return total(thesis.at(x, y, {centre[0], centre[1], centre[2]}, z));
        };
        const double gradient = (energy(1.0) - energy(-1.0)) / 4.0;
        const double curvature = (energy(1.0) + energy(-1.0) - 2.0 * energy(0.0)) / 2.0;
        EXPECT_NEAR(prior.gradient[axis], gradient, 1e-5 * (curvature * 20.0));
        EXPECT_NEAR(prior.curvature[axis], curvature, 1e-5 * curvature);
      }
    }
  }
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
