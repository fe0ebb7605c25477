// Several processes against one: files byte for byte, every sweep bit by bit, errors that end all of them.
// Skipped where the build has no MPI.

#include "harness/scene/method.hpp"
#include "harness/scene/scene.hpp"
#include "test/files.hpp"
#include "test/program.hpp"

namespace hdmbench {
namespace {

/// Before the program: mpirun for root in a container, with more ranks than processors. Without the search
/// for network cards, and without the second between SIGTERM and SIGKILL: these take longer than most runs.
/// mpirun's hwloc is not to ask OpenCL's drivers, of which PoCL aborts it where there is no /sys.
const std::string mpirun =
    "HWLOC_COMPONENTS=-opencl OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_pml=ob1 "
    "OMPI_MCA_btl=self,vader,tcp "
    "OMPI_MCA_odls_base_sigkill_timeout=0 '" HDMBENCH_MPIEXEC "' --oversubscribe ";

std::string on_ranks(int ranks) {
  return fmt::format("{}-n {}", mpirun, ranks);
}

/// A scene that one process and several are to solve alike.
struct SharedRun {
  std::string scene;
  std::string arguments;
  int ranks;
  std::string backends = "openmp";
  std::string on_ranks = "--sites-per-rank 1"; ///< down to the smallest pieces
};

/// Several processes of the program. Skipped where the build has no MPI.
class RankProgram : public testing::Test {
protected:
  void SetUp() override {
    if (std::string_view(HDMBENCH_MPIEXEC).empty()) {
      GTEST_SKIP() << "this build has no MPI (-DHDMBENCH_MPI=ON, libopenmpi-dev)";
    }
  }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  /// By scalar in one process, and on ranks: field and pictures.
  void expect_files_of_one_process(const std::vector<SharedRun>& runs) {
    for (const SharedRun& one : runs) {
      const std::string run = fmt::format("run {} {} --output ", one.scene, one.arguments);
      test::expect_run(0, run + path("one") + " --backend scalar");
      test::expect_run(0, fmt::format("{}{} {} --backend {}", run, path("many"), one.on_ranks, one.backends),
                       HasSubstr(fmt::format("{} on {} ranks", one.backends, one.ranks)),
                       on_ranks(one.ranks));
      const auto expected = test::files_in(path("one"));
      EXPECT_FALSE(expected.empty()) << run;
      EXPECT_TRUE(expected == test::files_in(path("many"))) << run << one.ranks << " ranks";
      fs::remove_all(path("one"));
      fs::remove_all(path("many"));
    }
  }

