// What the program refuses: the rows of refusals.toml, which says how to add one. And what a caller of the
// library is refused, who has no program before him.

#include "test/files.hpp"
#include "test/person.hpp"
#include "test/program.hpp"

#include <toml++/toml.h>

namespace hdmbench {
namespace {

using Files = std::map<std::string, std::string>; ///< text by name

const toml::table& data() {
  static const toml::table tables = toml::parse_file(HDMBENCH_SOURCE "/test/refusals.toml");
  return tables;
}

Files files_of(const toml::table* table) {
  Files files;
  for (const auto& [name, text] : *table) {
    files.emplace(name.str(), text.value<std::string>().value());
  }
  return files;
}

std::string without_blanks(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// The parts of `text` between borders, without the blanks around them.
std::vector<std::string> parts_of(std::string text, const std::string& border) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; (at = text.find(border)) != text.npos; text.erase(0, at + border.size())) {
    parts.push_back(without_blanks(text.substr(0, at)));
  }
  parts.push_back(without_blanks(text));
  return parts;
}

/// A table of refusals.toml.
struct Group {
  std::string name;
  const toml::table* table;
  [[nodiscard]] std::string text(const char* key) const {
    return (*table)[key].value<std::string>().value_or("");
  }
};
void PrintTo(const Group& group, std::ostream* stream) {
  *stream << group.name;
}

std::vector<Group> groups() {
  std::vector<Group> all;
  for (const char* kind : {"words", "edits"}) {
    for (const auto& group : *data()[kind].as_array()) {
      all.push_back({(*group.as_table())["name"].value<std::string>().value(), group.as_table()});
    }
  }
  return all;
}

class Refusals : public testing::TestWithParam<Group> {
protected:
  void SetUp() override {
    const std::string needs = GetParam().text("needs");
    if (!needs.empty() && !have_images()) {
      GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
    }
    write(files_of(data()["files"].as_table()));
    for (const auto& [name, image] : files_of(data()["images"].as_table())) {
      const std::vector<std::string> parts =
          parts_of(image, "|"); // type, sizes, pixels; of volumes more header
      const auto axes = 1 + std::ranges::count(parts.at(1), ' ');
      const bool is_vector = axes == 3 && parts.size() == 3;
      write({{name, fmt::format("NRRD0004\ntype: {}\ndimension: {}\n{}\nsizes: {}\nencoding: ascii\n\n{}\n",
                                parts[0], axes,
                                is_vector          ? "kinds: vector domain domain"
                                : parts.size() > 3 ? parts[3]
                                                   : "# no more",
                                parts[1], parts.at(2))}});
    }
    if (needs == "person") {
      write_pictures();
    }
  }

  void write(const Files& files) const {
    for (const auto& [name, text] : files) {
      (void)folder_.write(name, text);
    }
  }

  /// Of 64 x 64 pixels: a person's, and those in which something is wrong.
  void write_pictures() const {
    constexpr int side = 64;
    const Extent extent{side, side};
    test::write_person(folder_.path(), side);
    std::map<std::string, ScalarField> pictures;
    for (const char* name : {"empty", "spoilt", "point", "corner", "noise", "left", "right"}) {
      pictures.emplace(name, extent);
    }
    pictures.emplace("everywhere", ScalarField(extent, 1.0F));
    pictures.emplace("constant", ScalarField(extent, 9.0F));
    pictures.emplace("modulus", ScalarField(extent, 20.0F));
    pictures.emplace("small", ScalarField({32, 32}));
    pictures.emplace("block", ScalarField({20, 20, 20}));
    std::fill_n(pictures["block"].values.begin(), 4000, 200.0F);
    GaussianNoise random(1);
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      pictures["noise"].values[site] = static_cast<float>(100.0 * random.uniform());
      pictures["corner"].values[site] = x < 8 && y < 8 ? 1.0F : 0.0F;
      pictures["left"].values[site] = x == 5 && y >= 20 && y < 40 ? 200.0F : 0.0F;
      pictures["right"].values[site] = x == 50 && y >= 20 && y < 40 ? 200.0F : 0.0F;
    });
    pictures["point"].values[extent.index(30, 31)] = 1.0F;
    pictures["spoilt"].values[extent.index(30, 31)] = std::nanf("");
    for (const auto& [name, picture] : pictures) {
      write_scalar(folder_.path() / (name + ".nrrd"), picture, 1.0);
    }
    write_scalar(folder_.path() / "coarse.nrrd", pictures["noise"], 2.0);
    write_scalar(folder_.path() / "elsewhere.nrrd", pictures["noise"], 1.0, {.origin = {500.0, 0.0, 0.0}});
    write({{"volume.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 64 64 2\nencoding: raw\n\n" +
                               std::string(std::size_t{2} * side * side, 'x')}});
  }

  /// Types something in the folder of the test.
  [[nodiscard]] test::Outcome type(const std::string& words) const {
    return test::hdmbench(words, fmt::format("cd '{}';", folder_.path().string()));
  }

  void expect_refused(const std::string& words, const std::string& says) const {
    const test::Outcome outcome = type(words);
    EXPECT_EQ(outcome.status, 2) << words << '\n' << outcome.output;
    EXPECT_THAT(outcome.output,
                AllOf(HasSubstr(says), Not(HasSubstr("internal error")), Not(ContainsRegex("[0-9]{20}"))))
        << words;
    for (const char* output : {"o.nrrd", "out/displacement.nrrd", "out/modulus.nrrd", "o.svg", "o.html"}) {
      EXPECT_FALSE(fs::exists(folder_.path() / output)) << words;
    }
  }

  /// A row "old -> new" of `files`.
  void expect_refused_edit(Files files, const std::string& row, const std::string& says) const {
    const std::vector<std::string> halves = parts_of(row + " ", "-> ");
    ASSERT_EQ(halves.size(), 2U);
    const auto edited = std::ranges::find_if(
        files, [&](const auto& file) { return file.second.find(halves[0]) != std::string::npos; });
    ASSERT_NE(edited, files.end()) << "no file has it";
    edited->second.replace(edited->second.find(halves[0]), halves[0].size(), halves[1]);
    write(files);
    expect_refused(GetParam().text("command"), says);
  }

  test::TemporaryFolder folder_;
};

