// The program as a user types it: exit status, messages, files.

#include "harness/check/verify.hpp"
#include "harness/report/ci_files.hpp"
#include "test/files.hpp"
#include "test/program.hpp"

#include <sys/stat.h>

namespace hdmbench {
namespace {

using test::hdmbench;
using test::read_json;

/// Commands to repeat are as long as they are.
void expect_narrow(const std::string& output, std::size_t columns) {
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(line.size() <= columns || line.find("hdmbench ") != std::string::npos) << line;
  }
}

/// Measures the lines below titles, which are as long as all columns.
void expect_narrow_tables(const std::string& output) {
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(line.size() <= 100 || line.find_first_not_of(" -") != std::string::npos) << line;
  }
}

TEST(CommandLine, ExplainsItself) {
  const test::Outcome help = test::expect_run(0, "--help", HasSubstr("Usage: hdmbench [OPTIONS] SUBCOMMAND"));
  EXPECT_EQ(test::expect_run(2, "").output, help.output) << "without a command";
  EXPECT_EQ(hdmbench("--version").output, "0.1.0\n");
  expect_narrow(help.output, 80);
  expect_narrow(test::expect_run(0, "scenes", AllOf(HasSubstr("3-D"), HasSubstr("64 x 64 x 64"))).output,
                100);
  expect_narrow(hdmbench("methods").output, 100);
  EXPECT_THAT(hdmbench("run --help").output, HasSubstr("of the thesis's energy alone:\n"));
  EXPECT_THAT(hdmbench("tune --help").output, Not(HasSubstr("of the thesis's energy alone")));
}

/// test/run has set all that the program would start itself again for.
TEST(CommandLine, StartsAgainWhereTheEnvironmentLacksSomething) {
  const std::string version = test::expect_run(0, "--version").output;
  for (const char* const without : {"env -u GLIBC_TUNABLES", "env -u GOMP_SPINCOUNT", "env -i"}) {
    EXPECT_EQ(test::expect_run(0, "--version", testing::_, without).output, version) << without;
  }
}

