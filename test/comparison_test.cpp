// That differences are seen, that none is seen where there is none, and that noise is named.

#include "harness/measure/comparison/interleave.hpp"
#include "harness/measure/comparison/rows.hpp"
#include "test/program.hpp"
#include "test/refusal.hpp"
#include "test/sessions.hpp"
#include "test/temporary_folder.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <vector>

namespace hdmbench::comparison {
namespace {

using testing::HasSubstr;
using testing::Not;

/// 1 ... m and m + 1 ... m + n, but so interleaved that U of the second is u.
struct Sides {
  std::vector<double> first;
  std::vector<double> second;
};

Sides with_u(std::size_t m, std::size_t n, std::size_t u) {
  Sides sides;
  for (std::size_t i = 0; i < m; ++i) {
    sides.first.push_back(static_cast<double>(i));
  }
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t above = std::min(u, m); // of the first side
    u -= above;
    sides.second.push_back(static_cast<double>(above) - 0.5 - 0.001 * static_cast<double>(n - j));
  }
  return sides;
}

double p_of(std::size_t m, std::size_t n, std::size_t u) {
  const Sides sides = with_u(m, n, u);
  const RankTest found = rank_test(sides.first, sides.second);
  EXPECT_EQ(found.u, static_cast<double>(u));
  return found.p;
}

// H. B. Mann, D. R. Whitney: On a test of whether one of two random variables is stochastically larger than
// the other. Annals of Mathematical Statistics 18 (1947), Table I: P(U <= u) for n = 3 and n = 4.
TEST(RankTest, HasTheProbabilitiesOfMannAndWhitney) {
  const std::vector<double> three_three{.050, .100, .200, .350, .500};
  for (std::size_t u = 0; u < three_three.size(); ++u) {
    EXPECT_NEAR(p_of(3, 3, u) / 2.0, three_three[u], 5e-4) << u;
  }
  const std::vector<double> four_four{.014, .029, .057, .100, .171, .243, .343, .443};
  for (std::size_t u = 0; u < four_four.size(); ++u) {
    EXPECT_NEAR(p_of(4, 4, u) / 2.0, four_four[u], 5e-4) << u;
  }
  const std::vector<double> two_four{.067, .133, .267, .400};
  for (std::size_t u = 0; u < two_four.size(); ++u) {
    EXPECT_NEAR(p_of(2, 4, u) / 2.0, two_four[u], 5e-4) << u;
    EXPECT_NEAR(p_of(4, 2, u) / 2.0, two_four[u], 5e-4) << u;
  }
}

// The usual table of critical values, two-sided: U may be at most this.
TEST(RankTest, HasTheCriticalValuesOfTheTables) {
  struct Critical {
    std::size_t m;
    std::size_t n;
    std::size_t at_5_percent;
    std::size_t at_1_percent;
  };
  for (const Critical& row :
       {Critical{5, 5, 2, 0}, Critical{5, 8, 6, 2}, Critical{8, 8, 13, 7}, Critical{10, 10, 23, 16},
        Critical{12, 15, 49, 37}, Critical{20, 20, 127, 105}}) {
    EXPECT_LE(p_of(row.m, row.n, row.at_5_percent), 0.05) << row.m << ' ' << row.n;
    EXPECT_GT(p_of(row.m, row.n, row.at_5_percent + 1), 0.05) << row.m << ' ' << row.n;
    EXPECT_LE(p_of(row.m, row.n, row.at_1_percent), 0.01) << row.m << ' ' << row.n;
    EXPECT_GT(p_of(row.m, row.n, row.at_1_percent + 1), 0.01) << row.m << ' ' << row.n;
  }
}

TEST(RankTest, DoesNotCareWhichSideIsWhich) {
  const Sides sides = with_u(6, 9, 11);
  EXPECT_DOUBLE_EQ(rank_test(sides.first, sides.second).p, rank_test(sides.second, sides.first).p);
  EXPECT_EQ(rank_test(sides.first, sides.second).u + rank_test(sides.second, sides.first).u, 54.0);
}

// Of the 10 ways to deal 1 2 2 3 3 into 2 and 3, those with a sum of ranks <= 1 + 2.5 are {1, 2}, twice.
TEST(RankTest, CountsTiesAsTheyAre) {
  const std::vector<double> first{2, 3, 3};
  const std::vector<double> second{1, 2};
  const RankTest found = rank_test(first, second);
  EXPECT_EQ(found.u, 0.5);
  EXPECT_DOUBLE_EQ(found.p, 2.0 * 2.0 / 10.0);
  const std::vector<double> same(7, 1.0);
  EXPECT_EQ(rank_test(same, same).p, 1.0);
}

TEST(RankTest, ApproximatesManyWell) {
  std::mt19937 random(8);
  std::normal_distribution<double> noise;
  std::vector<double> first(30);
  std::vector<double> second(30);
  std::ranges::generate(first, [&] { return noise(random); });
  std::ranges::generate(second, [&] { return noise(random) + 0.6; });
  const double exact = rank_test(first, second).p;
  // One more pair that is far apart in the same sense on either side hardly counts.
  first.push_back(-9.0);
  second.push_back(-8.0);
  const double approximate = rank_test(first, second).p;
  EXPECT_GT(exact, 1e-4);
  EXPECT_LT(exact, 0.05);
  EXPECT_NEAR(std::log(approximate), std::log(exact), 0.5);
}

TEST(RankTest, NeedsEnoughSamples) {
  EXPECT_DOUBLE_EQ(smallest_p(3, 3), 2.0 / 20.0);
  EXPECT_DOUBLE_EQ(smallest_p(5, 5), 2.0 / 252.0);
  EXPECT_EQ(smallest_p(0, 5), 1.0);
  EXPECT_EQ(samples_that_can_tell(5, 5), 5U);
  EXPECT_EQ(samples_that_can_tell(3, 5), 9U);
  const std::vector<double> low{1.0, 1.1, 1.2};
  const std::vector<double> high{2.0, 2.1, 2.2};
  EXPECT_EQ(compare_samples(low, high, 0.05).change, Change::too_few);
  EXPECT_EQ(compare_samples(low, {}, 0.05).change, Change::too_few);
}

std::vector<double> timings(std::mt19937& random, double centre, double spread, int count) {
  std::normal_distribution<double> noise(0.0, spread);
  std::vector<double> samples(static_cast<std::size_t>(count));
  std::ranges::generate(samples, [&] { return centre * std::exp(noise(random)); });
  return samples;
}

TEST(Comparison, IntervalsCoverWhatTheySay) {
  std::mt19937 random(1);
  int covered = 0;
  double coverage = 0.0;
  constexpr int trials = 1000;
  for (int i = 0; i < trials; ++i) {
    const auto first = timings(random, 1.0, 0.05, 8);
    const auto second = timings(random, 1.1, 0.05, 8);
    const Ratio ratio = ratio_of(first, second);
    covered += ratio.low <= 1.1 && 1.1 <= ratio.high ? 1 : 0;
    coverage = ratio.coverage;
  }
  EXPECT_GE(coverage, 0.95);
  EXPECT_NEAR(static_cast<double>(covered) / trials, coverage, 3.0 * std::sqrt(0.05 / trials));
}

TEST(Comparison, SeesAPlantedSlowDownAndNoneWhereThereIsNone) {
  std::mt19937 random(2);
  int false_alarms = 0;
  int seen = 0;
  int none_seen = 0;
  constexpr int trials = 500;
  for (int i = 0; i < trials; ++i) {
    const auto before = timings(random, 0.01, 0.02, 10);
    const Comparison same = compare_samples(before, timings(random, 0.01, 0.02, 10), 0.05);
    false_alarms += same.change == Change::slower || same.change == Change::faster ? 1 : 0;
    none_seen += same.change == Change::none_seen ? 1 : 0;
    EXPECT_FALSE(same.slower_than_tolerated);
    const Comparison slower = compare_samples(before, timings(random, 0.012, 0.02, 10), 0.05);
    seen += slower.slower_than_tolerated ? 1 : 0;
    const Comparison faster = compare_samples(before, timings(random, 0.008, 0.02, 10), 0.05);
    EXPECT_EQ(faster.change, Change::faster);
    EXPECT_FALSE(faster.slower_than_tolerated);
  }
  EXPECT_EQ(seen, trials);
  EXPECT_LE(false_alarms, 12) << "1 % of them, and three standard deviations more";
  EXPECT_GE(none_seen, trials * 95 / 100);
}

TEST(Comparison, NamesNoise) {
  std::mt19937 random(3);
  const auto before = timings(random, 1.0, 0.2, 10);
  const auto after = timings(random, 1.0, 0.2, 10);
  const Comparison found = compare_samples(before, after, 0.05);
  EXPECT_EQ(found.change, Change::too_noisy);
  EXPECT_TRUE(found.noisy());
  EXPECT_GT(found.samples_needed, 50U);
  EXPECT_THAT(noise_text(found, 0.05), HasSubstr("samples a side"));
  // Noise is said beside a difference as well.
  const Comparison huge = compare_samples(before, timings(random, 9.0, 0.2, 10), 0.05);
  EXPECT_EQ(huge.change, Change::slower);
  EXPECT_THAT(noise_text(huge, 0.05), HasSubstr("noise: spread"));
  const Comparison quiet =
      compare_samples(timings(random, 1.0, 0.01, 10), timings(random, 1.0, 0.01, 10), 0.05);
  EXPECT_EQ(noise_text(quiet, 0.05), "");
}

// No difference is said only where the interval leaves no room for one, to either side.
TEST(Comparison, RoomForADifferenceIsNoAbsenceOfOne) {
  std::vector<double> before;
  std::vector<double> after;
  for (int i = 0; i < 10; ++i) {
    before.push_back(1.0 + 0.01 * i);
    after.push_back(1.03 * before.back());
  }
  const Comparison slower = compare_samples(before, after, 0.05);
  EXPECT_GT(slower.p, significant_p);
  EXPECT_GT(slower.ratio.low, 1.0 / 1.05);
  EXPECT_GT(slower.ratio.high, 1.05);
  EXPECT_EQ(slower.change, Change::too_noisy);
  EXPECT_EQ(compare_samples(after, before, 0.05).change, Change::too_noisy);
  EXPECT_EQ(compare_samples(after, before, 0.1).change, Change::none_seen);
}

// What it asks for is what it takes: a change of the tolerance's size is seen in nine of ten comparisons.
TEST(Comparison, AsksForAsManySamplesAsItTakes) {
  std::mt19937 random(7);
  const Comparison few =
      compare_samples(timings(random, 1.0, 0.1, 1000), timings(random, 1.0, 0.1, 1000), 0.05);
  constexpr int needed = 131; // for a spread of 0.1, which is estimated from the samples
  EXPECT_NEAR(static_cast<double>(few.samples_needed), needed, 20.0);
  int seen = 0;
  constexpr int trials = 300;
  for (int i = 0; i < trials; ++i) {
    const auto before = timings(random, 1.0, 0.1, needed);
    seen +=
        compare_samples(before, timings(random, 1.05, 0.1, needed), 0.05).change == Change::slower ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(seen) / trials, 0.9, 0.06);
  const Comparison enough =
      compare_samples(timings(random, 1.0, 0.1, needed), timings(random, 1.0, 0.1, needed), 0.05);
  EXPECT_NEAR(enough.largest_good_spread, 0.1, 0.001);
}

BenchRow row_of(const std::string& backend, std::vector<double> seconds) {
  BenchRow row;
  row.scene = "square";
  row.width = row.height = 300;
  row.backend = backend;
  row.method = "icm";
  row.device = "a CPU";
  row.valid = true;
  row.seconds = std::move(seconds);
  return row;
}

TEST(ComparedRows, MatchWhatComputedTheSame) {
  std::mt19937 random(4);
  std::vector<BenchRow> old{row_of("scalar", timings(random, 1.0, 0.01, 10)),
                            row_of("openmp", timings(random, 0.1, 0.01, 10)), row_of("gl-fragment", {}),
                            row_of("gone", timings(random, 1.0, 0.01, 10))};
  old[2].valid = false;
  old[2].reason = "no driver";
  std::vector<BenchRow> news{
      row_of("openmp", timings(random, 0.12, 0.01, 10)), row_of("scalar", timings(random, 1.0, 0.01, 10)),
      row_of("openmp", timings(random, 0.3, 0.01, 10)), row_of("fresh", timings(random, 1.0, 0.01, 10)),
      row_of("gl-fragment", timings(random, 1.0, 0.01, 10))};
  news[0].threads = 2;
  news[0].device = "another CPU";
  news[2].threads = 1;
  const auto rows = compare_rows(old, news, 0.05);
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows[0].comparison.change, Change::none_seen);
  EXPECT_TRUE(rows[1].comparison.slower_than_tolerated);
  EXPECT_NEAR(rows[1].comparison.ratio.estimate, 1.2, 0.03)
      << "most threads, where the old side does not tell";
  EXPECT_THAT(rows[1].remark, HasSubstr("another CPU"));
  EXPECT_FALSE(rows[2].compared);
  EXPECT_THAT(rows[2].remark, HasSubstr("no driver"));
  EXPECT_THAT(rows[3].remark, HasSubstr("not measured by the new side"));
  EXPECT_EQ(rows[4].row.backend, "fresh");
  EXPECT_THAT(rows[4].remark, HasSubstr("not measured by the old side"));
}

