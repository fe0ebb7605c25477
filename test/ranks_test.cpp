// Several processes against one: files byte for byte, every sweep bit by bit, errors that end all of them.
// Skipped where the build has no MPI.

#include "harness/ranks/elastic_share.hpp"
#include "harness/ranks/ranked_solution.hpp"
#include "harness/scene/scene_part.hpp"
#include "test/program.hpp"
#include "test/temporary_folder.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <tuple>

namespace hdmbench {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Root in a container, more ranks than processors.
const std::string launcher =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 '" HDMBENCH_MPIEXEC "' --oversubscribe ";

std::string on_ranks(int ranks) {
  return fmt::format("{}-n {}", launcher, ranks);
}

std::string bytes(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::size_t files_in(const fs::path& folder) {
  return fs::exists(folder) ? static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {})) : 0;
}

class RankProgram : public testing::Test {
protected:
  void SetUp() override {
    if (std::string_view(HDMBENCH_MPIEXEC).empty()) {
      GTEST_SKIP() << "this build has no MPI (-DHDMBENCH_MPI=ON, libopenmpi-dev)";
    }
  }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  test::TemporaryFolder folder_;
};

TEST(ScenePart, HasTheValuesOfTheWhole) {
  constexpr Extent extent{61, 47};
  for (const char* const name : {"square", "circular", "circular-radial", "tie-rich", "random"}) {
    const Scene whole = load_scene(name, {.size = extent});
    for (const Rectangle part : {Rectangle{0, 0, 61, 47}, Rectangle{0, 0, 20, 12}, Rectangle{20, 12, 41, 35},
                                 Rectangle{0, 46, 61, 1}, Rectangle{60, 0, 1, 47}, Rectangle{}}) {
      const ScenePart found = load_scene_part(name, {.size = extent}, [&](Extent) { return part; });
      const Level expected = part_of(whole.full, part);
      EXPECT_EQ(found.scene.extent(), extent);
      EXPECT_EQ(found.full.modulus.values, expected.modulus.values) << name;
      EXPECT_EQ(found.full.inverse_modulus.values, expected.inverse_modulus.values) << name;
      EXPECT_EQ(found.full.target.x, expected.target.x) << name;
      EXPECT_EQ(found.full.target.y, expected.target.y) << name;
      EXPECT_EQ(found.full.confidence.x, expected.confidence.x) << name;
      EXPECT_EQ(found.full.confidence.y, expected.confidence.y) << name;
      ASSERT_EQ(found.start.has_value(), whole.start.has_value()) << name;
      if (whole.start) {
        EXPECT_EQ(found.start->x, part_of(*whole.start, part).x) << name;
      }
    }
  }
}

TEST(Sharing, GoesToFewerRanksWhereALevelIsSmall) {
  const Sharing sharing{.ranks = 7, .pieces = 6, .fewest_sites = 100};
  const auto pieces = [&](Extent extent) { return sharing(extent).cut.pieces.size(); };
  EXPECT_EQ(pieces({1, 1}), 1U);
  EXPECT_EQ(pieces({16, 16}), 2U);
  EXPECT_EQ(pieces({24, 24}), 5U);
  EXPECT_EQ(pieces({64, 64}), 6U);
  EXPECT_EQ(pieces({3, 900}), 6U);
  const Sharing finest{.ranks = 6, .pieces = 6, .fewest_sites = 1};
  EXPECT_EQ(finest({5, 5}).cut.pieces.size(), 4U) << "a piece has 4 sites along a cut, but for the last one";
  EXPECT_EQ(finest({5, 5}).owned[3], (Rectangle{4, 4, 1, 1}));
  EXPECT_EQ(finest({5, 5}).owned[5].extent().sites(), 0U) << "an idle rank";
}