  test::TemporaryFolder folder_;
};

TEST_F(RankProgram, WritesTheFileOfOneProcessByteForByte) {
  expect_files_of_one_process({{"square", "--size 97x101", 2},
                               {"random", "--size 45x31 --update coloured", 3},
                               {"tie-rich", "--size 33x5", 4}, // one row on two of the ranks
                               {"random", "--size 64x40 --steps fine --alignment center", 6},
                               {"circular-radial", "--size 50 --stop still", 4},
                               {"square", "--size 7x3 --update four-coloured", 6}, // four are idle
                               {"random", "--size 33x47 --method closed-form --relaxation 1.8", 3},
                               {"circular", "--size 90x130 --method cascade --alignment center", 3},
                               {"random", "--size 45x61 --method annealing --iterations 20 --seed 7", 3}});
}

TEST_F(RankProgram, VolumesAreThoseOfOneProcess) {
  const fs::path loads = folder_.write(
      "loads.toml", "energy = \"elastic\"\nsize = [17, 13, 25]\nspacing = [1.0, 1.0, 5.0]\n[[shape]]\n"
                    "kind = \"everything\"\nlabel = 1\n[[tissue]]\nlabel = 1\nmodulus = 0.003\ngray = 9\n"
                    "density = 1000\n[[condition]]\nwhere = \"front\"\ndx = 0\ndy = 0\ndz = 0\n"
                    "[[load]]\ngravity = [2.0, 0.0, 9.81]\n");
  const fs::path laws = folder_.write(
      "laws.toml", "energy = \"elastic\"\nlaw = \"neo-hookean\"\nsize = [17, 13, 25]\n[[shape]]\n"
                   "kind = \"everything\"\nlabel = 1\n[[tissue]]\nlabel = 1\nmodulus = 0.003\ngray = 9\n"
                   "[[condition]]\nwhere = \"front\"\ndx = 0\ndy = 0\ndz = 0\n"
                   "[[condition]]\nwhere = \"back\"\ndx = 2\ndy = 0\ndz = 5\n");
  expect_files_of_one_process(
      {{"ball", "--size 9x30x22", 6},
       {"cube", "--size 5x7x33 --update coloured", 4}, // layers: the last one has a slice more
       {"cube", "--size 13x12x9 --method annealing --iterations 20 --seed 7", 3},
       {"ball", "--size 33x18x27 --energy elastic", 4},
       {"random", "--size 20x19x36 --energy elastic --method conjugate-gradients --iterations 2", 6},
       {loads.string(), "", 3},
       {laws.string(), "", 2},
       {"cube", "--size 12x13x25", 3, "openmp+opencl+vulkan-compute"},
       {"ball", "--size 17x13x25 --energy elastic", 3, "openmp+vulkan-compute+gl-compute"}});
}

/// Energies, integrations and dimensions, each with each, as far as scenes have them; and springs beside
/// prescribed components, at a Poisson's ratio where integrations differ much.
TEST_F(RankProgram, EveryEnergyIntegrationAndDimensionIsThatOfOneProcess) {
  int cut = 0; // fields that another integration changes
  for (const std::string_view energy : energy_names()) {
    for (const std::string_view integration : integration_names) {
      for (const bool is_volume : {false, true}) {
        const bool is_full = integration == integration_names.front();
        if (!is_full && !is_volume) { // a sheet does not lock
          continue;
        }
        const std::string scene =
            folder_
                .write(
                    fmt::format("{}-{}.toml", energy, integration),
                    fmt::format("size = {}\nenergy = \"{}\"\npoisson = 0.45\n{}[schedule]\niterations = 4\n"
                                "[random]\nseed = 5\nmodulus = [1.0, 100.0]\ndisplacement = 5.0\n"
                                "observed = 0.1\nconfidences = [0.25, 0.5, 1.0]\n",
                                is_volume ? "[9, 13, 18]" : "[37, 30]", energy,
                                is_volume ? fmt::format("integration = \"{}\"\n", integration) : ""))
                .string();
        expect_files_of_one_process({{scene, "", 3}});
        cut += is_full ? 0 : 1;
      }
    }
  }
  EXPECT_GT(cut, 0);
}

TEST_F(RankProgram, AFieldLiesWhereTheImageOfTheSceneDoes) {
  (void)folder_.write("labels.nrrd",
                      "NRRD0004\ntype: uchar\ndimension: 2\nspace dimension: 2\nsizes: 20 17\nencoding: raw\n"
                      "space directions: (0,2) (-2,0)\nspace origin: (-70,33)\n\n" +
                          std::string(200, '\0') + std::string(140, '\1'));
  const std::string placed =
      folder_
          .write("placed.toml",
                 "[image]\nlabels = \"labels.nrrd\"\n[[tissue]]\nlabel = 0\nmodulus = 1.0\n"
                 "[[tissue]]\nlabel = 1\nmodulus = 3.0\n[[condition]]\nwhere = \"left\"\ndx = 3.0\n"
                 "dy = 0.0\n")
          .string();
  expect_files_of_one_process({{placed, "", 3}, {placed, "--energy elastic --size 40x34", 4}});
  test::expect_run(0, "run " + placed + " --size 40x34 --output " + path("two"), testing::_, on_ranks(2));
  EXPECT_THAT(content(path("two/placed.nrrd")), HasSubstr("space directions: none (0,1,0) (-1,0,0) (0,0,1)"));
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
  std::string only_springs = springs; // and moduli whose squares float cannot hold
  only_springs.replace(only_springs.find("0.5, 1.0]"), 9, "1e-5]");
  only_springs.replace(only_springs.find("[1.0, 100.0]"), 12, "[1e20, 1e22]");
  const std::string weak = folder_.write("weak.toml", only_springs).string();
  std::vector<SharedRun> runs{{"random", "--size 61x47 --method conjugate-gradients --iterations 2", 2},
                              {"square", "--size 97x101", 3},
                              {"circular-radial", "--size 33x129 --method sweeps --iterations 5", 4},
                              {"tie-rich", "--size 33x5", 4}, // one row on two of the ranks
                              {"random", "--size 66x50 --method full-multigrid --iterations 3", 6},
                              {sprung, "--method conjugate-gradients --iterations 2", 4},
                              {weak, "--method full-multigrid", 4},
                              {"square", "--size 7x3", 6}, // all but one are idle
                              {"random", "--size 40x30", 4, "openmp+vulkan-compute+gl-fragment+gl-compute"}};
  for (SharedRun& run : runs) {
    run.arguments += " --energy elastic";
  }
  expect_files_of_one_process(runs);
}

/// The first rank has coarse levels alone, behind levels that are cut and that it does not need: devices take
/// coarse levels together.
TEST_F(RankProgram, DevicesTakeTheCoarseLevelsOfManyCutOnes) {
  for (const std::string_view backend : {"opencl", "gl-compute", "vulkan-compute"}) {
    for (const std::string_view fewest : {"--sites-per-rank 64", "--sites-per-rank 300"}) {
      expect_files_of_one_process(
          {{"square", "--size 64x64 --energy elastic", 2, std::string(backend), std::string(fewest)},
           {"ball", "--size 24x24x20 --energy elastic", 2, std::string(backend), std::string(fewest)}});
    }
  }
}

TEST_F(RankProgram, DevicesNamesThoseOfEachRank) {
  const test::Outcome outcome =
      test::expect_run(0, "devices", AllOf(HasSubstr("openmp"), HasSubstr("by-rank")), on_ranks(2));
  EXPECT_THAT(outcome.output, testing::ContainsRegex("\n +1 .*openmp"));
}

TEST_F(RankProgram, MixedBackendsHaveTheSameBits) {
  expect_files_of_one_process({{"circular", "--size 48x40", 3, "openmp+vulkan-compute+gl-fragment",
                                "--sites-per-rank 1 --device by-rank --json " + path("run.json")}});
  const nlohmann::json row = test::read_json(path("run.json"))["results"][0];
  EXPECT_EQ(row["ranks"], 3);
  EXPECT_EQ(row["by_rank"][1]["backend"], "vulkan-compute");
  EXPECT_EQ(row["by_rank"][2]["backend"], "gl-fragment");
}

TEST_F(RankProgram, AnyWidthOfHalosHasTheSameBits) {
  for (const int width : {4, 20, 64}) {
    expect_files_of_one_process(
        {{"random", "--size 97x61", 3, "openmp", fmt::format("--sites-per-rank 64 --halo {}", width)}});
  }
  for (const int width : {2, 8}) {
    expect_files_of_one_process(
        {{"random", "--size 61x90 --energy elastic --method conjugate-gradients --iterations 2", 4, "openmp",
          fmt::format("--sites-per-rank 64 --halo {}", width)}});
  }
}

TEST_F(RankProgram, VerifyComparesEverySweepOnEveryNumberOfRanks) {
  test::expect_run(0,
                   "verify square random --size 21x13 --backends scalar,openmp --iterations 6 --json " +
                       path("verify.json"),
                   AllOf(HasSubstr("openmp on 6 ranks"), HasSubstr(" 0 disagree")), on_ranks(6));
  std::set<int> numbers;
  const nlohmann::json rows = test::read_json(path("verify.json"))["results"];
  for (const nlohmann::json& row : rows) {
    EXPECT_EQ(row["sites_differing"], 0) << row;
    EXPECT_EQ(row["counts_differing"], 0) << row;
    EXPECT_TRUE(row["verdict"] == "agree" || row["mode"] == "active") << row; // where nothing is ever at rest
    numbers.insert(row["ranks"].get<int>());
  }
  EXPECT_EQ(numbers, (std::set{1, 2, 3, 4, 5, 6}));
  const std::string sprung = folder_.write("springs.toml", springs).string();
  const std::string selective =
      folder_
          .write("selective.toml", "size = [9, 10, 14]\nenergy = \"elastic\"\npoisson = 0.45\n"
                                   "integration = \"selective-reduced\"\n[random]\nseed = 5\n"
                                   "modulus = [1.0, 9.0]\ndisplacement = 5.0\nobserved = 0.1\n")
          .string();
  for (const auto& [arguments, ranks, says] :
       std::initializer_list<std::tuple<std::string, int, const char*>>{
           {"--quick --sizes 12x9 --backends openmp", 2, "sleeping-pieces, 124 x 120"}, // among all scenes
           {"random --size 45x31 --energy elastic --method conjugate-gradients --iterations 1 --backends "
            "scalar,openmp",
            4, " 0 are certified"},
           {"random --size 21x13 --backends openmp+vulkan-compute,gl-fragment --iterations 8", 3,
            "openmp+vulkan-compute on 3 ranks"},
           {"ball --size 9x10x21 --backends scalar,openmp --iterations 6 --methods icm", 4,
            "0 are certified"},
           {"ball --size 12x9x17 --energy elastic --backends openmp --quick", 3, " 0 are certified"},
           {"square --size 64x64 --energy elastic --backends gl-compute,opencl --quick", 2,
            " 0 are certified"},
           {selective + " --backends openmp --quick", 3, " 0 are certified"},
           {"random --size 21x13 --backends openmp --methods closed-form,sequential --quick", 2,
            "sequential, is left out"},
           {"random --size 23x45 --backends scalar,openmp --iterations 3 --methods annealing,cascade", 4,
            "0 are certified"},
           {sprung + " --energy elastic --method conjugate-gradients --iterations 1 --size 45x31 --backends "
                     "openmp",
            4, " 0 are certified, 0 disagree"}}) {
    test::expect_run(0, "verify " + arguments, AllOf(HasSubstr(says), HasSubstr(" 0 disagree")),
                     on_ranks(ranks));
  }
}

TEST_F(RankProgram, PlantedFaultsAreSeen) {
  test::expect_run(0, "faults",
                   AllOf(HasSubstr("13 of 13 planted faults caught, 5 of 5 controls let through"),
                         HasSubstr("swapped-neighbours"), HasSubstr("elastic-stale-halo"),
                         HasSubstr("elastic-sum-in-rank-order")),
                   on_ranks(4));
  for (const int ranks : {2, 4}) { // a backend that leaves tiles out and wakes them itself
    test::expect_run(0, "faults --backend openmp --faults sleeping-sound,asleep-after-renewal",
                     HasSubstr("1 of 1 planted faults caught, 1 of 1 controls let through"), on_ranks(ranks));
  }
}

TEST_F(RankProgram, ErrorsEndAllWithStatusTwoAndOneSentence) {
  const auto expect_refusal = [&](const std::string& arguments, const char* words) {
    const test::Outcome outcome = test::expect_run(2, arguments, HasSubstr(words), on_ranks(3));
    const std::size_t first = outcome.output.find(words);
    EXPECT_EQ(outcome.output.find(words, first + 1), std::string::npos) << "said twice: " << outcome.output;
    EXPECT_THAT(outcome.output, Not(HasSubstr("MPI_ABORT"))) << "all ranks met the same error";
  };
  const std::string out = " --output " + path("out");
  expect_refusal("run nowhere" + out, "there is no scene and no file \"nowhere\"");
  expect_refusal("run square --nonsense" + out, "--nonsense");
  expect_refusal("run square --size 20 --method sequential --backend scalar" + out,
                 "each of whose sweeps crosses the image site by site, runs on one rank");
  expect_refusal("run square --size 20 --halo 6" + out, "--halo 6: a multiple of 4");
  expect_refusal("run square --size 20 --energy elastic --halo 3" + out, "a multiple of 2");
  expect_refusal("run tie-rich --size 1x20 --energy elastic" + out, "at least 2 x 2 pixels");
  expect_refusal("run square --size 20 --backend openmp+none" + out, "there is no backend \"none\"");
  expect_refusal("golden", "golden runs in one process");
  expect_refusal("bench", "bench --scaling strong");
  expect_refusal("run square --size 20 --output " + folder_.write("file", "").string(),
                 "is a file, not a folder");
  expect_refusal("run square --size 20 --json " + path("nowhere/a.json"), "nowhere does not exist");
  EXPECT_TRUE(test::files_in(path("out")).empty());
}

/// Ranks of which the last one is started by these words of a shell: "$0" "$@" are the program's.
std::string with_last(const std::string& arguments, const std::string& words, int others = 1) {
  return fmt::format("{}-n {} '" HDMBENCH_PROGRAM "' {} : -n 1 sh -c '{}'", mpirun, others, arguments, words);
}

TEST_F(RankProgram, AnErrorOfOneRankHasItsWords) {
  const std::string run = "run square --size 2000 --output " + path("out");
  test::expect_run(2, run, HasSubstr("rank 1: out of memory"),
                   with_last(run, "ulimit -v 200000; exec \"$0\" \"$@\""));
  EXPECT_TRUE(test::files_in(path("out")).empty());
}

TEST_F(RankProgram, OtherScenesByTheSameNameAreRefused) {
  const std::string text = "size = {}\nenergy = \"{}\"\n[random]\nseed = 5\nmodulus = [1.0, {}]\n"
                           "displacement = 5.0\nobserved = 0.1\n[schedule]\niterations = {}\n";
  fs::create_directory(path("other"));
  const auto write = [&](const char* name, const auto&... values) {
    (void)folder_.write(name, fmt::format(fmt::runtime(text), values...));
  };
  write("a.toml", "[20, 20]", "hdm", "9.0", 4);
  for (const auto& [size, energy, modulus, iterations, says] :
       {std::tuple{"[24, 20]", "hdm", "9.0", 4, "rank 1 has a, 24 x 20"},
        {"[20, 20]", "elastic", "9.0", 4, "energy elastic"},
        {"[20, 20]", "hdm", "9.5", 4, "with the hash"},
        {"[20, 20]", "hdm", "9.0", 5, "5 iterations"}}) {
    write("other/a.toml", size, energy, modulus, iterations);
    for (const std::string& run :
         {"run a.toml --output " + path("out"), std::string("verify a.toml --backends openmp --quick")}) {
      const test::Outcome outcome = test::expect_run(
          2, run, AllOf(HasSubstr(says), HasSubstr("give all ranks the same program and files")),
          fmt::format("cd '{}'; {}", path(""), with_last(run, "cd other; exec \"$0\" \"$@\"")));
    }
  }
  EXPECT_TRUE(test::files_in(path("out")).empty());
}

TEST_F(RankProgram, AKilledRankIsNamedAndEndsAll) {
  const std::string run = "run square --size 1000 --iterations 1000000 --output " + path("out");
  test::expect_run(128 + 9, run, AllOf(HasSubstr("process rank 1"), HasSubstr("signal 9 (Killed)")),
                   with_last(run, "(sleep 1; kill -9 $$) & exec \"$0\" \"$@\""));
  EXPECT_TRUE(test::files_in(path("out")).empty());
}

TEST_F(RankProgram, ScalingIsMeasured) {
  for (const std::string more : {"", " --energy elastic --method full-multigrid"}) {
    test::expect_run(0,
                     fmt::format("bench --scaling strong square --size 256 --repeat 2{} --json {}", more,
                                 path("scaling.json")),
                     HasSubstr("strong scaling, openmp on 1 ... 2 ranks"), on_ranks(2));
    const nlohmann::json rows = test::read_json(path("scaling.json"))["results"];
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0]["energy"], more.empty() ? "hdm" : "elastic");
    EXPECT_EQ(rows[1]["seconds"].size(), 2U);
    EXPECT_GT(rows[1]["messages"], rows[0]["messages"]);
  }
}

} // namespace
} // namespace hdmbench
