// Images that are too large for a device are cut into pieces; the bits must not show it.

#include "backends/shared/cut_session.hpp"
#include "test/bit_cases.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace hdmbench {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// What the sessions of a Limited backend take.
struct Limit {
  int columns = std::numeric_limits<int>::max();
  int rows = std::numeric_limits<int>::max();
  std::size_t sites = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] bool fits(Extent extent) const {
    return extent.width <= columns && extent.height <= rows && extent.sites() <= sites;
  }
};

struct Loads {
  int refused = 0;
  std::vector<Extent> taken;
};

/// `inner`, but for the limit.
class LimitedSession final : public Session {
public:
  LimitedSession(std::unique_ptr<Session> inner, const Limit& limit, Loads& loads)
      : inner_(std::move(inner)), limit_(limit), loads_(loads) {}

private:
  void do_load(const Level& level) override {
    if (!limit_.fits(level.extent)) {
      ++loads_.refused;
      throw TooLarge(fmt::format("no room for {} x {}", level.extent.width, level.extent.height));
    }
    loads_.taken.push_back(level.extent);
    inner_->load(level);
  }
  void do_write(const VectorField& displacement) override { inner_->write(displacement); }
  void do_step(int /*first*/, int sweeps) override { inner_->step(sweeps); }
  void do_read(VectorField& displacement) override { inner_->read(displacement); }
  std::int64_t do_changed() override { return inner_->changed(); }

  std::unique_ptr<Session> inner_;
  Limit limit_;
  Loads& loads_;
};

class Limited final : public Backend {
public:
  Limited(std::string_view inner, const Limit& limit) : inner_(test::find(inner)), limit_(limit) {}

  std::string_view name() const override { return "limited"; }
  std::string_view description() const override { return ""; }
  bool supports(Update update) const override { return inner_.supports(update); }
  std::vector<Device> devices() const override { return inner_.devices(); }

  mutable Loads loads;

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& options) const override {
    return std::make_unique<LimitedSession>(inner_.open(options), limit_, loads);
  }

  const Backend& inner_;
  Limit limit_;
};

TEST(CutImage, PiecesOwnEverySiteOnceAndSeeTheirHalo) {
  for (const Extent extent :
       {Extent{16, 16}, Extent{97, 33}, Extent{1, 70}, Extent{300, 8}, Extent{2048, 999}}) {
    for (const int count : {2, 4, 8, 16}) {
      const Cut cut = cut_image(extent, count);
      if (cut.pieces.empty()) {
        continue;
      }
      ASSERT_EQ(cut.pieces.size(), static_cast<std::size_t>(count));
      std::vector<int> owners(extent.sites());
      for (const auto& [owned, loaded] : cut.pieces) {
        for (int y = owned.top; y < owned.top + owned.height; ++y) {
          for (int x = owned.left; x < owned.left + owned.width; ++x) {
            ++owners[extent.index(x, y)];
          }
        }
        EXPECT_EQ(loaded.left % 4, 0);
        EXPECT_EQ(loaded.top % 4, 0);
        EXPECT_EQ(loaded.left, std::max(0, owned.left - cut.halo));
        EXPECT_EQ(loaded.top, std::max(0, owned.top - cut.halo));
        EXPECT_EQ(loaded.left + loaded.width, std::min(extent.width, owned.left + owned.width + cut.halo));
        EXPECT_EQ(loaded.top + loaded.height, std::min(extent.height, owned.top + owned.height + cut.halo));
      }
      EXPECT_TRUE(std::ranges::all_of(owners, [](int owner) { return owner == 1; }));
    }
  }
}

/// Large images are cut, small ones are not, in one session; what cannot be cut so is refused.
TEST(CutSession, GivesScalarsBits) {
  std::vector<test::BitCase> observed;
  for (const Extent extent : {Extent{48, 48}, {1, 61}, {13, 90}, {50, 3}}) {
    // All sites observed, so that every site of a seam and of a halo has its own target.
    observed.push_back(test::random_bit_case(extent, test::Texture::tie_rich, 71));
    std::ranges::fill(observed.back().problem.level.confidence.x, 1.0F);
    std::ranges::fill(observed.back().problem.level.confidence.y, 0.5F);
    observed.back().calls = {1, 1, 3, 4, 5, 9, 40, 131}; // halos are renewed on the way
  }
  const test::ExpectedBits seams(std::move(observed));
  struct Cutting {
    const char* inner;
    Work work;
    Limit limit;
    test::Group group;
  };
  for (const Cutting& cutting : {Cutting{"scalar", Work::dense, {.sites = 1300}, test::Group::rules},
                                 {"openmp", Work::active, {.sites = 1300}, test::Group::pyramids},
                                 {"openmp", Work::active, {.rows = 17}, test::Group::waking},
                                 {"openmp", Work::dense, {.columns = 40}, test::Group::sizes},
                                 {"scalar", Work::dense, {.columns = 20, .rows = 30}, test::Group::sizes}}) {
    const Limited backend(cutting.inner, cutting.limit);
    const auto session = backend.open({.device = {}, .threads = 2, .work = cutting.work});
    const test::ExpectedBits cases(cases_of(cutting.group));
    for (const test::ExpectedBits* const expected : {&seams, &cases}) {
      const int cut_before = backend.loads.refused;
      int refused = 0;
      EXPECT_EQ(expected->differences(*session, &refused), "")
          << cutting.inner << " with at most " << cutting.limit.columns << " columns, " << cutting.limit.rows
          << " rows, " << cutting.limit.sites << " sites";
      EXPECT_GT(backend.loads.refused, cut_before) << "nothing was cut";
      EXPECT_LT(4 * refused, static_cast<int>(expected->count())) << "hardly anything was cut";
    }
  }
}

TEST(CutSession, WhatCannotBeCutIsRefusedWithTheReason) {
  const Limited backend("scalar", {.rows = 30});
  const auto session = backend.open({});
  auto sequential = test::random_problem({40, 40}, test::Texture::smooth, 1);
  sequential.level.update = Update::sequential;
  const Pyramid pyramid{.full = &sequential.level, .levels = {{.extent = {40, 40}, .sweeps = 1}}};
  // LimitedSession computes level by level, so only the last level says so.
  session->load(pyramid);
  EXPECT_THAT(test::refusal<TooLarge>([&] { session->solve(); }), HasSubstr("sequential"));
  EXPECT_THAT(test::refusal<TooLarge>([&] { session->load(sequential.level); }),
              AllOf(HasSubstr("no room for 40 x 40"), HasSubstr("sequential")));
  const auto problem = test::random_problem({40, 20}, test::Texture::smooth, 1);
  test::begin(*session, problem);
  session->step(1);
  EXPECT_GT(session->changed(), 0) << "a refused level must leave nothing behind";
}

TEST(CutSession, PiecesThatDoNotFitAreRefusedInTheDevicesWords) {
  const Limited backend("scalar", {.sites = 10});
  const auto session = backend.open({});
  EXPECT_THAT(test::refusal<TooLarge>([&] {
                session->load(test::random_problem({40, 40}, test::Texture::smooth, 1).level);
              }),
              HasSubstr("limited: no room for 40 x 40; nor do pieces of it fit: no room for 8 x 8"));
  EXPECT_THAT(test::refusal<TooLarge>([&] {
                session->load(test::random_problem({4, 4}, test::Texture::smooth, 1).level);
              }),
              HasSubstr("no room for 4 x 4"));
}

} // namespace
} // namespace hdmbench
