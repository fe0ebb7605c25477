// The pages that a newcomer types from: their commands are run, and what they say comes.

#include "test/files.hpp"
#include "test/person.hpp"
#include "test/program.hpp"

namespace hdmbench {
namespace {

/// A fenced block of a page: what it is of ("sh", "text", "yaml"), and its text.
struct Block {
  std::string kind;
  std::string text;
};

std::vector<Block> blocks_of(const fs::path& page) {
  std::istringstream lines(content(page));
  std::vector<Block> blocks;
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) {
      inside = !inside;
      if (inside) {
        blocks.push_back({line.substr(3), ""});
      }
    } else if (inside) {
      blocks.back().text += line + '\n';
    }
  }
  return blocks;
}

test::Outcome in_shell(const fs::path& folder, const std::string& commands) {
  const fs::path script = folder / ".commands";
  std::ofstream(script) << "set -e\nexport GOMP_SPINCOUNT=1000\nPATH='"
                        << fs::path(HDMBENCH_PROGRAM).parent_path().string() << "':\"$PATH\"\ncd '"
                        << folder.string() << "'\n"
                        << commands;
  FILE* pipe = popen(fmt::format("sh '{}' 2>&1", script.string()).c_str(), "r");
  std::string output;
  for (int letter = 0; (letter = std::fgetc(pipe)) != EOF;) {
    output += static_cast<char>(letter);
  }
  return {WEXITSTATUS(pclose(pipe)), output};
}

/// Whether a word of the page is one of the output: numbers within 2 %, or 0.02.
bool is_word(const std::string& page, const std::string& output) {
  char* end_of_page = nullptr;
  char* end_of_output = nullptr;
  const double said = std::strtod(page.c_str(), &end_of_page);
  const double came = std::strtod(output.c_str(), &end_of_output);
  if (end_of_page == page.c_str() || end_of_output == output.c_str()) {
    return page == output;
  }
  return std::string_view(end_of_page) == end_of_output &&
         std::abs(said - came) <= 0.02 * std::max(std::abs(said), 1.0);
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

bool has_line(const std::string& output, const std::string& quoted) {
  const std::vector<std::string> words = words_of(quoted);
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    if (std::ranges::equal(words, words_of(line), is_word)) {
      return true;
    }
  }
  return false;
}

TEST(Tutorial, SaysWhatComes) {
  if (!fs::exists("/usr/share/mricron/templates/ch2bet.nii.gz") || !have_images()) {
    GTEST_SKIP() << "the head is not installed (mricron-data), or this build reads no images";
  }
  const test::TemporaryFolder folder;
  std::string output;
  int commands = 0;
  int lines = 0;
  for (const auto& [kind, text] : blocks_of(fs::path(HDMBENCH_SOURCE) / "harness/tutorial/README.md")) {
    if (kind == "sh") {
      const auto [status, came] = in_shell(folder.path(), text);
      ASSERT_EQ(status, 0) << text << came;
      output = came;
      ++commands;
    } else {
      std::istringstream quoted(text);
      for (std::string line; std::getline(quoted, line); ++lines) {
        EXPECT_TRUE(has_line(output, line)) << line << "\n  is not in\n" << output;
      }
    }
  }
  EXPECT_GE(commands, 4);
  EXPECT_GE(lines, 12);
  for (const char* picture : {"after", "magnitude", "deviation"}) {
    const std::string name = fmt::format("my-head-{}.png", picture);
    EXPECT_TRUE(content(fs::path(HDMBENCH_SOURCE) / "reports/tutorial" / name) ==
                content(folder.path() / "out" / name))
        << name << " is not what these commands draw";
  }
}

/// The commands of a table: what stands between backquotes and begins with the program's name.
std::vector<std::string> commands_in_tables(const fs::path& page) {
  std::istringstream lines(content(page));
  std::vector<std::string> commands;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream parts(line);
    bool is_code = false;
    for (std::string part; line.starts_with('|') && std::getline(parts, part, '`'); is_code = !is_code) {
      if (is_code && part.starts_with("hdmbench ")) {
        commands.push_back(part);
      }
    }
  }
  return commands;
}

