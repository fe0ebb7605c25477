// The third tier: what rounding may do passes, in a backend that really is compiled so, and nothing else
// does.

#include "harness/check/certificate.hpp"

#include "harness/check/bounded_real.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/gather.hpp"
#include "reference/thesis_energy.hpp"
#include "test/scenes.hpp"

namespace hdmbench {
namespace {

using test::Texture;

/// Of an image or a volume in which one site sees all sorts of neighbours.
template <int axes>
constexpr Extent small{5, 5, axes == 3 ? 5 : 1};
/// Its slice in the middle.
template <int axes>
constexpr int middle = axes == 3 ? 2 : 0;

/// The x component's energy changes, one per candidate.
template <int axes>
std::vector<bounded::real> changes_at(const Level& level, const VectorField& field, int x, int y) {
  using Bounded = Hdm<bounded::real, axes>;
  const typename Bounded::Site site = gather<Bounded>(level, field, x, y, middle<axes>);
  const typename Bounded::Prior prior = Bounded::prior_of(site);
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
template <int axes>
Judged judge_misled(double factor) {
  constexpr int z = middle<axes>;
  Judged judged;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    auto [level, start] = test::random_problem(small<axes>, Texture::smooth, seed, StepSet::parse("0,0.1"));
    level.confidence = VectorField(level.extent);
    float& east = start[0][level.extent.index(3, 2, z)];
    const auto second_is_dearer = [&, &level = level, &start = start] {
      const std::vector<bounded::real> changes = changes_at<axes>(level, start, 2, 2);
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
      const std::vector<bounded::real> changes = changes_at<axes>(level, start, 2, 2);
      const SiteAnswer expected = proofs_of(level).specified_answer(level, start, 0, 2, 2, z);
      for (const std::size_t favoured : {0, 1}) {
        const std::size_t chosen = misled_choice(changes, favoured, factor);
        const float moved = start[0][level.extent.index(2, 2, z)] + level.steps.values()[chosen];
        if (moved != expected[0]) {
          const SiteAnswer found{moved, expected[1], expected[2]};
          const bool holds = proofs_of(level).certify(level, start, 0, 2, 2, z, found).holds;
          ++(holds ? judged.certified : judged.refused);
        }
      }
    }
  }
  return judged;
}

TEST(Certificate, HoldsForErrorsWithinTheBound) {
  for (const Judged& judged : {judge_misled<2>(0.999), judge_misled<3>(0.999)}) {
    EXPECT_GT(judged.certified, 100) << "nothing was judged";
    EXPECT_EQ(judged.refused, 0);
  }
}

TEST(Certificate, IsRefusedForErrorsOfFourTimesTheBound) {
  // What tips at four bounds and would have tipped at one is fine; whatever only four bounds could tip is
  // not.
  for (const auto& judge : {judge_misled<2>, judge_misled<3>}) {
    const Judged at_four = judge(4.0);
    EXPECT_GT(at_four.refused, 100);
    EXPECT_EQ(at_four.certified, judge(1.0).certified);
  }
}

/// update.inc's closed form in double, rounded once: a device that is better than it need be.
template <int axes>
float closed_form_in_double(const Level& level, const VectorField& start, int x, int y) {
  using Bounded = Hdm<bounded::real, axes>;
  const typename Bounded::Site site = gather<Bounded>(level, start, x, y, middle<axes>);
  const typename Bounded::Prior prior = Bounded::prior_of(site);
  const double scale = static_cast<double>(level.strengths.front()) * site.inverse_curvature_x.exact();
  const double unobserved = -scale * prior.gradient_x.exact();
  const double reach = scale * site.penalty.exact() * site.confidence_x.exact() / 2.0;
  const double remaining = site.target_x.exact() - site.dx.centre.exact() - unobserved;
  const double moved = site.dx.centre.exact() + unobserved + std::clamp(remaining, -reach, reach);
  return static_cast<float>(moved);
}

/// How many of the answers differed that such a device gives beside where the branches meet.
template <int axes>
int certify_undecided(std::uint64_t seed) {
  constexpr int z = middle<axes>;
  auto [level, start] = test::random_problem(small<axes>, Texture::smooth, seed, {}, Rule::closed_form);
  level.strengths = {1.0F};
  const std::size_t at = level.extent.index(2, 2, z);
  level.confidence[0][at] = 0.37F;
  const auto answer = [&, &level = level, &start = start](float target) {
    level.target[0][at] = target;
    return proofs_of(level).specified_answer(level, start, 0, 2, 2, z);
  };
  float target = answer(1e6F)[0]; // as far as the observation can pull: the branches meet here
  for (int i = 0; i < 50; ++i) {
    target = std::nextafter(target, -1e6F);
  }
  int differing = 0;
  for (int i = 0; i < 100; ++i, target = std::nextafter(target, 1e6F)) {
    const SiteAnswer expected = answer(target);
    const float found = closed_form_in_double<axes>(level, start, 2, 2);
    SiteAnswer other = expected;
    for (const auto& [error, holds] : {std::pair{0.0F, true}, {1e-4F, false}}) {
      other[0] = found + error;
      EXPECT_EQ(proofs_of(level).certify(level, start, 0, 2, 2, z, other).holds, holds)
          << axes << " axes, seed " << seed << ", target " << target;
    }
    differing += found != expected[0] ? 1 : 0;
  }
  return differing;
}

TEST(Certificate, HoldsForAClosedFormThatIsUndecidedBetweenItsBranches) {
  for (const auto& certify : {certify_undecided<2>, certify_undecided<3>}) {
    int differing = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
      differing += certify(seed);
    }
    EXPECT_GT(differing, 1000) << "nothing was judged";
  }
}

TEST(Verify, MistrustsASceneThatIsDeclaredExactAndIsNot) {
  for (const Extent extent : {Extent{72, 60}, Extent{18, 15, 11}}) {
    for (const Texture texture : {Texture::tie_rich, Texture::dyadic}) {
      Scene scene = test::textured_scene("certified", extent, texture, 11, 20);
      scene.exact = true;
      for (const Comparison& comparison : test::verified(scene, test::scalar())) {
        if (texture == Texture::tie_rich) {
          EXPECT_EQ(comparison.verdict, Verdict::mistrusted);
          EXPECT_THAT(comparison.reason, HasSubstr("declared exact, but level 0, x = 0, y = 0"));
        } else {
          EXPECT_EQ(comparison.tier, test::is_idle(comparison) ? Tier::none : Tier::exact)
              << comparison.reason;
        }
      }
    }
  }
}

/// Candidates hide the rounding of fused operations unless they nearly tie.
TEST(Verify, CertifiesFusedVolumes) {
  const Extent extent{15, 14, 13};
  for (const std::string_view method : {"icm", "coloured", "closed-form", "conjugate-gradients"}) {
    const bool has_candidates = method == "icm" || method == "coloured";
    Scene scene = has_candidates ? test::textured_scene("certified", extent, Texture::tie_rich, 1, 6)
                                 : load_scene("ball", {.size = extent});
    use_method(scene, find_method(method), 6);
    const auto fused = faults::make_fused();
    bool is_certified = false;
    for (const Comparison& comparison : test::verified(scene, *fused)) {
      EXPECT_THAT(comparison.verdict, testing::AnyOf(Verdict::agree, Verdict::certified, Verdict::skipped))
          << method << ", " << name_of(comparison.mode) << ": " << comparison.reason;
      is_certified = is_certified || comparison.verdict == Verdict::certified;
    }
    EXPECT_TRUE(is_certified) << method;
  }
}

// ---- The bound

/// Of the energy change of component `axis` in float32, against exact arithmetic on the same displacements,
/// targets, confidences and moduli; 1 / m enters with the rounding of the host.
template <typename Energy, typename Inverse>
typename Energy::real change_at(const Level& level, const VectorField& field, std::array<int, 3> at,
                                std::size_t axis, float step, const Inverse& inverse) {
  const auto& of = Energy::of_axis[axis];
  const typename Energy::Site site = gather<Energy>(level, field, at[0], at[1], at[2], inverse);
  const typename Energy::Prior prior = Energy::prior_of(site);
  return Energy::energy_change(step, prior.*of.gradient, prior.*of.curvature,
                               site.*of.target - (site.*of.displacement).centre,
                               site.penalty * site.*of.confidence);
}

/// The largest error of all sites as a share of its bound.
template <int axes>
double largest_share(Extent extent, Texture texture, std::uint64_t seed) {
  const auto [level, field] = test::random_problem(extent, texture, seed);
  const ThesisEnergy energy(level, field);
  const auto rounded = [](float inverse) {
    return bounded::real(inverse, bounded::unit_roundoff * static_cast<double>(inverse) * bounded::inflation);
  };
  double largest = 0.0;
  for_each_site(extent, [&, &level = level, &field = field](int x, int y, int z) {
    using Value = ThesisEnergy::Value;
    constexpr double Value::*of_axis[] = {&Value::x, &Value::y, &Value::z};
    for (std::size_t axis = 0; axis < axes; axis += 2) { // x and z: y is x transposed
      for (const float step : {-1.0F, 0.1F}) {
        const std::array<float, 3> here = site_of(field, extent.index(x, y, z));
        Value moved{here[0], here[1], here[2]};
        moved.*of_axis[axis] += double{step};
        const double exact = energy.at(x, y, moved, z).*of_axis[axis] - energy.at(x, y, z).*of_axis[axis];
        const float computed =
            change_at<Hdm<float, axes>>(level, field, {x, y, z}, axis, step, [](float same) { return same; });
        const double bound =
            change_at<Hdm<bounded::real, axes>>(level, field, {x, y, z}, axis, step, rounded).error();
        largest = std::max(largest, std::abs(static_cast<double>(computed) - exact) / bound);
      }
    }
  });
  return largest;
}

TEST(RoundingBound, IsNeverExceededAndIsReached) {
  for (const Texture texture : {Texture::smooth, Texture::tie_rich}) {
    double in_image = 0.0;
    double in_volume = 0.0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      in_image = std::max(in_image, largest_share<2>({60, 50}, texture, seed));
      in_volume = std::max(in_volume, largest_share<3>({15, 14, 13}, texture, seed));
      ASSERT_LE(std::max(in_image, in_volume), 1.0) << "seed " << seed;
    }
    EXPECT_GE(std::min(in_image, in_volume), 0.1) << "a bound that nothing comes near lets mistakes pass";
  }
}

} // namespace
} // namespace hdmbench
