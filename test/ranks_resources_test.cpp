// What ranks take: messages, bytes, memory, seconds. Skipped where the build has no MPI.

#include "test/ranks_program.hpp"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

namespace hdmbench {
namespace {

using test::RankProgram;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// The formula in harness/ranks/README.md, with widths that are chosen and others.
TEST_F(RankProgram, SendsAsManyMessagesAndBytesAsTheFormulaSays) {
  for (const auto& [size, ranks, width] : {std::tuple{"300x260", 2, 0}, std::tuple{"256x256", 4, 0},
                                           std::tuple{"256x256", 4, 12}, std::tuple{"96x400", 6, 4}}) {
    test::expect_run(0,
                     fmt::format("run square --size {} --sites-per-rank 1024 --halo {} --output {} --json {}",
                                 size, width, path("out"), path("run.json")),
                     testing::Conditional(width == 0, HasSubstr("widths of halos by measurement"),
                                          Not(HasSubstr("widths of halos"))),
                     test::on_ranks(ranks));
    const nlohmann::json row = test::read_json(path("run.json"))["results"][0];
    EXPECT_EQ(row.contains("halo_costs"), width == 0);
    std::int64_t shared = 0;
    for (const nlohmann::json& level : row["shared_levels"]) {
      const auto number = [&](const char* key) { return level[key].get<std::int64_t>(); };
      const std::int64_t columns = number("columns");
      const std::int64_t rows = number("rows");
      const std::int64_t halo = number("halo");
      if (columns * rows == 1) {
        EXPECT_EQ(number("messages"), 0);
        continue;
      }
      ++shared;
      const std::int64_t renewals = (number("sweeps") + halo - 1) / halo - 1;
      const std::int64_t neighbours =
          2 * ((columns - 1) * rows + columns * (rows - 1) + 2 * (columns - 1) * (rows - 1));
      const std::int64_t sites =
          (number("width") + 2 * halo * (columns - 1)) * (number("height") + 2 * halo * (rows - 1)) -
          number("width") * number("height");
      EXPECT_EQ(number("renewals"), renewals) << level;
      EXPECT_EQ(number("messages"), renewals * neighbours) << level;
      EXPECT_EQ(number("bytes"), renewals * sites * 8) << level;
    }
    EXPECT_GT(shared, 1) << size;
  }
}

/// The same of the elastic energy. Below the cut levels, loads go to the first rank and corrections come.
TEST_F(RankProgram, SendsForTheElasticEnergyWhatTheFormulaSays) {
  for (const auto& [size, ranks] :
       {std::pair{"300x260", 2}, std::pair{"256x256", 4}, std::pair{"96x400", 6}}) {
    test::expect_run(0,
                     fmt::format("run square --energy elastic --method conjugate-gradients --iterations 2 "
                                 "--size {} --sites-per-rank 1024 --output {} --json {}",
                                 size, path("out"), path("run.json")),
                     testing::_, test::on_ranks(ranks));
    const nlohmann::json row = test::read_json(path("run.json"))["results"][0];
    std::int64_t shared = 0;
    std::int64_t in_one_piece = 0;
    for (const nlohmann::json& level : row["shared_levels"]) {
      const auto number = [&](const char* key) { return level[key].get<std::int64_t>(); };
      const std::int64_t columns = number("columns");
      const std::int64_t rows = number("rows");
      const std::int64_t both_halos = 2 * number("halo") + 1;
      const std::int64_t sites = number("width") * number("height");
      if (columns * rows == 1) {
        EXPECT_EQ(number("messages"), number("renewals") * (ranks - 1)) << level;
        EXPECT_LE(number("bytes"), number("renewals") * sites * 2 * 8) << level;
        in_one_piece += number("messages") > 0 ? 1 : 0;
        continue;
      }
      ++shared;
      const std::int64_t neighbours =
          2 * ((columns - 1) * rows + columns * (rows - 1) + 2 * (columns - 1) * (rows - 1));
      const std::int64_t halos =
          (number("width") + both_halos * (columns - 1)) * (number("height") + both_halos * (rows - 1)) -
          sites;
      EXPECT_GT(number("renewals"), 0) << level;
      EXPECT_EQ(number("messages"), number("renewals") * neighbours) << level;
      EXPECT_EQ(number("bytes"), number("renewals") * halos * 8) << level;
    }
    EXPECT_GT(shared, 1) << size;
    EXPECT_EQ(in_one_piece, 1) << size;
  }
}

/// As in issue and README: 1.2 times its share and 64 MB; halos are in the 64 MB here.
TEST_F(RankProgram, ARankHoldsItsShare) {
  constexpr int ranks = 4;
  for (const char* const arguments :
       {"--size 2048 --iterations 4",
        "--size 1400 --energy elastic --method full-multigrid --iterations 1"}) {
    const auto peaks = [&](const std::string& more) {
      test::expect_run(0,
                       fmt::format("run square {} {} --output {} --json {}", arguments, more, path("out"),
                                   path("run.json")),
                       testing::_, test::on_ranks(ranks));
      const nlohmann::json row = test::read_json(path("run.json"))["results"][0];
      std::vector<double> bytes;
      for (const nlohmann::json& rank : row["by_rank"]) {
        bytes.push_back(rank["peak_memory"]);
      }
      return bytes;
    };
    const double whole = peaks("--sites-per-rank 1000000000").at(0); // the first rank has all levels
    const double most = 1.2 * whole / ranks + 64e6;
    EXPECT_LT(most, whole) << "this size is too small to tell: " << arguments;
    for (const double peak : peaks("")) {
      EXPECT_LE(peak, most) << arguments << ", one rank takes " << whole;
    }
  }
}

TEST_F(RankProgram, ElasticSizesBeyondTheMemoryOfOneRankAreSolvedByFour) {
  const std::string run = "run square --size 2000 --energy elastic --method full-multigrid --iterations 1 ";
  const std::string limited =
      test::mpirun + "-n 4 sh -c 'ulimit -v 650000; exec \"$0\" \"$@\"'"; // 350 MB of it are MPI's
  test::expect_run(2, run + "--sites-per-rank 1000000000 --output " + path("many"),
                   HasSubstr("out of memory"), limited);
  test::expect_run(0, run + "--output " + path("many"), HasSubstr("on 4 ranks"), limited);
  test::expect_run(0, run + "--backend openmp --output " + path("one"));
  EXPECT_TRUE(test::bytes(path("one/square.nrrd")) == test::bytes(path("many/square.nrrd")));
}

TEST_F(RankProgram, ScalingIsMeasuredAndModelled) {
  test::expect_run(0, "bench --scaling strong square --size 256 --repeat 1 --json " + path("scaling.json"),
                   AllOf(HasSubstr("modelled"), HasSubstr("Modelled, not measured: 65536 x 65536")),
                   test::on_ranks(2));
  const nlohmann::json rows = test::read_json(path("scaling.json"))["results"];
  ASSERT_EQ(rows.size(), 2U + 15U); // measured, modelled
  EXPECT_EQ(rows[0]["messages"], 0);
  EXPECT_GT(rows[1]["messages"], 0);
  EXPECT_EQ(rows[1]["seconds"].size(), 1U);
  double before = rows[2]["modelled_seconds"];
  EXPECT_GT(before, rows[1]["modelled_seconds"]);
  for (std::size_t i = 3; i < 7; ++i) { // up to 16 ranks a large image scales
    EXPECT_LT(rows[i]["modelled_seconds"], before);
    before = rows[i]["modelled_seconds"];
  }
  const std::string elastic =
      "bench --scaling strong square --size 160 --energy elastic --method full-multigrid --repeat 1 --json ";
  test::expect_run(0, elastic + path("elastic.json"), Not(HasSubstr("Modelled, not measured")),
                   test::on_ranks(2));
  const nlohmann::json of_elastic = test::read_json(path("elastic.json"))["results"];
  ASSERT_EQ(of_elastic.size(), 2U);
  EXPECT_EQ(of_elastic[0]["energy"], "elastic");
  EXPECT_TRUE(of_elastic[0]["modelled_seconds"].is_null());
  EXPECT_EQ(of_elastic[0]["messages"], 0);
  EXPECT_GT(of_elastic[1]["messages"], 0);
  test::expect_run(0, "bench --scaling weak square --size 192 --repeat 1", HasSubstr("weak scaling"),
                   test::on_ranks(2));
}

} // namespace
} // namespace hdmbench