/// What a command does, its exit status, and the keys that each of its rows has. A report is made of them
/// all.
TEST(CommandLine, WritesRowsOfResults) {
  struct Command {
    std::string_view words;
    const char* keys;
    std::size_t rows = 0; ///< 0: any number
    int status = 0;
  };
  const test::TemporaryFolder folder;
  int number = 0;
  for (const Command& command : std::initializer_list<Command>{
           {"devices", "backend available device"},
           {"verify circular tie-rich --sizes 24,1x7 --backends openmp",
            "scene width height backend mode method verdict tier sites_differing sites_compared", 14},
           {"golden square --backends openmp", "scene backend verdict"},
           {"faults --faults nan-at-one-site --size 24", "fault as_expected"},
           {"bench square --size 16 --backends openmp --repeat 5 --iterations 5 --no-ceilings",
            "seconds seconds_median speed_up_over_scalar valid iterations method", 3},
           {"bench square --size 16 --backends openmp,scalar --reference openmp --repeat 1 --no-ceilings",
            "reference valid", 3},
           {"accuracy circular --size 32 --quick --backends openmp --repeat 1",
            "method backend rmsd_to_fem rmsd_to_fixed_point seconds_median valid status rival"},
           {"accuracy square --size 32 --energy elastic --quick --backends openmp --repeat 1",
            "energy method"},
           {"tradeoff square --size 12 --quick --backends openmp", "scene"},
           {"atlas alignment --quick", "entry"},
           {"continuum --sizes 8,12", "width contrast", 8},
           {"probe --backends openmp", "question"},
           {"run circular --size 32 --output out", "field pictures warnings phases", 1},
           {"run circular --size 32 --no-pictures --output alone", "field phases", 1},
           {"run square --size 20 --energy elastic --accuracy 0.1px --output out", "method plan", 1},
           {"verify tie-rich random --size 1", "verdict"},
           {"run ball --size 9x8x7 --energy elastic --format nii.gz --output out", "depth field slices", 1},
           {"bench cube --sizes 8x8x8,9x8x7 --energy elastic --backends openmp --repeat 1 --no-ceilings",
            "depth seconds_median valid", 4},
           {"bench cube --size 9x8x7 --work dense --backends openmp --repeat 1 --no-ceilings", "depth valid",
            2},
           // A scene that prescribes every site, and one that cannot show a difference.
           {"verify square --size 1 --backends openmp", "verdict", 0, 1},
           {"verify square --size 9 --backends openmp --steps 0", "verdict", 0, 1}}) {
    const std::string file = fmt::format("{}.json", ++number);
    const test::Outcome outcome =
        hdmbench(fmt::format("{} --json {}", command.words, file), "cd " + folder.path().string() + ";");
    ASSERT_EQ(outcome.status, command.status) << command.words << '\n' << outcome.output;
    expect_narrow_tables(outcome.output);
    const nlohmann::json document = read_json(folder.path() / file);
    EXPECT_EQ(document["schema"], 1);
    for (const char* key : {"machine", "cpu", "compiler", "flags", "commit", "date"}) {
      EXPECT_FALSE(document["context"][key].get<std::string>().empty()) << key;
    }
    EXPECT_GT(document["results"].size(), 0U) << command.words;
    EXPECT_TRUE(command.rows == 0 || document["results"].size() == command.rows) << command.words;
    for (const nlohmann::json& row : document["results"]) {
      std::istringstream keys(command.keys);
      for (std::string key; keys >> key;) {
        EXPECT_TRUE(row.contains(key)) << command.words << " has no " << key;
      }
      EXPECT_EQ(row.contains("pictures"), command.words.starts_with("run ") &&
                                              command.words.find("--no-pictures") == std::string_view::npos);
      for (const char* output : {"pictures", "field"}) {
        for (const nlohmann::json& file_name : row.value(output, nlohmann::json::array())) {
          EXPECT_TRUE(std::filesystem::exists(folder.path() / std::string(file_name))) << file_name;
        }
      }
    }
  }
  const nlohmann::json verified = read_json(folder.path() / "2.json")["results"];
  for (const nlohmann::json& row : verified) {
    const bool idle = row["mode"] == "active" && row["sites_at_rest"] == 0;
    EXPECT_EQ(row["verdict"], idle ? "skipped" : "agree");
    EXPECT_EQ(row["tier"], idle ? "none" : "bitwise");
    EXPECT_EQ(row["sites_differing"], 0);
    EXPECT_GT(row["sites_compared"], 0);
  }
  const nlohmann::json timings = read_json(folder.path() / "5.json")["results"];
  EXPECT_EQ(timings[0]["speed_up_over_scalar"], 1.0);
  EXPECT_EQ(timings[1]["iterations"], 5 * 5);
  auto seconds = timings[1]["seconds"].get<std::vector<double>>();
  std::ranges::sort(seconds);
  EXPECT_EQ(timings[1]["seconds_median"], seconds.at(2));
  EXPECT_GT(seconds[0], 0.0);
  EXPECT_TRUE(read_json(folder.path() / "6.json")["results"][2]["speed_up_over_scalar"].is_null())
      << "openmp was the measure";
  for (const char* key : {"rival", "seconds_median", "fine_sweep_equivalents", "rmsd_to_fem"}) {
    EXPECT_TRUE(read_json(folder.path() / "9.json")["results"][0].contains(key)) << key;
  }
  std::map<std::string, std::string> energies;
  const nlohmann::json judged = read_json(folder.path() / "8.json")["results"];
  for (const nlohmann::json& row : judged) {
    energies[row["method"]] = row["energy"];
  }
  EXPECT_EQ(energies["fem"], "elastic");
  EXPECT_EQ(energies["full-multigrid"], "elastic");
  EXPECT_EQ(energies["fixed-point"], "hdm");
  EXPECT_EQ(energies["interpolation"], "none");
  const std::string page = (folder.path() / "report.html").string();
  test::expect_run(0, "report " + folder.path().string() + " --output " + page);
  EXPECT_GT(std::filesystem::file_size(page), 10000U);
}

