// What must hold for any level, without a second implementation to compare with: symmetries, units, and that
// ICM goes downhill. On scalar; that all backends do the same is backends_test's affair.

#include "harness/check/compare.hpp"
#include "harness/scene/sites.hpp"
#include "reference/thesis_energy.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace hdmbench {
namespace {

using test::Problem;
using test::swept;
using test::Texture;

/// Odd and even, long and single.
constexpr std::array<Extent, 7> extents{{{1, 1}, {1, 6}, {7, 1}, {2, 3}, {8, 8}, {13, 10}, {24, 17}}};
constexpr int seeds = 4;

/// Candidates on the dyadic grid that tie with each other.
StepSet dyadic_steps() {
  return StepSet::parse("0,-1,-0.25,1,0.25");
}

/// Calls test(problem) for random levels of every size.
void for_random_levels(Texture texture, Rule rule, Update update,
                       const std::function<void(const Problem&)>& test) {
  for (const Extent extent : extents) {
    for (int seed = 0; seed < seeds; ++seed) {
      SCOPED_TRACE(fmt::format("random_problem({{{}, {}}}, Texture({}), {}, ..., Rule({}), Update({}))",
                               extent.width, extent.height, static_cast<int>(texture), seed,
                               static_cast<int>(rule), static_cast<int>(update)));
      const StepSet steps = texture == Texture::dyadic ? dyadic_steps() : StepSet();
      test(test::random_problem(extent, texture, static_cast<std::uint64_t>(seed), steps, rule, update));
      if (testing::Test::HasFailure()) {
        return;
      }
    }
  }
}

void expect_equal(const VectorField& expected, const VectorField& found) {
  const FieldDifference difference = compare(expected, found);
  EXPECT_EQ(difference.not_finite, 0);
  EXPECT_EQ(difference.sites, 0) << "first site index " << difference.first.value_or(0);
}

// ---- Sites in another order

/// Another way to look at an image: where the site (x, y) of the view is, and whether x and y change places.
struct View {
  std::function<Extent(Extent)> extent;
  std::function<std::size_t(Extent from, int x, int y)> index;
  bool exchanges = false;
};

std::vector<float> seen(const View& view, Extent from, const std::vector<float>& values) {
  const Extent extent = view.extent(from);
  std::vector<float> result(extent.sites());
  for_each_site(extent, [&](int x, int y) { result[extent.index(x, y)] = values[view.index(from, x, y)]; });
  return result;
}

VectorField seen(const View& view, const VectorField& field) {
  VectorField result;
  result.extent = view.extent(field.extent);
  result.x = seen(view, field.extent, view.exchanges ? field.y : field.x);
  result.y = seen(view, field.extent, view.exchanges ? field.x : field.y);
  return result;
}

Problem seen(const View& view, const Problem& problem) {
  Problem result = problem;
  Level& level = result.level;
  level.extent = view.extent(problem.level.extent);
  level.target = seen(view, problem.level.target);
  level.confidence = seen(view, problem.level.confidence);
  level.modulus.extent = level.extent;
  level.modulus.values = seen(view, problem.level.extent, problem.level.modulus.values);
  set_inverse_modulus(level);
  set_inverse_curvature(level);
  result.start = seen(view, problem.start);
  return result;
}

const View left_to_right{
    .extent = [](Extent from) { return from; },
    .index = [](Extent from, int x, int y) { return from.index(from.width - 1 - x, y); }};
const View top_to_bottom{
    .extent = [](Extent from) { return from; },
    .index = [](Extent from, int x, int y) { return from.index(x, from.height - 1 - y); }};
const View transposed{.extent =
                          [](Extent from) {
                            return Extent{from.height, from.width};
                          },
                      .index = [](Extent from, int x, int y) { return from.index(y, x); },
                      .exchanges = true};

/// The order of additions differs, so numbers must be exact: any number of steps on dyadic levels, one sweep
/// of the rules that divide.
void expect_symmetric(const View& view, Update update) {
  for (const Rule rule : {Rule::steps, Rule::closed_form}) {
    const int sweeps = rule == Rule::steps ? 6 : 1;
    for_random_levels(Texture::dyadic, rule, update, [&](const Problem& problem) {
      expect_equal(seen(view, swept(problem, sweeps)), swept(seen(view, problem), sweeps));
    });
  }
}

TEST(Symmetry, AMirroredLevelMovesAsTheMirrorImage) {
  expect_symmetric(left_to_right, Update::simultaneous);
  expect_symmetric(top_to_bottom, Update::simultaneous);
}

TEST(Symmetry, ATransposedLevelMovesAsTheTransposedImage) {
  expect_symmetric(transposed, Update::simultaneous);
  expect_symmetric(transposed, Update::coloured); // columns for x, rows for y
}

// ---- Other numbers for the same thing

void scale(std::vector<float>& values, float factor) {
  for (float& value : values) {
    value *= factor;
  }
}

void scale(VectorField& field, float factor) {
  scale(field.x, factor);
  scale(field.y, factor);
}

StepSet scaled(const StepSet& steps, float factor) {
  std::vector<float> values(steps.values().begin(), steps.values().end());
  scale(values, factor);
  return StepSet(values);
}

void for_every_rule_and_update(const std::vector<Texture>& textures,
                               const std::function<void(const Problem&)>& test) {
  for (const Rule rule : test::all_rules) {
    for (const Update update : test::simultaneous_and_coloured) {
      for (const Texture texture : textures) {
        for_random_levels(texture, rule, update, test);
      }
    }
  }
}

constexpr int sweeps_of_all_colours = 8;

TEST(Units, LengthsTimesAPowerOfTwoGiveTheFieldTimesIt) {
  for (const float factor : {0.25F, -1.0F, 1024.0F}) {
    for_every_rule_and_update({Texture::smooth, Texture::tie_rich, Texture::dyadic},
                              [&](const Problem& problem) {
                                Problem other = problem;
                                scale(other.start, factor);
                                scale(other.level.target, factor);
                                other.level.steps = scaled(other.level.steps, factor);
                                other.level.penalty *= std::abs(factor); // energies are squares of lengths
                                if (other.level.rule == Rule::annealing) {
                                  scale(other.level.strengths, 1.0F / (factor * factor));
                                }
                                VectorField expected = swept(problem, sweeps_of_all_colours);
                                scale(expected, factor);
                                expect_equal(expected, swept(other, sweeps_of_all_colours));
                              });
  }
}

TEST(Units, OnlyRatiosOfModuliCount) {
  for (const float factor : {0.125F, 4096.0F}) {
    for_every_rule_and_update(
        {Texture::smooth, Texture::dyadic, Texture::extreme}, [&](const Problem& problem) {
          Problem other = problem;
          scale(other.level.modulus.values, factor);
          set_inverse_modulus(other.level);
          set_inverse_curvature(other.level);
          expect_equal(swept(problem, sweeps_of_all_colours), swept(other, sweeps_of_all_colours));
        });
  }
}

TEST(Units, TheOriginOfDisplacementsDoesNotMatter) {
  const auto translated = [](VectorField field) {
    std::ranges::for_each(field.x, [](float& value) { value += 64.25F; });
    std::ranges::for_each(field.y, [](float& value) { value -= 3.5F; });
    return field;
  };
  for (const Rule rule : {Rule::steps, Rule::annealing}) {
    for (const Update update : test::simultaneous_and_coloured) {
      for_random_levels(Texture::dyadic, rule, update, [&](const Problem& problem) {
        Problem other = problem;
        other.start = translated(problem.start);
        other.level.target = translated(problem.level.target);
        expect_equal(translated(swept(problem, sweeps_of_all_colours)), swept(other, sweeps_of_all_colours));
      });
    }
  }
}

// ---- Downhill

/// Goes through a sweep in place site by site, in double: every site took the candidate of its lowest energy.
void expect_best_candidates(const Problem& problem) {
  const VectorField after = swept(problem, 1);
  VectorField field = problem.start;
  const Extent extent = problem.level.extent;
  const ThesisEnergy energy(problem.level, field);
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t at = extent.index(x, y);
      const auto found = energy.at(x, y, {after.x[at], after.y[at]});
      for (const float step : problem.level.steps.values()) { // 0 is one of them: not above where it stood
        const auto other =
            energy.at(x, y, {double{field.x[at]} + double{step}, double{field.y[at]} + double{step}});
        ASSERT_LE(found.x, other.x) << x << ", " << y << ", step " << step;
        ASSERT_LE(found.y, other.y) << x << ", " << y << ", step " << step;
      }
      field.x[at] = after.x[at];
      field.y[at] = after.y[at];
    }
  }
}

TEST(SequentialIcm, EverySiteTakesTheCandidateOfItsLowestEnergy) {
  for_random_levels(Texture::dyadic, Rule::steps, Update::sequential, expect_best_candidates);
}

} // namespace
} // namespace hdmbench