/// Wide where messages are dear, narrow where sweeps are.
TEST(Sharing, ChoosesTheWidthOfHalosByTheirCosts) {
  constexpr Extent extent{1024, 1024};
  const auto width = [&](const HaloCosts& costs, int halo = 0) {
    return Sharing{.ranks = 2, .pieces = 2, .halo = halo, .costs = costs}(extent).cut.halo;
  };
  constexpr HaloCosts near{.site = 1e-9, .message = 1e-6, .byte = 1e-10, .rim = 1e-9};
  EXPECT_EQ(width(near), 8);
  constexpr HaloCosts far{.site = 1e-9, .message = 1e-3, .byte = 1e-10, .rim = 1e-9};
  EXPECT_GT(width(far), 16);
  constexpr HaloCosts whole_pieces{.site = 1e-9, .message = 1e-6, .byte = 1e-10, .piece = 1e-9};
  EXPECT_GT(width(whole_pieces), width(near));
  EXPECT_EQ(width(far, 12), 12) << "somebody has said it";
  constexpr HaloCosts never{.site = 1e-12, .message = 1.0};
  EXPECT_EQ(width(never), 64);
  const Sharing narrow{.ranks = 2, .pieces = 2, .fewest_sites = 1, .costs = never};
  EXPECT_EQ(narrow({40, 40}).cut.halo, 8) << "no wider than half of a piece";
  for (const HaloCosts& costs : {near, far, whole_pieces}) { // no other width is better by the same costs
    const Cut chosen = Sharing{.ranks = 2, .pieces = 2, .costs = costs}(extent).cut;
    const auto seconds = [&](const Cut& cut) {
      return static_cast<double>(cut.pieces.front().loaded.extent().sites()) * costs.site +
             renewal_seconds(costs, cut) / cut.halo;
    };
    for (const int other : {8, 16, 32, 64}) {
      EXPECT_LE(seconds(chosen), seconds(cut_image(extent, 2, other))) << other;
    }
  }
}

/// Cells of a part are whole on every level only where it ends one site after a multiple, or with the image.
TEST(ElasticSharing, CutsAtMultiplesOfTheCoarsening) {
  for (const Extent image : {Extent{61, 47}, Extent{130, 9}, Extent{200, 300}, Extent{33, 129}}) {
    for (const int ranks : {1, 2, 3, 4, 6}) {
      const ElasticShare share = share_elastic(image, {.ranks = ranks, .pieces = ranks, .fewest_sites = 1});
      const int granule = 1 << share.cut_levels();
      EXPECT_EQ(share.cut_levels() > 0, ranks > 1);
      for (int level = 0; level <= share.cut_levels(); ++level) {
        const Extent sites = share.levels[static_cast<std::size_t>(level)];
        std::size_t owned = 0;
        for (const Piece& piece : share.share(level).cut.pieces) {
          owned += piece.owned.extent().sites();
          EXPECT_EQ(intersection(piece.owned, piece.loaded), piece.owned);
          EXPECT_EQ(intersection(piece.loaded, all_of(sites)), piece.loaded);
          const Rectangle& part = piece.loaded;
          const int right = part.left + part.width;
          EXPECT_EQ(part.left % (granule >> level), 0);
          EXPECT_EQ(part.top % (granule >> level), 0);
          EXPECT_TRUE(right == sites.width || (right - 1) % (granule >> level) == 0) << right;
        }
        EXPECT_EQ(owned, sites.sites());
      }
    }
  }
}