TEST(CommandLine, ALargeImageIsSolvedButNotInspected) {
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string();
  test::expect_run(0,
                   "run square --size 4098x4097 --start-level 0 --iterations 1 --output " + at +
                       "/out --json " + at + "/run.json",
                   AllOf(HasSubstr("Not diagnosed, and no pictures"), Not(HasSubstr("still moving"))));
  const nlohmann::json row = read_json(folder.path() / "run.json")["results"][0];
  EXPECT_EQ(row["field"], "out/square.nrrd");
  EXPECT_FALSE(row.contains("pictures"));
  EXPECT_GT(std::filesystem::file_size(folder.path() / "out/square.nrrd"), 0U);
}

/// For hdmbench(): what stands before the program, whose standard output goes `where`.
std::string with_output(const std::string& where) {
  return "with_output() { \"$@\" " + where + "; }; with_output";
}

TEST(CommandLine, AFieldThatIsNoneIsNotWritten) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("wild.toml", R"(size = [30, 30]
[[tissue]]
label = 0
modulus = 1e-30
[[tissue]]
label = 1
modulus = 1e30
[[shape]]
kind = "everything"
label = 0
[[shape]]
kind = "rectangle"
label = 1
centre = [0.5, 0.5]
size = [0.3, 0.3]
[[condition]]
where = "left"
dx = 0.0
dy = 0.0
[[condition]]
where = "right"
dy = 10.0
)");
  const auto output = folder.path() / "o";
  const auto run =
      test::hdmbench(fmt::format("run '{}' --method cascade --output '{}'", scene.string(), output.string()));
  EXPECT_EQ(run.status, 1) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("NO RESULT"), HasSubstr("No files are written"),
                                Not(HasSubstr("--method cascade"))));
  EXPECT_FALSE(std::filesystem::exists(output / "wild.nrrd"));
}

/// Pixels that are no squares, of tissue that slides: no other size would do, and lines that repeat state
/// none.
TEST(CommandLine, OblongPixelsOfAFileStayAsTheyAreInEveryCommand) {
  const test::TemporaryFolder folder;
  std::string pixels;
  for_each_site({20, 12}, [&](int x, int y) {
    pixels += std::hypot((x - 9.5) / 8.0, (y - 5.5) / 4.5) < 1.0 ? "1 " : "0 ";
  });
  (void)folder.write("labels.nrrd", "NRRD0004\ntype: uchar\ndimension: 2\nsizes: 20 12\nspacings: 1 2.5\n"
                                    "encoding: ascii\n\n" +
                                        pixels);
  (void)folder.write("o.toml",
                     "energy = \"elastic\"\n[image]\nlabels = \"labels.nrrd\"\n"
                     "[[tissue]]\nlabel = 0\nmodulus = 0.0\n[[tissue]]\nlabel = 1\nmodulus = 0.003\n"
                     "density = 1000.0\n[[condition]]\nwhere = \"labels\"\nlabels = [0]\nslide = true\n"
                     "[[load]]\ngravity = [1.0, 2.0]\n");
  const std::string there = "cd " + folder.path().string() + ";";
  test::expect_run(2, "accuracy o.toml --backends openmp", HasSubstr("o has loads, which the hdm energy"),
                   there);
  for (const std::string command :
       {"verify o.toml --backends openmp", "bench o.toml --backends openmp --repeat 1 --no-ceilings",
        "tradeoff o.toml --backends openmp --repeat 1 --methods as-needed-elastic --quick"}) {
    test::expect_run(0, command + " --json a.json", testing::_, there);
    const nlohmann::json rows = read_json(folder.path() / "a.json")["results"];
    EXPECT_FALSE(rows.empty());
    for (const nlohmann::json& row : rows) {
      EXPECT_EQ(row["width"], 20) << command;
      EXPECT_EQ(row["height"], 12) << command;
      EXPECT_LT(row.value("rmsd_to_fem", 0.0), 0.1);
      const std::string line = row.value("repeat", row.value("command", ""));
      if (!line.empty()) {
        EXPECT_THAT(line, testing::Not(HasSubstr("--size")));
        test::expect_run(0, line.substr(line.find(' ')), testing::_, there);
      }
    }
  }
}

