// The third tier: what rounding may do passes, in a backend that really is compiled so, and nothing else
// does.

#include "harness/check/certificate.hpp"

#include "harness/check/bounded_real.hpp"
#include "harness/check/verify.hpp"
#include "harness/scene/sites.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

namespace hdmbench {
namespace {

using Bounded = Hdm<bounded::real>;

using test::Texture;

/// The x component's energy changes, one per candidate.
std::vector<bounded::real> changes_at(const Level& level, const VectorField& field, int x, int y) {
  const Bounded::Site site = bounded::gather<Bounded>(level, field, x, y, bounded::InverseModulus::given);
  const Bounded::Prior prior = Bounded::prior_of(site);
  std::vector<bounded::real> changes;
  for (const float step : level.steps.values()) {
    changes.push_back(Bounded::energy_change(step, prior.gradient_x, prior.curvature_x,
                                             site.target_x - site.dx.centre,
                                             site.penalty * site.confidence_x));
  }
  return changes;
}

TEST(Bound, HoldsForAnyOrderOfTheSum) {
  std::mt19937 random(7);
  const auto [level, field] = test::random_problem({60, 60}, Texture::smooth, 3);
  for_each_site(level.extent, [&, &level = level, &field = field](int x, int y) {
    const HdmInFloat::Site site = gather<HdmInFloat>(level, field, x, y);
    const HdmInFloat::Neighbours toward = HdmInFloat::stiffness_ratios(site);
    const HdmInFloat::Neighbours& d = site.dx;
    const auto term = [](float ratio, float ds, float dt, float du) {
      return (1.0F + ratio) * HdmInFloat::residual(ratio, ds, dt, du);
    };
    std::array terms{term(toward.south_east, d.north_west, d.centre, d.south_east),
                     term(toward.north_west, d.south_east, d.centre, d.north_west),
                     term(toward.north_east, d.south_west, d.centre, d.north_east),
                     term(toward.south_west, d.north_east, d.centre, d.south_west),
                     term(toward.east, d.west, d.centre, d.east),
                     term(toward.west, d.east, d.centre, d.west)};
    const bounded::real gradient =
        Bounded::prior_of(bounded::gather<Bounded>(level, field, x, y, bounded::InverseModulus::given))
            .gradient_x;
    for (int order = 0; order < 20; ++order) {
      std::ranges::shuffle(terms, random);
      const float sum = ((terms[0] + terms[1]) + (terms[2] + terms[3])) + (terms[4] + terms[5]);
      EXPECT_LE(std::abs(static_cast<double>(sum) - gradient.exact()), gradient.error());
    }
  });
}

TEST(Bound, IsZeroWhereAllIsExact) {
  const auto [level, field] =
      test::random_problem({60, 60}, Texture::dyadic, 4, StepSet::parse("0,-1,-0.25,1,0.25"));
  for_each_site(level.extent, [&, &level = level, &field = field](int x, int y) {
    for (const bounded::real& change : changes_at(level, field, x, y)) {
      EXPECT_EQ(change.error(), 0.0) << "x = " << x << ", y = " << y;
    }
  });
}

/// What a device would choose that is wrong about each candidate's energy by `factor` times the bound, to the
/// advantage of one of them.
std::size_t misled_choice(const std::vector<bounded::real>& changes, std::size_t favoured, double factor) {
  std::size_t best = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const double error = factor * changes[i].error();
    const double wrong = changes[i].exact() + (i == favoured ? -error : error);
    if (wrong < lowest) {
      lowest = wrong;
      best = i;
    }
  }
  return best;
}

struct Judged {
  int certified = 0;
  int refused = 0;
};

/// Levels on which the two candidates nearly tie at the site in the middle: the displacement beside it
/// lies within some units in the last place of where they do.
template <typename Call>
void for_each_near_tie(const Call& call) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    auto [level, start] = test::random_problem({5, 5}, Texture::smooth, seed, StepSet::parse("0,0.1"));
    level.confidence = VectorField(level.extent);
    float& east = start.x[level.extent.index(3, 2)];
    const auto second_is_dearer = [&, &level = level, &start = start] {
      const std::vector<bounded::real> changes = changes_at(level, start, 2, 2);
      return changes[1].exact() > changes[0].exact();
    };
    float low = -1000.0F;
    float high = 1000.0F;
    east = low;
    const bool dearer_at_low = second_is_dearer();
    while (std::nextafter(low, high) != high) {
      east = std::midpoint(low, high);
      (second_is_dearer() == dearer_at_low ? low : high) = east;
    }
    for (int i = 0; i < 100; ++i) {
      low = std::nextafter(low, -1000.0F);
    }
    east = low;
    for (int i = 0; i < 200; ++i) {
      call(level, start);
      east = std::nextafter(east, 1000.0F);
    }
  }
}

