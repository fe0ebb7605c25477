// Images that are too large for a device are cut into pieces; the bits must not show it.

#include "harness/check/faults/faulty_backend.hpp"
#include "test/bit_cases.hpp"
#include "test/elastic_cases.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using Fits = std::function<bool(Extent)>;

/// A backend whose sessions take no other levels or elastic bodies; counts those that it refused.
faults::FaultyBackend limited(const char* inner, const Fits& fits, int& refused) {
  const auto refuse = [fits, &refused](Extent extent) {
    if (!fits(extent)) {
      ++refused;
      throw TooLarge(fmt::format("no room for {}", extent.text()));
    }
  };
  return {test::find(inner),
          {.name = "limited",
           .in_level = [refuse](Level& level) { refuse(level.extent); },
           .in_hierarchy = [refuse](ElasticHierarchy& body) { refuse(body.levels.front().grid.sites); }}};
}

/// Large images are cut, small ones are not, in one session; what cannot be cut so is refused.
TEST(CutSession, GivesScalarsBits) {
  std::vector<test::BitCase> observed;
  for (const Extent extent : {Extent{48, 48}, {1, 61}, {13, 90}, {50, 3}, {9, 11, 18}}) {
    // All sites observed, so that every site of a seam and of a halo has its own target.
    observed.push_back(test::random_bit_case(extent, test::Texture::tie_rich, 71));
    VectorField& confidence = observed.back().problem.level.confidence;
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      std::ranges::fill(confidence[axis], axis == 1 ? 0.5F : 1.0F);
    }
    observed.back().calls = {1, 1, 3, 4, 5, 9, 40, 131}; // halos are renewed on the way
  }
  const test::ExpectedBits seams(std::move(observed));
  const auto small = [](Extent extent) { return extent.sites() <= 1300; };
  const auto low = [](Extent extent) { return extent.height <= 17; };
  const auto narrow = [](Extent extent) { return extent.width <= 20 && extent.height <= 30; };
  for (const auto& [inner, work, fits, group] :
       std::initializer_list<std::tuple<const char*, Work, Fits, test::Group>>{
           {"scalar", Work::dense, small, test::Group::rules},
           {"openmp", Work::active, small, test::Group::pyramids},
           {"openmp", Work::active, low, test::Group::waking},
           {"scalar", Work::dense, narrow, test::Group::sizes}}) {
    int cut = 0;
    const auto backend = limited(inner, fits, cut);
    const auto session = backend.open({.device = {}, .threads = 2, .work = work});
    const test::ExpectedBits cases(cases_of(group));
    for (const test::ExpectedBits* const expected : {&seams, &cases}) {
      cut = 0;
      int refused = 0;
      EXPECT_EQ(expected->differences(*session, &refused), "")
          << inner << ", group " << static_cast<int>(group);
      EXPECT_GT(cut, 0) << "nothing was cut";
      EXPECT_LT(4 * refused, static_cast<int>(expected->count())) << "hardly anything was cut";
    }
  }
}

TEST(CutSession, WhatCannotBeCutIsRefusedWithTheReason) {
  int refused = 0;
  const auto backend = limited(
      "scalar", [](Extent extent) { return extent.height <= 30; }, refused);
  const auto session = backend.open({});
  auto sequential = test::random_problem({40, 40}, test::Texture::smooth, 1);
  sequential.level.update = Update::sequential;
  EXPECT_THAT(test::refusal<TooLarge>([&] { session->load(sequential.level); }),
              testing::AllOf(testing::HasSubstr("no room for 40 x 40"), testing::HasSubstr("sequential")));
  const auto problem = test::random_problem({40, 20}, test::Texture::smooth, 1);
  test::begin(*session, problem);
  session->step(1);
  EXPECT_GT(session->changed(), 0) << "a refused level must leave nothing behind";
}

/// Every step of every method, on cut levels and others, and the dot product.
TEST(CutSession, GivesScalarsBitsOfTheElasticEnergy) {
  for (const auto& [inner, order] :
       {std::pair{"scalar", test::Order::one_by_one}, std::pair{"openmp", test::Order::in_one_go}}) {
    int refused = 0;
    int cut = 0;
    const auto backend = limited(
        inner, [](Extent extent) { return extent.sites() <= 3400; }, refused);
    const auto session = backend.open_elastic({.device = {}, .threads = 2});
    for (const test::ElasticCase& one : test::elastic_cases()) {
      const int before = refused;
      ASSERT_EQ(elastic_difference(*session, one, order), "") << inner;
      cut += refused > before ? 1 : 0;
    }
    EXPECT_GT(cut, 6) << "hardly anything was cut";
  }
}

TEST(CutSession, AnElasticBodyThatFitsInNoPiecesIsRefusedWithTheReason) {
  int refused = 0;
  const auto backend = limited(
      "scalar", [](Extent extent) { return extent.sites() <= 30; }, refused);
  const auto session = backend.open_elastic({});
  const auto cases = test::elastic_cases();
  const auto large = std::ranges::find_if(cases, [](const test::ElasticCase& one) {
    return one.level.extent == Extent{40, 23};
  });
  EXPECT_THAT(test::refusal<TooLarge>([&] { session->load(large->body()); }),
              testing::AllOf(testing::HasSubstr("no room for 40 x 23"),
                             testing::HasSubstr("nor do pieces of it fit")));
  EXPECT_GT(refused, 1);
  EXPECT_EQ(elastic_difference(*session, cases.front(), test::Order::one_by_one), "")
      << "a refused body must leave nothing behind";
}

} // namespace
} // namespace hdmbench
