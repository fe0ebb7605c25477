// Every backend of the registry against scalar; a new one is tested by being there.

#include "harness/check/compare.hpp"
#include "test/refusal.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace hdmbench {
namespace {

class BackendTest : public testing::TestWithParam<std::string> {
protected:
  void SetUp() override {
    try {
      session_ = test::find(GetParam()).open({});
    } catch (const DeviceError& error) {
      GTEST_SKIP() << GetParam() << " is not there: " << error.what();
    }
    scalar_ = test::scalar().open({});
  }

  /// Both sessions from the same start; compares field and count after every sweep.
  void expect_same(const test::Problem& problem, int sweeps, const std::string& what) {
    for (Session* session : {scalar_.get(), session_.get()}) {
      test::begin(*session, problem);
    }
    for (int i = 1; i <= sweeps; ++i) {
      scalar_->step(1);
      session_->step(1);
      ASSERT_NO_FATAL_FAILURE(
          test::expect_same_state(*scalar_, *session_, fmt::format("{}, sweep {}", what, i)));
    }
  }

  std::unique_ptr<Session> scalar_;
  std::unique_ptr<Session> session_;
};

TEST_P(BackendTest, SameBitsAtEverySize) {
  std::uint64_t seed = 100;
  for (const Extent extent : {Extent{1, 1}, Extent{1, 7}, Extent{5, 1}, Extent{2, 2}, Extent{3, 3},
                              Extent{64, 3}, Extent{65, 17}, Extent{257, 130}}) {
    for (const test::Texture texture :
         {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
      ++seed;
      expect_same(test::random_problem(extent, texture, seed), 25,
                  fmt::format("random_problem({{{}, {}}}, Texture({}), {})", extent.width, extent.height,
                              static_cast<int>(texture), seed));
    }
  }
}

/// Tiles are told apart by what they and their rims have: the one that begins at 64, 64, 32 or 64 sites wide
/// and 16 or 64 high, and those around it.
TEST_P(BackendTest, SameBitsWithOneSiteUnlikeTheOthersInOrBesideATile) {
  constexpr Extent extent{200, 200};
  test::Problem problem = test::random_problem(extent, test::Texture::smooth, 31);
  problem.level.confidence = VectorField(extent);
  for (const int x : {63, 64, 100, 127, 128}) {
    for (const int y : {63, 64, 127, 128}) {
      test::Problem other = problem;
      other.level.modulus = ScalarField(extent, 20.0F);
      other.level.modulus.values[extent.index(x, y)] = 3.0F;
      set_inverse_modulus(other.level);
      expect_same(other, 1, fmt::format("modulus at {}, {}", x, y));
      other.level.modulus = ScalarField(extent, 20.0F);
      set_inverse_modulus(other.level);
      other.level.confidence.y[extent.index(x, y)] = 0.5F;
      expect_same(other, 1, fmt::format("confidence at {}, {}", x, y));
    }
  }
}

TEST_P(BackendTest, SameBitsForEveryRuleAndUpdate) {
  std::uint64_t seed = 200;
  for (const Rule rule : test::all_rules) {
    for (const Update update : test::simultaneous_and_coloured) {
      for (const Extent extent :
           {Extent{1, 1}, Extent{1, 6}, Extent{2, 3}, Extent{5, 1}, Extent{66, 17}, Extent{129, 34}}) {
        for (const test::Texture texture :
             {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
          ++seed;
          expect_same(test::random_problem(extent, texture, seed, {}, rule, update), 9,
                      fmt::format("random_problem({{{}, {}}}, Texture({}), {}, {{}}, Rule({}), Update({}))",
                                  extent.width, extent.height, static_cast<int>(texture), seed,
                                  static_cast<int>(rule), static_cast<int>(update)));
        }
      }
    }
  }
}

TEST_P(BackendTest, SameBitsForEveryNumberOfCandidatesToAnneal) {
  for (const char* steps : {"0", "1,-1", "fine", "0,1,2,3,4,5,6,7,8,9,-1,-2,-3,-4,-5,-6"}) {
    expect_same(test::random_problem({40, 30}, test::Texture::smooth, 20, StepSet::parse(steps),
                                     Rule::annealing, Update::four_coloured),
                8, steps);
  }
}

TEST_P(BackendTest, SweepsAreNumberedOnFromTheLoad) {
  for (const Rule rule : test::all_rules) {
    for (const Update update : test::simultaneous_and_coloured) {
      const auto problem = test::random_problem({90, 71}, test::Texture::smooth, 21, {}, rule, update);
      for (int load = 0; load < 2; ++load) {
        for (Session* session : {scalar_.get(), session_.get()}) {
          test::begin(*session, problem);
        }
        for (const int sweeps : {1, 3, 2, 21}) {
          for (int i = 0; i < sweeps; ++i) {
            scalar_->step(1);
          }
          session_->step(sweeps);
          const std::string what =
              fmt::format("Rule({}), Update({}), step({}), load {}", static_cast<int>(rule),
                          static_cast<int>(update), sweeps, load);
          ASSERT_NO_FATAL_FAILURE(test::expect_same_state(*scalar_, *session_, what));
          session_->write(test::read(*scalar_)); // must not number from 0 again
        }
      }
    }
  }
}

TEST_P(BackendTest, SameBitsForEveryNumberOfCandidates) {
  std::vector<float> steps;
  for (int count = 1; count <= StepSet::maximum_count; ++count) {
    steps.push_back(count % 2 == 0 ? 0.1F * static_cast<float>(count)
                                   : -0.3F * static_cast<float>(count - 1));
    expect_same(test::random_problem({40, 30}, test::Texture::tie_rich, 7, StepSet(steps)), 10,
                std::to_string(count) + " candidates");
  }
}

TEST_P(BackendTest, SameChoiceAmongExactTies) {
  for (const char* steps : {"0,-1,-0.25,1,0.25", "1,-1,0.5,-0.5", "0.25,-0.25,0"}) {
    expect_same(test::random_problem({70, 50}, test::Texture::dyadic, 17, StepSet::parse(steps)), 20, steps);
  }
}

TEST_P(BackendTest, SameBitsForTheThesisSteps) {
  expect_same(test::random_problem({50, 50}, test::Texture::tie_rich, 8, StepSet::parse("thesis")), 30,
              "thesis");
}

TEST_P(BackendTest, ManyIterationsInOneCallEqualSingleOnes) {
  const auto problem = test::random_problem({90, 70}, test::Texture::smooth, 9);
  for (Session* session : {scalar_.get(), session_.get()}) {
    test::begin(*session, problem);
  }
  for (const int iterations : {0, 1, 2, 7, 300}) {
    for (int i = 0; i < iterations; ++i) {
      scalar_->step(1);
    }
    session_->step(iterations);
    test::expect_same_state(*scalar_, *session_, std::to_string(iterations));
  }
}

TEST_P(BackendTest, ASessionForgetsTheLevelBefore) {
  for (const Extent extent : {Extent{60, 40}, Extent{8, 8}, Extent{100, 90}, Extent{1, 1}, Extent{60, 40}}) {
    expect_same(test::random_problem(extent, test::Texture::tie_rich, 10,
                                     StepSet::parse(extent.width > 50 ? "fine" : "default")),
                5, "after another level");
  }
}

TEST_P(BackendTest, SessionsDoNotDisturbEachOther) {
  const auto other = test::find(GetParam()).open({});
  const auto problem = test::random_problem({33, 44}, test::Texture::tie_rich, 11);
  const auto decoy = test::random_problem({12, 70}, test::Texture::smooth, 12);
  test::begin(*other, decoy);
  expect_same(problem, 3, "beside another session");
  other->step(3);
  test::begin(*scalar_, decoy);
  scalar_->step(3);
  EXPECT_EQ(compare(test::read(*scalar_), test::read(*other)).sites, 0);
}

TEST_P(BackendTest, WritingRestartsTheCount) {
  const auto problem = test::random_problem({20, 20}, test::Texture::smooth, 13);
  test::begin(*session_, problem);
  EXPECT_EQ(session_->changed(), 0);
  session_->step(1);
  EXPECT_GT(session_->changed(), 0);
  session_->write(problem.start);
  EXPECT_EQ(session_->changed(), 0);
  EXPECT_EQ(compare(problem.start, test::read(*session_)).sites, 0);
}

TEST_P(BackendTest, CallsOutOfOrderAreRefused) {
  VectorField field({4, 4});
  EXPECT_THROW(session_->step(1), std::logic_error);
  EXPECT_THROW(session_->write(field), std::logic_error);
  EXPECT_THROW(session_->read(field), std::logic_error);
  EXPECT_THROW((void)session_->changed(), std::logic_error);
  session_->load(test::random_problem({4, 5}, test::Texture::smooth, 1).level);
  EXPECT_THROW(session_->step(1), std::logic_error) << "before write";
  EXPECT_THROW(session_->write(field), std::logic_error) << "wrong size";
  VectorField right({4, 5});
  session_->write(right);
  EXPECT_THROW(session_->step(-1), std::logic_error);
}

TEST_P(BackendTest, SequentialUpdatesAreDoneOrRefused) {
  auto problem = test::random_problem({12, 12}, test::Texture::smooth, 18);
  problem.level.update = Update::sequential;
  if (test::find(GetParam()).supports(Update::sequential)) {
    expect_same(problem, 3, "sequential");
  } else {
    EXPECT_THROW(session_->load(problem.level), DeviceError);
  }
}

TEST_P(BackendTest, AnUnknownDeviceIsRefusedWithTheListOfDevices) {
  const Backend& backend = test::find(GetParam());
  EXPECT_THAT(test::refusal<DeviceError>([&] { (void)backend.open({.device = "no such device"}); }),
              testing::HasSubstr(backend.devices().front().name));
  EXPECT_EQ(backend.device({.device = "0"}).name, backend.devices().front().name);
  EXPECT_FALSE(backend.devices().front().name.empty());
}

TEST_P(BackendTest, AnImageBeyondTheDevicesLimitIsCutOrRefusedWhereItCannotBe) {
  if (test::find(GetParam()).threads({}) > 0) {
    GTEST_SKIP() << "limited by memory only";
  }
  // Longer than any texture or number of work groups today, small in memory.
  const Extent extent = GetParam().ends_with("compute") ? Extent{5, 70000} : Extent{70000, 5};
  try {
    session_->load(test::random_problem(extent, test::Texture::smooth, 1, {}, Rule::annealing).level);
    GTEST_SKIP() << "this device takes 70000 sites in a line";
  } catch (const TooLarge& error) {
    for (const char* part : {"70000", "annealing"}) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
  expect_same(test::random_problem({9, 9}, test::Texture::smooth, 14), 2, "after a refused level");
  if (extent.width > extent.height) { // rows are what annealing can be cut into
    expect_same(test::random_problem({5, 70000}, test::Texture::smooth, 13, {}, Rule::annealing), 2,
                "annealing, cut in rows");
  }
  expect_same(test::random_problem(extent, test::Texture::tie_rich, 15), 3, "cut");
  expect_same(
      test::random_problem(extent, test::Texture::smooth, 16, {}, Rule::closed_form, Update::coloured), 3,
      "cut, in two colours");
  expect_same(test::random_problem({9, 9}, test::Texture::smooth, 17), 2, "whole again");
}

void expect_same_for_every_number_of_threads(Rule rule, Update update) {
  // Large enough for eight threads; bands of 200 / 8 rows have seams that sweeps pass together.
  const auto problem = test::random_problem({300, 200}, test::Texture::tie_rich, 15, {}, rule, update);
  const auto scalar = test::scalar().open({});
  for (const int iterations : {1, 2, 3, 5, 8, 20}) {
    test::begin(*scalar, problem);
    scalar->step(iterations);
    for (int threads = 1; threads <= 8; ++threads) {
      const auto session = test::find("openmp").open({.device = {}, .threads = threads});
      test::begin(*session, problem);
      session->step(iterations);
      test::expect_same_state(*scalar, *session, fmt::format("{} threads, {}", threads, iterations));
    }
  }
}

TEST(OpenMpBackend, SameBitsForEveryNumberOfThreads) {
  expect_same_for_every_number_of_threads(Rule::steps, Update::simultaneous);
  expect_same_for_every_number_of_threads(Rule::closed_form, Update::coloured);
  expect_same_for_every_number_of_threads(Rule::annealing, Update::four_coloured);
}

TEST(ScalarBackend, SequentialSweepsSeeNewValues) {
  auto problem = test::random_problem({40, 40}, test::Texture::smooth, 16);
  const auto scalar = test::scalar().open({});
  std::vector<VectorField> fields;
  for (const Update update : {Update::simultaneous, Update::sequential}) {
    problem.level.update = update;
    test::begin(*scalar, problem);
    scalar->step(1);
    fields.push_back(test::read(*scalar));
  }
  EXPECT_GT(compare(fields[0], fields[1]).sites, 100);
  // The first site of the raster sees no new value yet.
  EXPECT_EQ(fields[0].x[0], fields[1].x[0]);
}

INSTANTIATE_TEST_SUITE_P(Registry, BackendTest, testing::ValuesIn(test::backend_names()),
                         test::parameter_name);

} // namespace
} // namespace hdmbench