/// Errors of `factor` bounds where two candidates nearly tie, to the advantage of either.
Judged judge_misled(double factor) {
  Judged judged;
  for_each_near_tie([&](const Level& level, const VectorField& start) {
    const std::vector<bounded::real> changes = changes_at(level, start, 2, 2);
    const SiteAnswer expected = specified_answer(level, start, 0, 2, 2);
    for (const std::size_t favoured : {0, 1}) {
      const std::size_t chosen = misled_choice(changes, favoured, factor);
      const float moved = start.x[level.extent.index(2, 2)] + level.steps.values()[chosen];
      if (moved != expected.x) {
        const bool holds = certify(level, start, 0, 2, 2, {moved, expected.y}).holds;
        ++(holds ? judged.certified : judged.refused);
      }
    }
  });
  return judged;
}

TEST(Certificate, HoldsForErrorsWithinTheBound) {
  const Judged judged = judge_misled(0.999);
  EXPECT_GT(judged.certified, 100) << "nothing was judged";
  EXPECT_EQ(judged.refused, 0);
}

TEST(Certificate, IsRefusedForErrorsOfFourTimesTheBound) {
  // What tips at four bounds and would have tipped at one is fine; whatever only four bounds could tip is
  // not.
  const Judged at_one = judge_misled(1.0);
  const Judged at_four = judge_misled(4.0);
  EXPECT_GT(at_four.refused, 100);
  EXPECT_EQ(at_four.certified, at_one.certified);
}

TEST(Certificate, DoesNotHoldForWhatTheRuleCannotGive) {
  const auto problem = test::random_problem({9, 9}, Texture::smooth, 5);
  const SiteAnswer expected = specified_answer(problem.level, problem.start, 0, 4, 4);
  const auto holds = [&](float x, float y) {
    return certify(problem.level, problem.start, 0, 4, 4, {x, y}).holds;
  };
  EXPECT_TRUE(holds(expected.x, expected.y));
  EXPECT_FALSE(holds(std::nextafter(expected.x, 100.0F), expected.y));
  EXPECT_FALSE(holds(expected.x, std::nextafter(expected.y, 100.0F)));
  EXPECT_FALSE(holds(NAN, expected.y));
  EXPECT_FALSE(holds(expected.x, INFINITY));
}

/// update.inc's closed form in double, rounded once: a device that is better than it need be.
float closed_form_in_double(const Level& level, const VectorField& start, int x, int y) {
  const Bounded::Site site = bounded::gather<Bounded>(level, start, x, y, bounded::InverseModulus::given);
  const Bounded::Prior prior = Bounded::prior_of(site);
  const double scale = static_cast<double>(level.strengths.front()) * site.inverse_curvature_x.exact();
  const double unobserved = -scale * prior.gradient_x.exact();
  const double reach = scale * site.penalty.exact() * site.confidence_x.exact() / 2.0;
  const double remaining = site.target_x.exact() - site.dx.centre.exact() - unobserved;
  const double moved = site.dx.centre.exact() + unobserved + std::clamp(remaining, -reach, reach);
  return static_cast<float>(moved);
}