TEST_F(RankProgram, WritesTheFileOfOneProcessByteForByte) {
  struct Case {
    const char* scene;
    const char* arguments;
    int ranks;
  };
  constexpr std::array cases{
      Case{"square", "--size 97x101", 2},
      Case{"random", "--size 45x31 --update coloured", 3},
      Case{"tie-rich", "--size 33x5", 4}, // one row on two of the ranks
      Case{"random", "--size 64x40 --steps fine --alignment center", 6},
      Case{"circular-radial", "--size 50 --stop still", 4},
      Case{"square", "--size 7x3 --update four-coloured", 6}, // four are idle
      Case{"random", "--size 61x47 --method closed-form", 4},
      Case{"random", "--size 33x47 --method closed-form --relaxation 1.8", 3},
      Case{"random", "--size 61x47 --method cascade", 4},
      Case{"circular", "--size 90x130 --method cascade --alignment center", 3},
      Case{"random", "--size 45x61 --method annealing --iterations 20 --seed 7", 3},
      Case{"tie-rich", "--size 20x33 --method annealing --iterations 8 --temperatures 2,0.1", 6}};
  for (const Case& one : cases) {
    const std::string run = fmt::format("run {} {} --output ", one.scene, one.arguments);
    test::expect_run(0, run + path("one") + " --backend scalar");
    test::expect_run(0, run + path("many") + " --backend openmp --sites-per-rank 1",
                     HasSubstr(fmt::format("on {} ranks (openmp)", one.ranks)), on_ranks(one.ranks));
    const std::string name = fmt::format("/{}.nrrd", one.scene);
    EXPECT_TRUE(bytes(path("one") + name) == bytes(path("many") + name)) << run << one.ranks << " ranks";
    EXPECT_EQ(files_in(path("many")), 1U);
    fs::remove_all(path("many"));
  }
}

/// multigrid and krylov; an image of 33 rows leaves one to the last rank, one of 7 x 3 leaves all but one
/// idle.
TEST_F(RankProgram, CyclesWriteTheFileOfOneProcess) {
  struct Case {
    const char* scene;
    const char* arguments;
    int ranks;
  };
  constexpr std::array cases{Case{"square", "--size 97x101 --method multigrid", 2},
                             Case{"random", "--size 20x33 --method krylov", 3},
                             Case{"tie-rich", "--size 33x5 --method multigrid", 4},
                             Case{"circular-radial", "--size 65x129 --method multigrid --iterations 6", 4},
                             Case{"random", "--size 64x140 --method krylov --alignment center", 6},
                             Case{"square", "--size 7x3 --method krylov", 6}};
  for (const Case& one : cases) {
    const std::string run = fmt::format("run {} {} --output ", one.scene, one.arguments);
    test::expect_run(0, run + path("one") + " --backend scalar");
    test::expect_run(0, run + path("many") + " --backend openmp --sites-per-rank 1", testing::_,
                     on_ranks(one.ranks));
    const std::string name = fmt::format("/{}.nrrd", one.scene);
    EXPECT_TRUE(bytes(path("one") + name) == bytes(path("many") + name)) << run << one.ranks << " ranks";
    fs::remove_all(path("many"));
  }
}

/// Prescribed components and springs, on cells of all kinds.
constexpr const char* springs = R"(title = "springs and conditions"
size = [61, 47]
penalty = 100.0
[schedule]
iterations = 30
[random]
seed = 5
modulus = [1.0, 100.0]
displacement = 20.0
observed = 0.1
confidences = [0.25, 0.5, 1.0]
)";

TEST_F(RankProgram, ElasticFilesAreThoseOfOneProcess) {
  const std::string sprung = folder_.write("springs.toml", springs).string();
  struct Case {
    std::string scene;
    const char* arguments;
    int ranks;
  };
  const std::array cases{Case{"random", "--size 61x47 --method conjugate-gradients --iterations 2", 2},
                         Case{"square", "--size 97x101", 3},
                         Case{"circular-radial", "--size 33x129 --method sweeps --iterations 5", 4},
                         Case{"tie-rich", "--size 33x5", 4}, // one row on two of the ranks
                         Case{"random", "--size 66x50 --method full-multigrid --iterations 3", 6},
                         Case{sprung, "--method conjugate-gradients --iterations 2", 4},
                         Case{sprung, "--size 40x90 --method sweeps --iterations 4", 3},
                         Case{"square", "--size 7x3", 6}}; // all but one are idle
  for (const Case& one : cases) {
    const std::string run = fmt::format("run {} --energy elastic {} --output ", one.scene, one.arguments);
    test::expect_run(0, run + path("one") + " --backend scalar");
    test::expect_run(0, run + path("many") + " --backend openmp --sites-per-rank 1", testing::_,
                     on_ranks(one.ranks));
    const std::string name = fs::path(one.scene).stem().string() + ".nrrd";
    const std::string expected = bytes(path("one/" + name));
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(expected == bytes(path("many/" + name))) << run << one.ranks << " ranks";
    fs::remove_all(path("many"));
  }
  test::expect_run(0, "run random --size 40x30 --energy elastic --backend scalar --output " + path("one"));
  test::expect_run(0,
                   "run random --size 40x30 --energy elastic --sites-per-rank 1 --output " + path("many") +
                       " --backend openmp+vulkan-compute+gl-fragment+gl-compute",
                   testing::_, on_ranks(4));
  EXPECT_TRUE(bytes(path("one/random.nrrd")) == bytes(path("many/random.nrrd")));
}