TEST(ComparedRows, OneWrongFieldSpoilsTheTimings) {
  std::mt19937 random(6);
  const std::vector<BenchRow> old{row_of("openmp", timings(random, 1.0, 0.01, 10))};
  std::vector<BenchRow> news{old[0], old[0]};
  news[1].valid = false;
  news[1].reason = "7 sites differ";
  const auto rows = compare_rows(old, news, 0.05);
  EXPECT_FALSE(rows[0].compared);
  EXPECT_THAT(rows[0].remark, HasSubstr("new: 7 sites differ"));
  const auto turned = compare_rows(news, old, 0.05);
  EXPECT_FALSE(turned[0].compared);
  EXPECT_THAT(turned[0].remark, HasSubstr("old: 7 sites differ"));
}

/// A program that takes hdmbench's place: writes what bench writes, with `seconds` and 1 % of noise, and its
/// `name` to a file.
std::filesystem::path stand_in(const test::TemporaryFolder& folder, const std::string& name, double seconds,
                               const std::string& machine = "m") {
  const auto file = folder.write(name, fmt::format(R"(#!/bin/bash
echo {0} "$*" >> '{1}/calls'
while [ $# -gt 1 ]; do shift; done
n=$(grep -c '^{0} ' '{1}/calls')
s=$(awk "BEGIN {{ srand($n); print {2} * (0.99 + 0.02 * rand()) }}")
cat > "$1" << END
{{"schema": 1, "command": "bench", "context": {{"machine": "{3}", "cpu": "c", "cores": 2, "operating_system": "o",
"compiler": "g", "flags": "f", "commit": "{0}", "version": "0", "date": "2026-01-01T00:00:00Z",
"arguments": "bench square --size 300 --json old.json", "quick": false}},
"results": [{{"scene": "square", "width": 300, "height": 300, "backend": "openmp", "device": "d", "method": "icm",
"iterations": 500, "seconds": [$s], "seconds_median": $s, "msites_per_second": 1, "setup_seconds": 1,
"projection_seconds": 1, "upload_seconds": 1, "compute_seconds": 1, "readback_seconds": 1,
"speed_up_over_scalar": 1, "valid": true, "reason": ""}}]}}
END
)",
                                                   name, folder.path().string(), seconds, machine));
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return file;
}

