// The third tier: what rounding may do passes, in a backend that really is compiled so, and nothing else
// does.

#include "harness/check/certificate.hpp"

#include "harness/check/bounded_real.hpp"
#include "kernels/data/gather.hpp"
#include "reference/thesis_energy.hpp"
#include "test/scenes.hpp"

namespace hdmbench {
namespace {

using Bounded = Hdm<bounded::real>;

using test::Texture;

/// The x component's energy changes, one per candidate.
std::vector<bounded::real> changes_at(const Level& level, const VectorField& field, int x, int y) {
  const Bounded::Site site = gather<Bounded>(level, field, x, y);
  const Bounded::Prior prior = Bounded::prior_of(site);
  std::vector<bounded::real> changes;
  for (const float step : level.steps.values()) {
    changes.push_back(Bounded::energy_change(step, prior.gradient_x, prior.curvature_x,
                                             site.target_x - site.dx.centre,
                                             site.penalty * site.confidence_x));
  }
  return changes;
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

/// Errors of `factor` bounds, to the advantage of either of two candidates that nearly tie at the site in the
/// middle: the displacement beside it lies within some units in the last place of where they do.
Judged judge_misled(double factor) {
  Judged judged;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    auto [level, start] = test::random_problem({5, 5}, Texture::smooth, seed, StepSet::parse("0,0.1"));
    level.confidence = VectorField(level.extent);
    float& east = start[0][level.extent.index(3, 2)];
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
    for (int i = 0; i < 200; ++i, east = std::nextafter(east, 1000.0F)) {
      const std::vector<bounded::real> changes = changes_at(level, start, 2, 2);
      const SiteAnswer expected = proofs_of(level).specified_answer(level, start, 0, 2, 2);
      for (const std::size_t favoured : {0, 1}) {
        const std::size_t chosen = misled_choice(changes, favoured, factor);
        const float moved = start[0][level.extent.index(2, 2)] + level.steps.values()[chosen];
        if (moved != expected.x) {
          const bool holds = proofs_of(level).certify(level, start, 0, 2, 2, {moved, expected.y}).holds;
          ++(holds ? judged.certified : judged.refused);
        }
      }
    }
  }
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

/// update.inc's closed form in double, rounded once: a device that is better than it need be.
float closed_form_in_double(const Level& level, const VectorField& start, int x, int y) {
  const Bounded::Site site = gather<Bounded>(level, start, x, y);
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
    level.confidence[0][middle] = 0.37F;
    const auto answer = [&, &level = level, &start = start](float target) {
      level.target[0][middle] = target;
      return proofs_of(level).specified_answer(level, start, 0, 2, 2).x;
    };
    float target = answer(1e6F); // as far as the observation can pull: the branches meet here
    for (int i = 0; i < 50; ++i) {
      target = std::nextafter(target, -1e6F);
    }
    for (int i = 0; i < 100; ++i, target = std::nextafter(target, 1e6F)) {
      const float expected = answer(target);
      const float found = closed_form_in_double(level, start, 2, 2);
      const SiteAnswer other{found, proofs_of(level).specified_answer(level, start, 0, 2, 2).y};
      EXPECT_TRUE(proofs_of(level).certify(level, start, 0, 2, 2, other).holds)
          << "seed " << seed << ", target " << target;
      const SiteAnswer wrong{found + 1e-4F, other.y};
      EXPECT_FALSE(proofs_of(level).certify(level, start, 0, 2, 2, wrong).holds)
          << "seed " << seed << ", target " << target;
      differing += found != expected ? 1 : 0;
    }
  }
  EXPECT_GT(differing, 1000) << "nothing was judged";
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

// ---- The bound

/// Of the x component's energy change in float32, against exact arithmetic on the same displacements,
/// targets, confidences and moduli; 1 / m enters with the rounding of the host.
double change_bound(const Level& level, const VectorField& field, int x, int y, float step) {
  const Bounded::Site site = gather<Bounded>(level, field, x, y, 0, [](float inverse_modulus) {
    return bounded::real(inverse_modulus,
                         bounded::unit_roundoff * static_cast<double>(inverse_modulus) * bounded::inflation);
  });
  const Bounded::Prior prior = Bounded::prior_of(site);
  return Bounded::energy_change(step, prior.gradient_x, prior.curvature_x, site.target_x - site.dx.centre,
                                site.penalty * site.confidence_x)
      .error();
}

TEST(RoundingBound, IsNeverExceededAndIsReached) {
  for (const Texture texture : {Texture::smooth, Texture::tie_rich}) {
    double largest_share = 0.0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto [level, field] = test::random_problem({60, 50}, texture, seed);
      const ThesisEnergy energy(level, field);
      for_each_site(level.extent, [&, &level = level, &field = field](int x, int y) {
        for (const float step : {-1.0F, 0.1F}) {
          const HdmInFloat::Site site = gather<HdmInFloat>(level, field, x, y);
          const HdmInFloat::Prior prior = HdmInFloat::prior_of(site);
          const float computed =
              HdmInFloat::energy_change(step, prior.gradient_x, prior.curvature_x,
                                        site.target_x - site.dx.centre, site.penalty * site.confidence_x);
          const double moved = double{site.dx.centre} + double{step};
          const double exact = energy.at(x, y, {moved, site.dy.centre}).x - energy.at(x, y).x;
          const double error = std::abs(static_cast<double>(computed) - exact);
          const double bound = change_bound(level, field, x, y, step);
          ASSERT_LE(error, bound) << "seed " << seed << ", x = " << x << ", y = " << y << ", step " << step;
          largest_share = std::max(largest_share, error / bound);
        }
      });
    }
    EXPECT_GE(largest_share, 0.1) << "a bound that nothing comes near lets mistakes pass";
  }
}

} // namespace
} // namespace hdmbench