TEST(CommandLine, OutputThatIsLostIsReported) {
  for (const char* arguments : {"--help", "--version", "", "methods", "devices", "faults --list",
                                "run --help", "verify square --size 9 --backends openmp",
                                "bench square --size 9 --backends openmp --no-ceilings"}) {
    for (const char* where : {">/dev/full", ">&-"}) {
      test::expect_run(2, arguments, HasSubstr("standard output cannot be written to"), with_output(where));
    }
  }
  EXPECT_EQ(hdmbench("fly", "no_errors() { \"$@\" 2>/dev/full; }; no_errors").status, 2);
}

TEST(CommandLine, ResultsGoWhereTheyAreSentTo) {
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string();
  const std::string file = at + "/a.json";
  EXPECT_EQ(hdmbench("devices --json /dev/stdout", with_output(">" + file)).status, 0);
  EXPECT_THAT(read_file(file), AllOf(HasSubstr("\"command\": \"devices\""), HasSubstr("scalar")));
  EXPECT_THAT(hdmbench("devices --json /dev/stdout").output, HasSubstr("\"command\": \"devices\""));
  EXPECT_THAT(hdmbench("devices --json /dev/full").output, HasSubstr("/dev/full: cannot be written"));

  std::filesystem::create_symlink("loop", at + "/loop");
  test::expect_run(2, "run square --size 9 --output " + at + "/loop", HasSubstr("loop"));

  test::expect_run(2, "devices --json " + at + "/limited.json", HasSubstr("File too large"), "ulimit -f 1;");
  test::expect_run(2, "run square --size 64 --output " + at + "/out", testing::_, "ulimit -f 1;");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(at)) {
    EXPECT_THAT(entry.path().string(), Not(HasSubstr("partial")));
  }
}

/// A small image, a scene of it, and results in a folder.
class Inputs : public testing::Test {
protected:
  [[nodiscard]] std::string at(const std::string& name) const { return (folder_.path() / name).string(); }

  /// Runs where the files are.
  [[nodiscard]] test::Outcome run(const std::string& arguments) const {
    return hdmbench(arguments, "cd " + folder_.path().string() + ";");
  }

  test::TemporaryFolder folder_;
};

TEST_F(Inputs, AreNeverReplacedByOutputs) {
  const std::string image = "NRRD0004\ntype: uchar\ndimension: 2\nsizes: 18 16\nencoding: raw\n\n" +
                            std::string(144, '\0') + std::string(144, '\1');
  const std::string scene = "[image]\nlabels = \"scene.nrrd\"\npicture = \"displacement.nrrd\"\n"
                            "[[tissue]]\nlabel = 0\nmodulus = 1.0\n[[tissue]]\nlabel = 1\nmodulus = 2.0\n";
  const std::string nodes = "1,0,0,0,0\n2,10,0,10,0\n3,10,10,10,5\n4,0,10,0,5\n";
  ASSERT_EQ(run("devices --json v.json").status, 0);
  for (const auto& [name, bytes] : {std::pair<const char*, const std::string&>{"scene.nrrd", image},
                                    {"displacement.nrrd", image},
                                    {"scene.toml", scene},
                                    {"nodes.csv", nodes}}) {
    (void)folder_.write(name, bytes);
  }
  std::filesystem::create_symlink("v.json", at("link.json"));
  const auto before = test::files_in(folder_.path());
  for (const char* arguments :
       {"report v.json --output v.json", "report . --output v.json", "report v.json --output link.json",
        "run scene.toml --json scene.toml", "run scene.toml --json scene.nrrd", "run scene.toml --output .",
        "verify square scene.toml --json scene.nrrd", "bench scene.toml --benchmark_out scene.nrrd",
        "accuracy scene.toml --json scene.toml", "bench scene.toml --benchmark-json scene.toml",
        "energy-plot scene.toml --sites 1,1 2,2 --output scene.nrrd", "export scene.toml --output .",
        "register scene.nrrd displacement.nrrd --scene scene.toml --json scene.nrrd",
        "register scene.nrrd displacement.nrrd --scene scene.toml --output .",
        "detect scene.nrrd displacement.nrrd --scene square --roi v.json --json v.json",
        "fem-to-image nodes.csv --size 9 --output nodes.csv",
        "fem-to-image nodes.csv --size 9 --output o.nrrd --mask nodes.csv",
        "positions-to-displacements scene.nrrd scene.nrrd"}) {
    const test::Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments << '\n' << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("would replace the input")) << arguments;
    ASSERT_EQ(test::files_in(folder_.path()), before) << arguments;
  }
}