TEST(Interleave, TakesTurnsAndSeesTheSlowerOne) {
  const test::TemporaryFolder folder;
  const auto old = stand_in(folder, "old", 1.0);
  const auto slow = stand_in(folder, "slow", 1.2);
  const BothSides sides = interleave(old, slow, {{"square", "--size", "300"}}, 8, test::silent());
  const auto rows = compare_rows(sides.first.rows, sides.second.rows, 0.05);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].first.size(), 8U);
  EXPECT_TRUE(rows[0].comparison.slower_than_tolerated);
  EXPECT_NEAR(rows[0].comparison.ratio.estimate, 1.2, 0.02);
  std::ifstream calls(folder.path() / "calls");
  std::string order;
  for (std::string line; std::getline(calls, line);) {
    order += line.substr(0, 1);
    EXPECT_THAT(line, HasSubstr(" bench square --size 300 --repeat 1 --json "));
  }
  EXPECT_EQ(order, "ossoossoossoosso");

  const auto same = stand_in(folder, "again", 1.0);
  const BothSides equal = interleave(old, same, {{"square"}}, 8, test::silent());
  EXPECT_EQ(compare_rows(equal.first.rows, equal.second.rows, 0.05)[0].comparison.change, Change::none_seen);
}

TEST(Interleave, TellsWhatAProgramThatFailsSays) {
  const test::TemporaryFolder folder;
  const auto broken = folder.write("broken", "#!/bin/sh\necho out of ink >&2\nexit 3\n");
  std::filesystem::permissions(broken, std::filesystem::perms::owner_all);
  EXPECT_THAT(test::refusal([&] { (void)run_bench(broken, {"square"}, 1); }),
              testing::AllOf(HasSubstr("exit status 3"), HasSubstr("out of ink")));
}