TEST_F(RankProgram, DevicesNamesThoseOfEachRank) {
  const test::Outcome outcome =
      test::expect_run(0, "devices", AllOf(HasSubstr("openmp"), HasSubstr("by-rank")), on_ranks(2));
  EXPECT_THAT(outcome.output, testing::ContainsRegex("\n +1 .*openmp"));
}

TEST_F(RankProgram, MixedBackendsHaveTheSameBits) {
  test::expect_run(0, "run circular --size 48x40 --backend scalar --output " + path("one"));
  test::expect_run(0,
                   "run circular --size 48x40 --backend openmp+vulkan-compute+gl-fragment --sites-per-rank 1 "
                   "--device by-rank --output " +
                       path("many") + " --json " + path("run.json"),
                   HasSubstr("vulkan-compute"), on_ranks(3));
  EXPECT_TRUE(bytes(path("one/circular.nrrd")) == bytes(path("many/circular.nrrd")));
  const nlohmann::json row = test::read_json(path("run.json"))["results"][0];
  EXPECT_EQ(row["ranks"], 3);
  EXPECT_EQ(row["by_rank"][1]["backend"], "vulkan-compute");
  EXPECT_EQ(row["by_rank"][2]["backend"], "gl-fragment");
}

TEST_F(RankProgram, AnyWidthOfHalosHasTheSameBits) {
  struct Case {
    const char* arguments;
    int ranks;
    std::vector<int> widths; ///< of the coarsest cut level
  };
  const std::array cases{
      Case{"random --size 97x61 --backend openmp", 3, {4, 8, 20, 64}},
      Case{"square --size 90x130 --update coloured --backend openmp+scalar", 4, {4, 16}},
      Case{"random --size 61x90 --energy elastic --method conjugate-gradients --iterations 2", 4, {2, 4, 8}}};
  for (const Case& one : cases) {
    const std::string run = fmt::format("run {} --output ", one.arguments);
    const std::string name = fmt::format("/{}.nrrd", std::string(one.arguments).substr(0, 6));
    std::string alone = run;
    if (const std::size_t mixed = alone.find("openmp+"); mixed != std::string::npos) {
      alone.erase(mixed, std::string_view("openmp+").size());
    }
    test::expect_run(0, alone + path("one"));
    const std::string expected = bytes(path("one") + name);
    ASSERT_FALSE(expected.empty());
    for (const int width : one.widths) {
      const std::string command = fmt::format("{}{} --sites-per-rank 64 --halo {} --json {}", run,
                                              path("many"), width, path("run.json"));
      test::expect_run(0, command, testing::_, on_ranks(one.ranks));
      EXPECT_TRUE(expected == bytes(path("many") + name)) << command << ", " << one.ranks << " ranks";
      const nlohmann::json row = test::read_json(path("run.json"))["results"][0];
      EXPECT_FALSE(row.contains("halo_costs")) << "nothing was measured";
      int narrowest = 0;
      for (const nlohmann::json& level : row["shared_levels"]) {
        const int halo = level["halo"];
        narrowest = narrowest == 0 || halo == 0 ? std::max(narrowest, halo) : std::min(narrowest, halo);
      }
      EXPECT_EQ(narrowest, width) << command;
    }
  }
}