TEST_F(Inputs, ResultsGoToStandardOutputAlone) {
  const test::Outcome outcome =
      run("run square --size 20 --output out --json - 2>text >a.json; cat text; exit 0");
  const nlohmann::json document = read_json(at("a.json"));
  EXPECT_EQ(document["command"], "run");
  EXPECT_EQ(document["results"][0]["field"], "out/square.nrrd");
  EXPECT_THAT(outcome.output, HasSubstr("largest displacement"));
  EXPECT_FALSE(std::filesystem::exists(at("-")));
  EXPECT_EQ(nlohmann::json::parse(run("devices --json=- 2>/dev/null; exit 0").output)["command"], "devices");
  EXPECT_EQ(run("devices --json - >/dev/full").status, 2);
}

TEST_F(Inputs, AnAccuracyMayBeInMillimetres) {
  (void)folder_.write("half.toml",
                      "size = [20, 20]\nspacing = 0.5\n[random]\nseed = 2\nmodulus = [1.0, 9.0]\n"
                      "displacement = 2.0\nobserved = 0.1\n");
  (void)run("run half.toml --accuracy 0.1mm --json mm.json");
  EXPECT_EQ(read_json(at("mm.json"))["results"][0]["plan"]["asked_px"], 0.2);
  EXPECT_EQ(read_json(at("mm.json"))["results"][0]["energy"], "elastic");
  (void)run("run half.toml --energy elastic --accuracy 0.1px --json px.json");
  EXPECT_EQ(read_json(at("px.json"))["results"][0]["plan"]["asked_px"], 0.1);
}

/// Neo-Hookean tissue where the accuracy asks for it, the linear law where that is near enough.
TEST_F(Inputs, AnAccuracyDecidesOnTheLaw) {
  const auto plan_for = [&](const std::string& accuracy) {
    (void)run("run square --size 150 --energy auto --no-pictures --json row.json --accuracy " + accuracy);
    return read_json(at("row.json"))["results"][0];
  };
  const nlohmann::json by_law = plan_for("0.02px");
  EXPECT_FALSE(by_law["plan"].contains("linear_distance_px"));
  const nlohmann::json linear = plan_for("1px");
  EXPECT_GT(linear["plan"]["linear_distance_px"], 0.02);
  EXPECT_LT(linear["plan"]["linear_distance_px"], 0.2);
  EXPECT_TRUE(linear["plan"]["met"] && by_law["plan"]["met"]);
  EXPECT_LT(linear["plan"]["fine_sweep_equivalents"], by_law["plan"]["fine_sweep_equivalents"]);
}

TEST(CommandLine, WhatNeverEndsIsNotRead) {
  const test::TemporaryFolder folder;
  const std::string pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto image = [&](const char* name, const std::string& header) {
    const std::string file = folder.write(name, header);
    return "run " +
           folder.write(std::string(name) + ".toml", "[image]\nmodulus = \"" + file + "\"\n").string();
  };
  for (const std::string& endless : {std::string("/dev/zero"), pipe}) {
    const auto scene = folder.write("scene.toml", "[image]\nmodulus = \"" + endless + "\"\n");
    for (const std::string& arguments :
         {"run " + endless, "report " + endless, "bench " + endless,
          "fem-to-image " + endless + " --size 9 --output /dev/null",
          "positions-to-displacements " + endless + " /dev/null", "run " + scene.string(),
          image("a.nrrd", "NRRD0004\ntype: float\ndimension: 2\nsizes: 8 8\nencoding: gzip\ndata file: " +
                              endless + "\n"),
          image("a.mhd", "ObjectType = Image\nNDims = 2\nDimSize = 8 8\nElementType = MET_FLOAT\n"
                         "ElementDataFile = " +
                             endless + "\n")}) {
      test::expect_run(2, arguments, testing::_, "timeout 20");
    }
  }
}