/// What a stand-in writes when it is called as bench.
std::filesystem::path results_of(const test::TemporaryFolder& folder, const std::string& name, double seconds,
                                 const std::string& machine = "m") {
  const auto program = stand_in(folder, name, seconds, machine);
  const auto file = folder.path() / (name + ".json");
  nlohmann::json all;
  for (int i = 0; i < 8; ++i) {
    const auto single = folder.path() / "single.json";
    EXPECT_EQ(std::system((program.string() + " " + single.string()).c_str()), 0);
    nlohmann::json document = test::read_json(single);
    if (all.is_null()) {
      all = document;
    } else {
      all["results"].push_back(document["results"][0]);
    }
  }
  std::ofstream(file) << all;
  return file;
}

TEST(CompareCommand, ComparesTwoFiles) {
  const test::TemporaryFolder folder;
  const std::string old = results_of(folder, "old", 1.0).string();
  const std::string slow = results_of(folder, "slow", 1.2, "another machine").string();
  const std::string same = results_of(folder, "same", 1.0).string();
  const auto json = folder.path() / "compared.json";

  test::expect_run(1, "bench --compare " + old + " --with " + slow + " --json " + json.string(),
                   AllOf(HasSubstr("slower"), HasSubstr("machines differ")));
  const nlohmann::json row = test::read_json(json)["results"].at(0);
  EXPECT_EQ(row["verdict"], "slower");
  EXPECT_NEAR(row["ratio"].get<double>(), 1.2, 0.02);
  EXPECT_EQ(row["old_seconds"].size(), 8U);

  EXPECT_EQ(test::hdmbench("bench --compare " + slow + " --with " + old).status, 0) << "faster is good";
  EXPECT_EQ(test::hdmbench("bench --compare " + old + " --with " + slow + " --tolerance 30").status, 0);
  test::expect_run(0, "bench --compare " + old + " --with " + same,
                   AllOf(HasSubstr("no difference seen"), Not(HasSubstr("machines differ"))));
}