/// The formula in harness/ranks/README.md, with widths that are chosen and others.
TEST_F(RankProgram, SendsAsManyMessagesAndBytesAsTheFormulaSays) {
  for (const auto& [size, ranks, width] : {std::tuple{"300x260", 2, 0}, std::tuple{"256x256", 4, 0},
                                           std::tuple{"256x256", 4, 12}, std::tuple{"96x400", 6, 4}}) {
    test::expect_run(0,
                     fmt::format("run square --size {} --sites-per-rank 1024 --halo {} --output {} --json {}",
                                 size, width, path("out"), path("run.json")),
                     testing::Conditional(width == 0, HasSubstr("widths of halos by measurement"),
                                          Not(HasSubstr("widths of halos"))),
                     on_ranks(ranks));
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

/// The same of the methods that go between levels: halos are renewed once a cycle of a level, twice a Krylov
/// step, and once for the weights of a restriction.
TEST_F(RankProgram, SendsForCyclesWhatTheFormulaSays) {
  struct Case {
    const char* arguments;
    int ranks;
    int of_image; ///< renewals
  };
  constexpr int halo = 12;
  for (const Case& one : {Case{"--size 100x260 --method multigrid --iterations 3", 2, 1 + 3},
                          Case{"--size 64x256 --method krylov --iterations 2", 4, 1 + 2 * 2}}) {
    test::expect_run(0,
                     fmt::format("run square {} --sites-per-rank 1 --output {} --json {}", one.arguments,
                                 path("out"), path("run.json")),
                     testing::_, on_ranks(one.ranks));
    const nlohmann::json levels = test::read_json(path("run.json"))["results"][0]["shared_levels"];
    int shared = 0;
    for (const nlohmann::json& level : levels) {
      const auto number = [&](const char* key) { return level[key].get<std::int64_t>(); };
      const std::int64_t cuts = number("rows") - 1;
      EXPECT_EQ(number("columns"), 1) << level;
      EXPECT_EQ(number("renewals"), cuts == 0 ? 0 : level == levels.back() ? one.of_image : 1 + 1) << level;
      if (number("height") / number("rows") >= halo + 4) { // else halos reach beyond the next rank
        EXPECT_EQ(number("messages"), number("renewals") * 2 * cuts) << level;
        EXPECT_EQ(number("bytes"), number("renewals") * 8 * number("width") * 2 * halo * cuts) << level;
        shared += cuts > 0 ? 1 : 0;
      }
    }
    EXPECT_GT(shared, 1) << one.arguments;
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
                     testing::_, on_ranks(ranks));
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

TEST_F(RankProgram, VerifyComparesEverySweepOnEveryNumberOfRanks) {
  for (const int ranks : {2, 6}) {
    test::expect_run(0,
                     "verify square random --size 21x13 --backends scalar,openmp --iterations 12 --json " +
                         path("verify.json"),
                     AllOf(HasSubstr(fmt::format("openmp on {} ranks", ranks)), HasSubstr("0 disagree")),
                     on_ranks(ranks));
    const nlohmann::json results = test::read_json(path("verify.json"))["results"];
    std::vector<int> counts(7);
    for (const nlohmann::json& row : results) {
      EXPECT_EQ(row["sites_differing"], 0) << row;
      EXPECT_EQ(row["counts_differing"], 0) << row;
      EXPECT_TRUE(row["verdict"] == "agree" || row["mode"] == "active")
          << row; // where nothing is ever at rest
      ++counts.at(row["ranks"].get<std::size_t>());
    }
    for (int i = 1; i <= ranks; ++i) {
      EXPECT_GT(counts[static_cast<std::size_t>(i)], 0) << i;
    }
  }
  const std::string sprung = folder_.write("springs.toml", springs).string();
  test::expect_run(
      0,
      "verify random " + sprung +
          " --size 45x31 --energy elastic --method conjugate-gradients --iterations 1 --backends "
          "scalar,openmp",
      AllOf(HasSubstr("openmp on 6 ranks"), HasSubstr("48 comparisons with scalar agree to the "
                                                      "bit, 0 are certified, 0 disagree")),
      on_ranks(6));
  test::expect_run(
      0, "verify random --size 21x13 --backends openmp+vulkan-compute,gl-fragment --iterations 8",
      AllOf(HasSubstr("openmp+vulkan-compute on 3 ranks"), HasSubstr("0 disagree")), on_ranks(3));
  test::expect_run(0, "verify random --size 21x13 --backends openmp --methods closed-form,sequential --quick",
                   AllOf(HasSubstr("sequential, is left out"), HasSubstr("0 disagree")), on_ranks(2));
  // Sweep by sweep, and as a whole: 2 modes of annealing, 3 of cascade, 1 of the others, 2 backends, 4 ranks.
  test::expect_run(
      0,
      "verify random --size 23x45 --backends scalar,openmp --iterations 3 "
      "--methods annealing,cascade,multigrid,krylov",
      AllOf(HasSubstr("56 comparisons with scalar agree to the bit, 0 are certified, 0 disagree"),
            HasSubstr("openmp on 4 ranks")),
      on_ranks(4));
}

TEST_F(RankProgram, PlantedFaultsAreSeen) {
  test::expect_run(0, "faults",
                   AllOf(HasSubstr("12 of 12 planted faults caught, 6 of 6 controls let through"),
                         HasSubstr("elastic-stale-halo"), HasSubstr("elastic-sum-in-rank-order"),
                         HasSubstr("krylov-sum-in-rank-order")),
                   on_ranks(2));
  test::expect_run(0, "faults",
                   AllOf(HasSubstr("16 of 16 planted faults caught, 6 of 6 controls let through"),
                         HasSubstr("swapped-neighbours")),
                   on_ranks(4));
}

/// No field is the only fixed point.
constexpr const char* unobserved = R"(title = "nothing is known"
size = [40, 40]
[random]
seed = 1
modulus = [1.0, 2.0]
displacement = 1.0
observed = 0.0
)";

TEST_F(RankProgram, ErrorsEndAllWithStatusTwoAndOneSentence) {
  const auto expect_refusal = [&](const std::string& arguments, const char* words) {
    const test::Outcome outcome = test::expect_run(2, arguments, HasSubstr(words), on_ranks(3));
    const std::size_t first = outcome.output.find(words);
    EXPECT_EQ(outcome.output.find(words, first + 1), std::string::npos) << "said twice: " << outcome.output;
  };
  const std::string out = " --output " + path("out");
  expect_refusal("run nowhere" + out, "there is no scene and no file \"nowhere\"");
  expect_refusal("run square --nonsense" + out, "--nonsense");
  expect_refusal("run square --size 20 --method sequential --backend scalar" + out,
                 "each of whose sweeps crosses the image site by site, runs on one rank");
  expect_refusal("run " + folder_.write("free.toml", unobserved).string() + " --method multigrid" + out,
                 "no site has a known displacement in x");
  expect_refusal("bench --scaling strong square --size 64 --method multigrid",
                 "bench --scaling models icm and closed-form, not multigrid");
  expect_refusal("run square --size 20 --halo 6" + out, "--halo 6: a multiple of 4");
  expect_refusal("run square --size 20 --energy elastic --halo 3" + out, "a multiple of 2");
  expect_refusal("run square --size 20 --method multigrid --halo 8" + out,
                 "--halo 8: a halo of 12 is as wide as");
  expect_refusal("run square --size 20 --energy elastic --stride 4" + out,
                 "--stride, which makes a small image");
  expect_refusal("run square --size 20 --energy elastic --robust 1" + out, "--robust, which solves again");
  expect_refusal("run tie-rich --size 1x20 --energy elastic" + out, "at least 2 x 2 pixels");
  expect_refusal("devices --measure", "tell of one process");
  expect_refusal("run square --size 20 --backend openmp+none" + out, "there is no backend \"none\"");
  expect_refusal("golden", "golden runs in one process");
  expect_refusal("bench", "bench --scaling strong");
  expect_refusal("run square --size 20 --output " + folder_.write("file", "").string(),
                 "is a file, not a folder");
  EXPECT_EQ(files_in(path("out")), 0U);
}

/// Two ranks, of which the second one is started by these words of a shell: "$0" "$@" are the program's.
std::string with_second(const std::string& arguments, const std::string& words) {
  return launcher + "-n 1 '" HDMBENCH_PROGRAM "' " + arguments + " : -n 1 sh -c '" + words + "'";
}

TEST_F(RankProgram, AnErrorOfOneRankHasItsWords) {
  const std::string run = "run square --size 2000 --output " + path("out");
  test::expect_run(2, run, HasSubstr("rank 1: out of memory"),
                   with_second(run, "ulimit -v 200000; exec \"$0\" \"$@\""));
  EXPECT_EQ(files_in(path("out")), 0U);
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
                       testing::_, on_ranks(ranks));
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
      launcher + "-n 4 sh -c 'ulimit -v 650000; exec \"$0\" \"$@\"'"; // 350 MB of it are MPI's
  test::expect_run(2, run + "--sites-per-rank 1000000000 --output " + path("many"),
                   HasSubstr("out of memory"), limited);
  test::expect_run(0, run + "--output " + path("many"), HasSubstr("on 4 ranks"), limited);
  test::expect_run(0, run + "--backend openmp --output " + path("one"));
  EXPECT_TRUE(bytes(path("one/square.nrrd")) == bytes(path("many/square.nrrd")));
}

TEST_F(RankProgram, AKilledRankIsNamedAndEndsAll) {
  const std::string run = "run square --size 1000 --iterations 1000000 --output " + path("out");
  test::expect_run(2, run, HasSubstr("rank 1 was ended by signal 9 (Killed)"),
                   with_second(run,
                               "\"$0\" \"$@\" & watching=$!; sleep 1; "
                               "kill -9 $(cat /proc/$watching/task/$watching/children); wait $watching"));
  EXPECT_EQ(files_in(path("out")), 0U);
}

TEST_F(RankProgram, AFileThatCannotBeWrittenLeavesNothing) {
  const std::string run = "run square --size 1000 --iterations 1 --output " + path("out");
  const std::string small = "ulimit -f 4000; exec \"$0\" \"$@\""; // half of the file
  test::expect_run(2, run, HasSubstr("File too large"), launcher + "-n 2 sh -c '" + small + "'");
  EXPECT_EQ(files_in(path("out")), 0U);
  test::expect_run(2, run, HasSubstr("(rank 1)"), with_second(run, small));
  EXPECT_EQ(files_in(path("out")), 0U);
}

TEST_F(RankProgram, ScalingIsMeasuredAndModelled) {
  test::expect_run(0, "bench --scaling strong square --size 256 --repeat 1 --json " + path("scaling.json"),
                   AllOf(HasSubstr("modelled"), HasSubstr("Modelled, not measured: 65536 x 65536")),
                   on_ranks(2));
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
  test::expect_run(0, elastic + path("elastic.json"), Not(HasSubstr("Modelled, not measured")), on_ranks(2));
  const nlohmann::json of_elastic = test::read_json(path("elastic.json"))["results"];
  ASSERT_EQ(of_elastic.size(), 2U);
  EXPECT_EQ(of_elastic[0]["energy"], "elastic");
  EXPECT_TRUE(of_elastic[0]["modelled_seconds"].is_null());
  EXPECT_EQ(of_elastic[0]["messages"], 0);
  EXPECT_GT(of_elastic[1]["messages"], 0);
  test::expect_run(0, "bench --scaling weak square --size 192 --repeat 1", HasSubstr("weak scaling"),
                   on_ranks(2));
}

TEST_F(RankProgram, OneProcessStartedByMpirunIsAlone) {
  test::expect_run(0, "run square --size 20 --output " + path("out"), HasSubstr("square-before.png"),
                   on_ranks(1));
  test::expect_run(0, "--version", testing::_, on_ranks(2));
}

} // namespace
} // namespace hdmbench