TEST(CommandLine, WithoutOpenGlItSaysSo) {
  const std::string no_driver = "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent EGL_PLATFORM=none";
  const test::Outcome needed = hdmbench("verify square --size 9 --backends gl-fragment", no_driver);
  if (needed.status == 0) {
    GTEST_SKIP() << "this EGL finds a driver all the same";
  }
  EXPECT_EQ(needed.status, 2) << needed.output;
  EXPECT_THAT(needed.output, HasSubstr("gl-fragment is needed but not there"));
  test::expect_run(2, "verify square --size 9 --require gl-compute", testing::_, no_driver);
  test::expect_run(0, "verify square --size 9",
                   AllOf(HasSubstr("gl-fragment: skipped: "), Not(HasSubstr("0 skipped"))), no_driver);
}

TEST(CommandLine, WithoutFloatTexturesTheOthersAreCompared) {
  if (hdmbench("verify tie-rich --sizes 8 --backends gl-fragment").status != 0) {
    GTEST_SKIP() << "there is no OpenGL that could lack them";
  }
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "verify.json").string();
  test::expect_run(0, "verify tie-rich --sizes 8 --json " + file,
                   ContainsRegex("gl-fragment: skipped: .*, has no GL_ARB_texture_float"),
                   "MESA_EXTENSION_OVERRIDE=-GL_ARB_texture_float");
  EXPECT_EQ(read_json(file)["results"][0]["verdict"], "agree");
}

/// Names of files may have any bytes; results are written all the same, and nothing raw is printed.
TEST(CommandLine, NamesThatAreNoTextAreWrittenAsWhatTheyAre) {
  const test::TemporaryFolder folder;
  const std::string scene = "size = [9, 9]\n[random]\nseed = 5\nmodulus = [1.0, 9.0]\ndisplacement = 5.0\n"
                            "observed = 0.1\n";
  const std::string at = folder.path().string();
  for (const std::string name : {"a\xff", "b\x1b[31m", "c\xef\xbf\xbe", "d\xc2\x9b", "e\xed\xa0\x80"}) {
    const std::string file = folder.write(name + ".toml", scene).string();
    const test::Outcome run =
        test::expect_run(0, fmt::format("run '{0}' --output '{1}/out' --json {1}/run.json", file, at),
                         HasSubstr("mean energy"));
    const test::Outcome verify = test::expect_run(
        0, fmt::format("verify '{0}' --backends openmp --json {1}/verify.json --junit {1}/j.xml", file, at));
    EXPECT_EQ(read_json(folder.path() / "run.json")["results"].size(), 1U) << name;
    EXPECT_FALSE(read_json(folder.path() / "verify.json")["results"].empty()) << name;
    const std::string raw = name.substr(1);
    for (const std::string& text : {run.output, verify.output, read_file(folder.path() / "j.xml")}) {
      EXPECT_THAT(text, Not(HasSubstr(raw)));
      EXPECT_THAT(text, HasSubstr(name.substr(0, 1) + "\\x"));
    }
    (void)folder.write(name + ".toml", "size = 3\n");
    const test::Outcome refused = test::expect_run(2, fmt::format("run '{}'", file), HasSubstr("size"));
    EXPECT_THAT(refused.output, Not(HasSubstr(raw)));
  }
  for (const char* name : {"a.json", "a.toml"}) {
    const std::string file = folder.write(name, "{\"a\": \"\xff\"}").string();
    test::expect_run(2, "run " + file, HasSubstr(name));
    test::expect_run(2, "report " + file, HasSubstr(name));
  }
}

/// What the system allows too little of is named, and 1 remains a disagreement.
TEST(CommandLine, LimitsOfTheSystemAreNamed) {
  if (!have_images()) {
    GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
  }
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string();
  write_scalar(folder.path() / "modulus.nrrd", ScalarField({64, 64}, 1.0F), 1.0);
  const std::string scene =
      folder
          .write("scene.toml",
                 "[image]\nmodulus = \"modulus.nrrd\"\n[[condition]]\nwhere = \"left\"\ndx = 1.0\n")
          .string();
  const std::string run = "run " + scene + " --output " + at + "/out";
  const auto shell = [](const char* words) { return fmt::format("sh -c '{}; exec \"$0\" \"$@\"'", words); };
  for (const auto& [limit, says] :
       {std::pair{shell("ulimit -n 32"), "32 open files are allowed (ulimit -n)"},
        {shell("ulimit -s 128"), "131072 bytes of stack are allowed (ulimit -s)"},
        {shell("ulimit -f 8"), "(ulimit -f)"},
        {shell("export OMP_STACKSIZE=1000G"), "a library has ended the program"}}) {
    test::expect_run(2, run, HasSubstr(says), limit);
  }
}