TEST(CompareCommand, RunsAgainWhatTheFileHas) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "old.json";
  ASSERT_EQ(
      test::hdmbench(
          "bench square --sizes 16,8x12 --backends openmp --repeat 5 --iterations 3 --no-ceilings --json " +
          file.string())
          .status,
      0);
  // Times of so few microseconds say nothing: only that all rows are measured again.
  test::expect_run(0, "bench --tolerance 900 --compare " + file.string(),
                   AllOf(HasSubstr("Of 6 compared"), HasSubstr("5+5")));
  test::expect_run(0,
                   "bench square --size 16 --backends openmp --iterations 3 --repeat 2 --no-ceilings "
                   "--tolerance 900 --old-binary " HDMBENCH_PROGRAM,
                   AllOf(HasSubstr("2+2"), HasSubstr("too few samples")));
}

TEST(CompareCommand, RefusesWhatItCannotUse) {
  const test::TemporaryFolder folder;
  const std::string old = results_of(folder, "old", 1.0).string();
  for (const auto& [arguments, reason] : std::vector<std::pair<std::string, std::string>>{
           {"--compare missing.json", "missing.json"},
           {"--with " + old, "--compare"},
           {"--old-binary " + old, "no program"},
           {"--compare " + old + " --with " + old + " --old-binary /bin/true", "excludes"},
           {"--compare " + old + " --old-binary /bin/false", "failed"}}) {
    test::expect_run(2, "bench " + arguments, HasSubstr(reason));
  }
}

} // namespace
} // namespace hdmbench::comparison
