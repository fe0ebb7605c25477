#include "test/suite.hpp"

#include <regex>

// Includes go one way through the rooms: a file includes its own room and rooms that stand before it in
// `rooms`.
namespace {

namespace fs = std::filesystem;

struct Room {
  std::string_view path; ///< what the paths of its files begin with; of several, the longest counts
  int height;            ///< rooms of one height are one
};

constexpr std::array rooms{
    Room{"kernels/specification/", 0}, Room{"kernels/shaders/", 0},       Room{"kernels/data/", 1},
    Room{"backends/backend.", 2},      Room{"backends/device/", 2},       Room{"backends/session/", 2},
    Room{"backends/pieces/", 2},       Room{"backends/shared/", 2},       Room{"backends/cpu/", 3},
    Room{"backends/gl/", 4},           Room{"backends/vulkan/", 5},       Room{"backends/opencl/", 6},
    Room{"backends/cuda/", 6},         Room{"backends/registry.", 7},     Room{"reference/", 8},
    Room{"harness/scene/", 9},         Room{"harness/solve/", 10},        Room{"harness/applications/", 11},
    Room{"harness/check/", 12},        Room{"harness/check/faults/", 13}, Room{"harness/measure/", 14},
    Room{"harness/judge/", 15},        Room{"harness/report/", 16},       Room{"harness/tools/", 17},
    Room{"harness/web/", 18},          Room{"harness/ranks/", 19},        Room{"harness/cli/", 20},
    Room{"harness/itk/", 21},          Room{"harness/python/", 22},
};

/// Arrows that the heights would allow and that are wrong all the same: what is built without the other.
bool is_forbidden(const Room& from, const Room& to) {
  const bool is_family = from.height > 2 && from.height < 7;
  const bool to_family = to.height > 2 && to.height < 7;
  return (is_family && to_family && from.height != to.height) ||
         (from.path == "reference/" && to.path.starts_with("backends/")) ||
         (from.path == "harness/itk/" && to.height > 10 && to.height != from.height) ||
         (from.path == "harness/python/" && to.path == "harness/cli/");
}

const Room* room_of(std::string_view path) {
  const Room* found = nullptr;
  for (const Room& room : rooms) {
    if (path.starts_with(room.path) && (found == nullptr || room.path.size() > found->path.size())) {
      found = &room;
    }
  }
  return found;
}

/// "FROM includes TO" for every include that goes the wrong way, and "FROM has no room". `sources`: text by
/// path.
std::vector<std::string> wrong_arrows(const std::map<std::string, std::string>& sources) {
  static const std::regex include("#include \"([^\"]+)\"");
  std::vector<std::string> wrong;
  for (const auto& [path, text] : sources) {
    const Room* const from = room_of(path);
    if (from == nullptr) {
      wrong.push_back(fmt::format("{} has no room", path));
      continue;
    }
    for (std::sregex_iterator match(text.begin(), text.end(), include), end; match != end; ++match) {
      const std::string target = (*match)[1];
      const Room* const to = room_of(target);
      if (to != nullptr && (to->height > from->height || is_forbidden(*from, *to))) {
        wrong.push_back(fmt::format("{} includes {}", path, target));
      }
    }
  }
  return wrong;
}

std::map<std::string, std::string> project_sources() {
  std::map<std::string, std::string> sources;
  const fs::path project = HDMBENCH_SOURCE;
  for (const std::string_view room : {"kernels", "backends", "reference", "harness"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(project / room)) {
      const std::string extension = entry.path().extension();
      if (extension == ".cpp" || extension == ".hpp" || extension == ".h" || extension == ".hxx") {
        std::ostringstream text;
        text << std::ifstream(entry.path()).rdbuf();
        sources.emplace(fs::relative(entry.path(), project), text.str());
      }
    }
  }
  return sources;
}

TEST(Rooms, IncludeOnlyWhatStandsBeforeThem) {
  const std::map<std::string, std::string> sources = project_sources();
  ASSERT_GT(sources.size(), 100U);
  EXPECT_THAT(wrong_arrows(sources), testing::IsEmpty());
}

TEST(Rooms, AWrongArrowIsSeen) {
  for (const auto& [from, to] : {std::pair{"kernels/data/a.cpp", "backends/backend.hpp"},
                                 {"harness/scene/a.cpp", "harness/solve/solve.hpp"},
                                 {"harness/measure/a.cpp", "harness/report/results.hpp"},
                                 {"reference/a.cpp", "backends/backend.hpp"},
                                 {"backends/vulkan/a.cpp", "backends/gl/objects.hpp"},
                                 {"harness/itk/a.h", "harness/report/table.hpp"},
                                 {"harness/python/a.cpp", "harness/cli/arguments.hpp"}}) {
    EXPECT_THAT(wrong_arrows({{from, fmt::format("#include \"{}\"\n", to)}}),
                testing::ElementsAre(fmt::format("{} includes {}", from, to)));
  }
  EXPECT_THAT(wrong_arrows({{"harness/attic/a.cpp", ""}}),
              testing::ElementsAre("harness/attic/a.cpp has no room"));
  EXPECT_THAT(wrong_arrows({{"harness/cli/a.cpp", "#include \"harness/report/report.hpp\"\n"}}),
              testing::IsEmpty());
}

/// Where what belongs to one energy stands in a file: whether the sentence `if (elastic)` in whatever words.
int questions_for_an_energy(const std::string& text) {
  static const std::regex question(
      R"(EnergyModel|is_elastic|takes_elastic|(find_energy\(|energy(->|\.)name *[=!]= *)\"|[=!]= *\"(hdm|elastic)\")");
  return static_cast<int>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), question), std::sregex_iterator()));
}

TEST(Rooms, ThatAnEnergyIsOneOfTwoIsAskedNowhere) {
  for (const auto& [path, text] : project_sources()) {
    EXPECT_EQ(questions_for_an_energy(text), 0) << path;
  }
  EXPECT_EQ(questions_for_an_energy("if (scene.energy == EnergyModel::elastic)"), 1);
  EXPECT_EQ(questions_for_an_energy("if (scene.energy->name == \"elastic\" || row.energy != \"hdm\")"), 2);
  EXPECT_EQ(questions_for_an_energy("if (&find_energy(\"elastic\") == scene.energy)"), 1);
}

/// The comments that begin with a clause without a verb: "Of an array."
int verbless_comments(const std::string& text) {
  int found = 0;
  bool was_comment = false;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string_view words =
        std::string_view(line).substr(std::min(line.find_first_not_of(' '), line.size()));
    const std::string_view said = words.substr(std::min(words.find_first_not_of('/'), words.size()));
    found += !was_comment && words.starts_with("//") && (said.starts_with(" Of ") || said.starts_with(" As "))
                 ? 1
                 : 0;
    was_comment = words.starts_with("//");
  }
  return found;
}

TEST(Rooms, CommentsOfHeadersSayWhatIsDone) {
  for (const auto& [path, text] : project_sources()) {
    const bool is_header = path.ends_with(".hpp") || path.ends_with(".h");
    EXPECT_TRUE(!is_header || verbless_comments(text) == 0) << path;
  }
  EXPECT_EQ(verbless_comments("int a;\n  /// Of an array.\n"), 1);
  EXPECT_EQ(verbless_comments("int a;\n/// Returns it.\n/// Of an array all.\n"), 0);
}

} // namespace