/// A driver that crashes, here because it has no memory, leaves what was compared before.
TEST(CommandLine, ACrashKeepsWhatWasComparedBefore) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "verify.json").string();
  for (const char* limit : {"ulimit -v 700000;", "ulimit -v 1000000;", "ulimit -v 1500000;"}) {
    const test::Outcome outcome = hdmbench("verify tie-rich circular --sizes 8 --json " + file, limit);
    EXPECT_TRUE(outcome.status == 0 || outcome.status == 2) << outcome.status << outcome.output;
    EXPECT_TRUE(outcome.status == 0 || outcome.output.find("hdmbench: ") != std::string::npos)
        << outcome.output;
  }
}

TEST(CommandLine, VerifyAndBenchWriteWhatTheCiOfOthersReads) {
  const test::TemporaryFolder folder;
  const auto junit = folder.path() / "verify.xml";
  test::expect_run(0, "verify tie-rich --sizes 24 --backends openmp --junit " + junit.string());
  EXPECT_THAT(read_file(junit),
              AllOf(HasSubstr(R"(tests="3" failures="0" skipped="1")"),
                    HasSubstr(R"(<testcase classname="tie-rich.24x24.icm" name="openmp resync" time="0.)")));
  const nlohmann::json bad{{"scene", "a<b"},
                           {"width", 3},
                           {"height", 4},
                           {"method", "icm"},
                           {"backend", "openmp"},
                           {"mode", "free"},
                           {"verdict", "disagree"},
                           {"sites_differing", 7},
                           {"reason", "\"x\""},
                           {"repeat", "hdmbench verify 'a<b'"},
                           {"device", "card"},
                           {"driver", "d 1"},
                           {"why", "fused"},
                           {"dump", "d/openmp"},
                           {"wall_seconds", 1.5},
                           {"first_difference",
                            {{"text", FirstDifference{.level = 2,
                                                      .iteration = 3,
                                                      .x = 4,
                                                      .y = 5,
                                                      .z = 6,
                                                      .expected = {1.5F, 2.0F, 0.0F},
                                                      .found = {1.25F, 2.0F, 0.0F},
                                                      .step = "sweep"}
                                          .text()}}}};
  report::write_junit(junit, nlohmann::json::array({bad}));
  EXPECT_THAT(
      read_file(junit),
      AllOf(
          HasSubstr(R"(failures="1")"), HasSubstr(R"(classname="a&lt;b.3x4.icm")"),
          HasSubstr("name=\"openmp free\" time=\"1.500\">"),
          HasSubstr(
              "disagree: 7 sites differ, 0 counts are wrong. &quot;x&quot;\">device: card\ndriver: d 1\n"
              "first: level 2, step 3, sweep, x = 4, y = 5, z = 6: expected (1.5, 2, 0), found (1.25, 2, "
              "0)\nwhy: fused\nthe step as a program: d/openmp\nrepeat: hdmbench verify &#39;a&lt;b&#39;")));

  const auto own = folder.path() / "bench.json";
  const auto google = folder.path() / "google.json";
  test::expect_run(0,
                   "bench square --size 16 --backends openmp --work dense --repeat 2 --no-ceilings --json " +
                       own.string() + " --benchmark-json " + google.string());
  const nlohmann::json row = read_json(own)["results"][1];
  const nlohmann::json file = read_json(google);
  EXPECT_EQ(file["context"]["hdmbench_commit"], read_json(own)["context"]["commit"]);
  std::vector<nlohmann::json> samples = file["benchmarks"];
  std::erase_if(samples, [](const nlohmann::json& one) { return one["run_type"] != "iteration"; });
  ASSERT_EQ(samples.size(), 4U) << "scalar and openmp, two samples each";
  EXPECT_THAT(
      samples[3]["name"].get<std::string>(),
      HasSubstr(fmt::format("square/16x16/hdm/icm/openmp/dense/threads:{}", row["threads"].get<int>())));
  EXPECT_EQ(samples[3]["time_unit"], "ms");
  EXPECT_DOUBLE_EQ(samples[3]["real_time"], 1000.0 * row["seconds"][1].get<double>());
  EXPECT_NE(samples[3]["cpu_time"], samples[3]["real_time"]) << "measured, not copied";
  EXPECT_GT(samples[3]["speed_up"], 0.0);
  EXPECT_THAT(row["command"].get<std::string>(),
              HasSubstr("hdmbench bench square --size 16x16 --backends openmp --work dense"));
  test::expect_run(0, "bench square --size 16 --backends openmp --benchmark_list_tests",
                   HasSubstr("square/16x16/hdm/icm/openmp/active"));
  test::expect_run(0,
                   "bench square --size 16 --backends openmp --no-ceilings --benchmark_filter=openmp/dense "
                   "--benchmark_format=console",
                   AllOf(HasSubstr("Time             CPU"), Not(HasSubstr("/active"))));
}

/// What is ended by whoever lost patience has the rows that it had.
TEST(CommandLine, AnInterruptedCommandLeavesWhatItMeasured) {
  const test::TemporaryFolder folder;
  const auto script = folder.write("cut.sh", fmt::format(R"(cd {}
'{}' tradeoff square --size 128 --backends openmp --json rows.json > /dev/null 2>&1 &
for i in $(seq 600); do grep -qs '"cut"' rows.json && break; sleep 0.1; done
kill -9 $!
)",
                                                         folder.path().string(), HDMBENCH_PROGRAM));
  ASSERT_EQ(std::system(("bash " + script.string()).c_str()), 0);
  const nlohmann::json left = read_json(folder.path() / "rows.json");
  EXPECT_EQ(left["cut"], true);
  EXPECT_GT(left["results"].size(), 0U);
  test::expect_run(0, "report " + folder.path().string() + " --output " + (folder.path() / "a.html").string(),
                   HasSubstr("ended before it had all rows: rows.json"));
  test::expect_run(0, "tradeoff square --size 9 --quick --methods icm --json " +
                          (folder.path() / "b.json").string());
  EXPECT_FALSE(read_json(folder.path() / "b.json").contains("cut"));
}

/// A row's command makes the row again.
TEST(CommandLine, TheCommandOfARowCanBeRun) {
  const test::TemporaryFolder folder;
  const std::string there = "cd " + folder.path().string() + ";";
  for (const char* const command :
       {"tradeoff square --size 16 --quick --backends openmp --methods "
        "icm,full-multigrid,as-needed-elastic,fem-cg",
        "bench square --size 16 --backends openmp --no-ceilings --repeat 1 --scaling"}) {
    ASSERT_EQ(hdmbench(fmt::format("{} --json rows.json", command), there).status, 0) << command;
    std::size_t number = 0;
    const nlohmann::json made = read_json(folder.path() / "rows.json")["results"];
    for (const nlohmann::json& row : made) {
      if (!row.contains("command") || number++ % 2 == 1) {
        continue;
      }
      const std::string again = row["command"];
      ASSERT_THAT(again, testing::StartsWith("hdmbench "));
      EXPECT_EQ(again.find("--poisson 0") != std::string::npos,
                row.value("poisson_used", 0.3) == 0.0 && !row.value("rival", false))
          << again;
      const test::Outcome outcome = hdmbench(again.substr(9) + " --json again.json", there);
      ASSERT_EQ(outcome.status, 0) << again << '\n' << outcome.output;
      const auto rows = read_json(folder.path() / "again.json")["results"];
      EXPECT_TRUE(std::ranges::any_of(rows, [&](const nlohmann::json& other) {
        return other["method"] == row["method"] ||
               (row["method"] == "as-needed-elastic" && other.contains("plan"));
      })) << again;
    }
    EXPECT_GT(number, 3U);
  }
}

} // namespace
} // namespace hdmbench