/// What the page takes for granted: a head of 4 mm with landmarks and a surface above its middle.
void write_head(const test::TemporaryFolder& folder) {
  const Scene head = test::small_brain(24, 20);
  write_labels(folder.path() / "labels.nrrd", head.labels, 4.0);
  write_scalar(folder.path() / "t1.nrrd", head.picture, 4.0);
  const char* const title = "# CoordinateSystem = LPS\n";
  (void)folder.write("before.fcsv",
                     fmt::format("{}1,40,44,54,0,0,0,1,1,1,0,a,,\n2,52,48,54,0,0,0,1,1,1,0,b,,\n", title));
  (void)folder.write("after.fcsv",
                     fmt::format("{}1,40,44,50,0,0,0,1,1,1,0,a,,\n2,52,48,51,0,0,0,1,1,1,0,b,,\n", title));
  for (const auto& [name, z] : {std::pair{"grid-before.vtk", 54}, {"grid-after.vtk", 50}}) {
    (void)folder.write(name, fmt::format("# vtk DataFile Version 4.2\n3D Slicer output. SPACE=LPS\nASCII\n"
                                         "DATASET POLYDATA\nPOINTS 4 float\n36 40 {0}  56 40 {0}  56 52 {0}  "
                                         "36 52 {0}\nPOLYGONS 1 5\n4 0 1 2 3\n",
                                         z));
  }
  (void)folder.write("pairs.csv", "40,44,54,0,0,-4,1\n52,48,54,0,0,-3,1\n");
}

TEST(Requests, AreAnsweredByTheCommandsOfThePage) {
  if (!have_images()) {
    GTEST_SKIP() << "this build reads no images";
  }
  const test::TemporaryFolder folder;
  write_head(folder);
  const fs::path page = fs::path(HDMBENCH_SOURCE) / "harness/tutorial/requests.md";
  for (const auto& [kind, text] : blocks_of(page)) {
    ASSERT_EQ(in_shell(folder.path(), text).status, 0) << text;
  }
  const std::vector<std::string> commands = commands_in_tables(page);
  EXPECT_GE(commands.size(), 12U);
  for (const std::string& command : commands) {
    const auto [status, output] = in_shell(folder.path(), command);
    EXPECT_EQ(status, 0) << command << '\n' << output;
  }
  for (const auto& [file, way] : {std::pair{"out/labels.nrrd", "modeling"}, {"back.nrrd", "resampling"}}) {
    EXPECT_THAT(content(folder.path() / file), HasSubstr(fmt::format("displacement field type:={}", way)));
  }
  EXPECT_TRUE(fs::exists(folder.path() / "points/0001-points.csv"));
}

/// What the page has others type, on whatever drivers are here.
TEST(ContinuousIntegration, TakesTheCommandsOfThePage) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder.path() / "here/build/core");
  fs::create_symlink(HDMBENCH_PROGRAM, folder.path() / "here/build/core/hdmbench");
  std::string all;
  for (const Block& block : blocks_of(fs::path(HDMBENCH_SOURCE) / "harness/ci/README.md")) {
    all += block.text;
  }
  std::istringstream lines(all);
  int commands = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find("build/core/hdmbench ");
    if (begin != std::string::npos) {
      ++commands;
      const bool needs_driver = line.find("--fail-on-skip") != std::string::npos;
      const auto [status, output] = in_shell(folder.path() / "here", line.substr(begin));
      EXPECT_TRUE(status == 0 || (needs_driver && status == 2 && output.find("vulkan") != std::string::npos))
          << line << '\n'
          << output;
    }
  }
  EXPECT_EQ(commands, 6);
  EXPECT_THAT(content(folder.path() / "verify.xml"), HasSubstr("<testsuite"));
  EXPECT_THAT(content(folder.path() / "here/verify.xml"), HasSubstr("<testsuite"));
  EXPECT_THAT(content(fs::path(HDMBENCH_SOURCE) / "harness/set_up"), HasSubstr("--core) preset=core ;;"));
}

} // namespace
} // namespace hdmbench
