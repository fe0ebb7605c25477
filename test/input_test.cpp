// What a level or a step set refuses, and that it says where.

#include "test/files.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace hdmbench {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

using test::refusal;

std::string refusal_of_level(const std::function<void(Level&)>& spoil) {
  Level level = test::random_problem({7, 5}, test::Texture::smooth, 1).level;
  spoil(level);
  return refusal([&] { validate(level); });
}

TEST(Input, AGoodLevelIsAccepted) {
  EXPECT_EQ(refusal_of_level([](Level&) {}), "accepted");
}

TEST(Input, EveryBadValueIsNamedWithItsPlace) {
  // Site 9 of a 7 x 5 image.
  const auto place = AllOf(HasSubstr("x = 2"), HasSubstr("y = 1"));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.modulus.values[9] = 0.0F; }),
              AllOf(place, HasSubstr("modulus")));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.modulus.values[9] = -1.0F; }),
              AllOf(place, HasSubstr("-1")));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.modulus.values[9] = not_a_number; }), place);
  EXPECT_THAT(refusal_of_level([](Level& level) { level.modulus.values[9] = infinity; }), place);
  EXPECT_THAT(refusal_of_level([](Level& level) { level.modulus.values[9] = 1e-39F; }),
              AllOf(place, HasSubstr("its inverse")));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.target.x[9] = not_a_number; }),
              AllOf(place, HasSubstr("target")));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.target.y[9] = -infinity; }), place);
  EXPECT_THAT(refusal_of_level([](Level& level) { level.confidence.x[9] = 1.5F; }),
              AllOf(place, HasSubstr("confidence")));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.confidence.y[9] = -0.1F; }),
              AllOf(place, HasSubstr("confidence")));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.confidence.y[9] = not_a_number; }), place);
}

TEST(Input, BadPenaltyAndSizesAreRefused) {
  for (const float penalty : {0.0F, -1.0F, infinity, not_a_number}) {
    EXPECT_THAT(refusal_of_level([&](Level& level) { level.penalty = penalty; }), HasSubstr("penalty K"))
        << penalty;
  }
  EXPECT_THAT(refusal_of_level([](Level& level) { level.target = VectorField({5, 7}); }), HasSubstr("5 x 7"));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.modulus.values.pop_back(); }),
              HasSubstr("34 values"));
  EXPECT_THAT(refusal_of_level([](Level& level) { level.extent = {0, 5}; }), HasSubstr("at least 1"));
}

TEST(Input, StepSetsByNameAndByNumber) {
  EXPECT_EQ(StepSet().text(), "0, -1, -0.1, 1, 0.1");
  EXPECT_EQ(StepSet::parse("default").text(), StepSet().text());
  EXPECT_EQ(StepSet::parse("thesis").text(), "-1, -0.1, 1, 0.1");
  EXPECT_EQ(StepSet::parse("0, -2,+2,1e-2").text(), "0, -2, 2, 0.01");
  EXPECT_EQ(StepSet::parse("0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15").count(), 16);
}

TEST(Input, BadStepSetsAreRefused) {
  const auto parse = [](const char* text) { return refusal([=] { (void)StepSet::parse(text); }); };
  EXPECT_THAT(parse(""), HasSubstr("has 0 candidates; give 1 to 16"));
  EXPECT_THAT(parse("0,,1"), HasSubstr("not a number"));
  EXPECT_THAT(parse("0,one"), HasSubstr("\"one\" is not a number"));
  EXPECT_THAT(parse("0,nan"), HasSubstr("finite"));
  EXPECT_THAT(parse("inf"), HasSubstr("finite"));
  EXPECT_THAT(parse("0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16"),
              HasSubstr("has 17 candidates; give 1 to 16"));
}

} // namespace
} // namespace hdmbench