TEST(Certificate, HoldsForAClosedFormThatIsUndecidedBetweenItsBranches) {
  int differing = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    auto [level, start] = test::random_problem({5, 5}, Texture::smooth, seed, {}, Rule::closed_form);
    level.strengths = {1.0F};
    const std::size_t middle = level.extent.index(2, 2);
    level.confidence.x[middle] = 0.37F;
    const auto answer = [&, &level = level, &start = start](float target) {
      level.target.x[middle] = target;
      return specified_answer(level, start, 0, 2, 2).x;
    };
    float target = answer(1e6F); // as far as the observation can pull: the branches meet here
    for (int i = 0; i < 50; ++i) {
      target = std::nextafter(target, -1e6F);
    }
    for (int i = 0; i < 100; ++i, target = std::nextafter(target, 1e6F)) {
      const float expected = answer(target);
      const float found = closed_form_in_double(level, start, 2, 2);
      const SiteAnswer other{found, specified_answer(level, start, 0, 2, 2).y};
      EXPECT_TRUE(certify(level, start, 0, 2, 2, other).holds) << "seed " << seed << ", target " << target;
      const SiteAnswer wrong{found + 1e-4F, other.y};
      EXPECT_FALSE(certify(level, start, 0, 2, 2, wrong).holds) << "seed " << seed << ", target " << target;
      differing += found != expected ? 1 : 0;
    }
  }
  EXPECT_GT(differing, 1000) << "nothing was judged";
}

TEST(Certificate, DoesNotHoldWhereItIsNotTheComponentsTurn) {
  auto problem = test::random_problem({8, 8}, Texture::smooth, 6, {}, Rule::closed_form, Update::coloured);
  for_each_site(problem.level.extent, [&](int x, int y) {
    const SiteAnswer expected = specified_answer(problem.level, problem.start, 0, x, y);
    const std::size_t site = problem.level.extent.index(x, y);
    const bool held = expected.x == problem.start.x[site];
    const SiteAnswer moved{std::nextafter(expected.x, 100.0F), expected.y};
    const bool holds = certify(problem.level, problem.start, 0, x, y, moved).holds;
    EXPECT_EQ(holds, !held) << "x = " << x << ", y = " << y; // one unit in the last place is rounding
  });
}

TEST(Certificate, DoesNotHoldForTheOtherCandidateOfAnExactTie) {
  int ties = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const auto problem =
        test::random_problem({40, 40}, Texture::dyadic, seed, StepSet::parse("0,-1,-0.25,1,0.25"));
    const Level& level = problem.level;
    for_each_site(level.extent, [&](int x, int y) {
      const std::vector<bounded::real> changes = changes_at(level, problem.start, x, y);
      const auto best = std::ranges::min_element(changes); // the first of equals
      const SiteAnswer expected = specified_answer(level, problem.start, 0, x, y);
      for (auto other = best + 1; other != changes.end(); ++other) {
        if (other->exact() == best->exact()) {
          ++ties;
          const float step = level.steps.values()[static_cast<std::size_t>(other - changes.begin())];
          const float moved = problem.start.x[level.extent.index(x, y)] + step;
          EXPECT_FALSE(certify(level, problem.start, 0, x, y, {moved, expected.y}).holds);
        }
      }
    });
  }
  EXPECT_GT(ties, 20);
}

Scene make_scene(Texture texture) {
  return test::textured_scene("certified", {72, 60}, texture, 11, 20);
}

TEST(Verify, MistrustsASceneThatIsDeclaredExactAndIsNot) {
  Scene scene = make_scene(Texture::tie_rich);
  scene.exact = true;
  for (const Comparison& comparison : test::verified(scene, test::scalar())) {
    EXPECT_EQ(comparison.verdict, Verdict::mistrusted);
    EXPECT_NE(comparison.reason.find("declared exact, but level 0, x = 0, y = 0, sweep 0"), std::string::npos)
        << comparison.reason;
  }
  scene = make_scene(Texture::dyadic);
  scene.exact = true;
  for (const Comparison& comparison : test::verified(scene, test::scalar())) {
    EXPECT_EQ(comparison.tier, test::is_idle(comparison) ? Tier::none : Tier::exact) << comparison.reason;
  }
}

TEST(Verify, MistrustsASceneThatPrescribesAlmostEverything) {
  Scene scene = make_scene(Texture::smooth);
  std::ranges::fill(scene.full.confidence.x, 1.0F);
  std::ranges::fill(scene.full.confidence.y, 1.0F);
  scene.full.confidence.x.front() = 0.0F;
  for (const Comparison& comparison : test::verified(scene, test::scalar())) {
    EXPECT_EQ(comparison.verdict, Verdict::mistrusted);
    EXPECT_EQ(comparison.tier, Tier::none);
    EXPECT_NE(comparison.reason.find("0.012 % of the components are free"), std::string::npos)
        << comparison.reason;
  }
}

} // namespace
} // namespace hdmbench