TEST_P(Refusals, SayWhatIsWrong) {
  const Group& group = GetParam();
  const toml::table* const good = (*group.table)["files"].as_table();
  std::vector<std::string> before{group.text("before")};
  if (const toml::array* const several = (*group.table)["before"].as_array()) {
    before.clear();
    several->for_each([&](const toml::value<std::string>& one) { before.push_back(one.get()); });
  }
  if (good != nullptr) {
    write(files_of(good));
    const test::Outcome outcome = type(group.text("command"));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    fs::remove(folder_.path() / "o.nrrd");
    fs::remove(folder_.path() / "o.html");
  }
  std::vector<std::string> rows = parts_of(group.text("rows"), "\n");
  rows.pop_back();
  ASSERT_GT(rows.size(), 1U);
  for (std::string& row : rows) {
    SCOPED_TRACE(row);
    for (std::size_t at = 0; (at = row.find("\\n", at)) != row.npos;) {
      row.replace(at, 2, 1, '\n');
    }
    const std::vector<std::string> halves = parts_of(row, " | ");
    ASSERT_EQ(halves.size(), 2U);
    if (good != nullptr) {
      expect_refused_edit(files_of(good), halves[0], halves[1]);
    } else {
      for (const std::string& first : before) {
        expect_refused(first + halves[0] + group.text("behind"), halves[1]);
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Of, Refusals, testing::ValuesIn(groups()),
                         [](const auto& information) { return information.param.name; });

/// Tables within tables are made and unmade by recursion.
TEST(SceneRefusals, KeysOfVeryManyPartsDoNotEndTheStack) {
  const test::TemporaryFolder folder;
  const auto many = [](const char* part, const char* between) {
    std::string text = part;
    for (int i = 0; i < 50'000; ++i) {
      text += between;
      text += part;
    }
    return text;
  };
  for (const std::string& text :
       {many("a", ".") + " = 1\n", "[" + many("a", " . ") + "]\n", "[[" + many("a", ".") + "]]\n",
        "a = {" + many("\"a b\"", ".") + " = 1}\n", "# don't\n" + many("'a'", ".") + " = 1\n",
        "a = " + many("[", "") + "\n", "a = " + many("{a=", "") + "\n"}) {
    test::expect_run(
        2, "run " + folder.write("deep.toml", text).string(),
        testing::AnyOf(HasSubstr("a key of more than 100 parts"), HasSubstr("nested value depth")));
  }
  const std::string good =
      "title = \"\"\"" + many("a", ".") + "\"\"\" # " + many("a", ".") + "\nsize = [3, 3]\n";
  test::expect_run(2, "run " + folder.write("title.toml", good).string(), Not(HasSubstr("parts")));
}

TEST(LevelRefusals, SayWhatIsWrong) {
  Level good = test::plain_level({7, 5});
  const auto refused = [&](float& value, float bad, const char* says) {
    const float before = std::exchange(value, bad);
    EXPECT_THAT(test::refusal([&] { validate(good); }), HasSubstr(says)) << bad;
    value = before;
  };
  EXPECT_EQ(test::refusal([&] { validate(good); }), "accepted");
  for (const float bad : {std::nanf(""), HUGE_VALF, -1.0F}) {
    refused(good.modulus.values[9], bad, "x = 2, y = 1");
    refused(good.confidence[1][9], bad, "x = 2, y = 1");
    refused(good.penalty, bad, "penalty K");
  }
  refused(good.modulus.values[9], 0.0F, "modulus");
  refused(good.modulus.values[9], 1e-39F, "its inverse");
  refused(good.confidence[0][9], 1.5F, "confidence");
  refused(good.target[0][9], std::nanf(""), "target");
  refused(good.target[1][9], -HUGE_VALF, "x = 2, y = 1");
  Level other = good;
  other.target = VectorField({5, 7});
  EXPECT_THAT(test::refusal([&] { validate(other); }), HasSubstr("5 x 7"));
  other = good;
  other.modulus.values.pop_back();
  EXPECT_THAT(test::refusal([&] { validate(other); }), HasSubstr("34 values"));
  other.extent = {0, 5};
  EXPECT_THAT(test::refusal([&] { validate(other); }), HasSubstr("at least 1"));
}

} // namespace
} // namespace hdmbench
