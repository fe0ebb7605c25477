// What 3D Slicer is told of the program, against what its documentation of the Slicer Execution Model has,
// and back through the command line that it describes.

#include "test/files.hpp"
#include "test/program.hpp"

#include <regex>

namespace hdmbench {
namespace {

/// An element with its attributes and what is in it: text or other elements.
struct Element {
  std::string name{};
  std::map<std::string, std::string> attributes{};
  std::string text{};
  std::vector<Element> inside{};

  [[nodiscard]] std::string operator[](std::string_view child) const {
    const auto found = std::ranges::find(inside, child, &Element::name);
    return found == inside.end() ? "" : found->text;
  }
  [[nodiscard]] std::vector<std::string> order() const {
    std::vector<std::string> names;
    std::ranges::transform(inside, std::back_inserter(names), &Element::name);
    return names;
  }
};

/// Reads one element and advances `rest` behind it. What is no XML throws.
// NOLINTNEXTLINE(misc-no-recursion)
Element read_element(std::string& rest) {
  static const std::regex begin(R"re(\s*<([a-z-]+)((?: [a-zA-Z]+="[^"<>]*")*)>)re");
  static const std::regex attribute(R"re( ([a-zA-Z]+)="([^"]*)")re");
  std::smatch found;
  if (!std::regex_search(rest, found, begin, std::regex_constants::match_continuous)) {
    throw InputError("no element at: " + rest.substr(0, 80));
  }
  Element element{.name = found[1]};
  const std::string attributes = found[2];
  for (std::sregex_iterator one(attributes.begin(), attributes.end(), attribute), end; one != end; ++one) {
    element.attributes[(*one)[1]] = (*one)[2];
  }
  rest = found.suffix().str();
  const std::string closing = "</" + element.name + ">";
  while (!rest.starts_with(closing)) {
    const std::size_t next = rest.find('<');
    element.text += rest.substr(0, next);
    rest.erase(0, next);
    if (!rest.starts_with(closing)) {
      element.inside.push_back(read_element(rest));
      element.text.clear();
      rest.erase(0, rest.find_first_not_of(" \n"));
    }
  }
  rest.erase(0, closing.size());
  return element;
}

Element described(const std::string& command) {
  std::string text = test::expect_run(0, command + " --xml").output;
  const std::string_view declaration = R"(<?xml version="1.0" encoding="utf-8"?>)";
  EXPECT_TRUE(text.starts_with(declaration));
  text.erase(0, declaration.size());
  Element root = read_element(text);
  EXPECT_EQ(text.find_first_not_of(" \n"), std::string::npos) << "something stands behind: " << text;
  return root;
}

/// The elements of parameters, and the attributes that each may have.
const std::map<std::string, std::set<std::string>> parameter_elements{
    {"boolean", {}},
    {"integer", {"multiple"}},
    {"double", {"multiple"}},
    {"string", {"multiple"}},
    {"string-enumeration", {}},
    {"directory", {"multiple"}},
    {"file", {"multiple", "fileExtensions"}},
    {"image", {"multiple", "type", "fileExtensions"}},
    {"pointfile", {"multiple", "fileExtensions", "coordinateSystem"}},
    {"transform", {"multiple", "type", "fileExtensions"}}};

/// Checks one parameter by itself.
void expect_parameter(const Element& parameter) {
  SCOPED_TRACE(parameter.name + " " + parameter["name"]);
  ASSERT_TRUE(parameter_elements.contains(parameter.name));
  for (const auto& [attribute, value] : parameter.attributes) {
    EXPECT_TRUE(parameter_elements.at(parameter.name).contains(attribute)) << attribute;
  }
  const auto attribute = [&](const char* name) {
    const auto found = parameter.attributes.find(name);
    return found == parameter.attributes.end() ? "" : found->second;
  };
  EXPECT_THAT(attribute("multiple"), testing::AnyOf("", "true", "false"));
  if (parameter.name == "image") {
    EXPECT_THAT(attribute("type"), testing::AnyOf("scalar", "label", "vector"));
  }
  if (parameter.name == "pointfile") {
    EXPECT_EQ(attribute("coordinateSystem"), "lps");
  }
  // The order of the schema: name, flag or index, description, label, default, channel, choices.
  std::vector<std::string> order{"name", parameter["index"].empty() ? "longflag" : "index", "description",
                                 "label"};
  for (const char* const optional : {"default", "channel"}) {
    if (!parameter[optional].empty()) {
      order.emplace_back(optional);
    }
  }
  std::vector<std::string> choices;
  for (const Element& one : parameter.inside) {
    if (one.name == "element") {
      choices.push_back(one.text);
      order.emplace_back("element");
    }
  }
  EXPECT_EQ(parameter.order(), order);
  EXPECT_TRUE(std::regex_match(parameter["name"], std::regex("[_a-zA-Z][_a-zA-Z0-9]*")));
  EXPECT_TRUE(parameter["longflag"].empty() ||
              std::regex_match(parameter["longflag"], std::regex("-?-?[_a-zA-Z][_a-zA-Z0-9]*")));
  EXPECT_FALSE(parameter["description"].empty());
  const std::string value = parameter["default"];
  if (parameter.name == "boolean") {
    EXPECT_EQ(value, "false") << "a flag that is given changes something";
  } else if (parameter.name == "integer" || parameter.name == "double") {
    EXPECT_TRUE(std::regex_match(value, std::regex("-?[0-9.]+(e-?[0-9]+)?")))
        << "Slicer passes every number, so that it has a default";
  } else if (parameter.name == "string-enumeration") {
    EXPECT_THAT(choices, testing::Contains(value));
  }
  const bool is_file =
      std::set<std::string>{"directory", "file", "image", "pointfile", "transform"}.contains(parameter.name);
  EXPECT_THAT(parameter["channel"], is_file ? testing::AnyOf("input", "output") : testing::AnyOf("", ""));
}

std::vector<Element> parameters_of(const Element& module) {
  std::vector<Element> all;
  for (const Element& group : module.inside) {
    if (group.name == "parameters") {
      all.insert(all.end(), group.inside.begin() + 2, group.inside.end()); // behind label and description
    }
  }
  return all;
}

class SlicerModule : public testing::TestWithParam<std::string> {};

TEST_P(SlicerModule, IsDescribedAsTheSchemaHasIt) {
  const Element module = described(GetParam());
  EXPECT_EQ(module.name, "executable");
  const std::vector<std::string> order = module.order();
  const std::vector<std::string> head{"category", "title", "description", "version", "license"};
  ASSERT_GT(order.size(), head.size());
  EXPECT_TRUE(std::equal(head.begin(), head.end(), order.begin()));
  EXPECT_TRUE(std::all_of(order.begin() + static_cast<std::ptrdiff_t>(head.size()), order.end(),
                          [](const std::string& name) { return name == "parameters"; }));
  for (const Element& group : module.inside) {
    if (group.name == "parameters") {
      ASSERT_GE(group.inside.size(), 3U) << "a group has a parameter";
      EXPECT_EQ(group.inside[0].name, "label");
      EXPECT_EQ(group.inside[1].name, "description");
    }
  }
  std::set<std::string> names;
  int index = 0;
  for (const Element& parameter : parameters_of(module)) {
    expect_parameter(parameter);
    EXPECT_TRUE(names.insert(parameter["name"]).second) << parameter["name"] << " stands there twice";
    if (!parameter["index"].empty()) {
      EXPECT_EQ(parameter["index"], std::to_string(index++)) << "words by their places";
    }
  }
  EXPECT_GT(index, 0);
}

/// Every option of --help is a parameter, and every parameter is one that the command takes.
TEST_P(SlicerModule, HasTheOptionsOfTheCommand) {
  const std::vector<Element> parameters = parameters_of(described(GetParam()));
  std::set<std::string> described_flags;
  for (const Element& parameter : parameters) {
    if (const std::string flag = parameter["longflag"]; !flag.empty()) {
      described_flags.insert(flag);
      const std::string value = parameter.name == "boolean"    ? ""
                                : parameter["default"].empty() ? " 3"
                                                               : " " + parameter["default"];
      const test::Outcome outcome =
          test::hdmbench(fmt::format("{} nowhere nowhere {}{}", GetParam(), flag, value));
      EXPECT_EQ(outcome.status, 2) << flag;
      EXPECT_THAT(outcome.output, Not(HasSubstr("has no option"))) << flag;
      EXPECT_THAT(outcome.output, Not(HasSubstr("ould not convert"))) << flag << value;
    }
  }
  const std::string help = test::hdmbench(GetParam() + " --help").output;
  static const std::regex option("\n  (?:-h,)?(--[a-z-]+)");
  std::set<std::string> flags;
  for (std::sregex_iterator found(help.begin(), help.end(), option), end; found != end; ++found) {
    std::string flag = (*found)[1];
    std::replace(flag.begin() + 2, flag.end(), '-', '_');
    flags.insert(flag);
  }
  flags.erase("--help");
  flags.erase("--xml");
  EXPECT_EQ(described_flags, flags);
}

INSTANTIATE_TEST_SUITE_P(Commands, SlicerModule, testing::Values("run", "register", "warp"),
                         [](const auto& one) { return one.param; });

/// A panel that nobody has touched: Slicer passes what has a default, then the words by their places. The
/// second scene has a wall to slide along, which a panel gets as the scene's file.
TEST(SlicerModuleTest, PassesDefaultsThatChangeNothing) {
  const test::TemporaryFolder folder;
  std::string words = "run --xml_is_no_option";
  EXPECT_THAT(test::expect_run(2, words).output, HasSubstr("has no option"));
  words = "run";
  for (const Element& parameter : parameters_of(described("run"))) {
    if (const std::string value = parameter["default"]; parameter.name != "boolean" && !value.empty()) {
      words += fmt::format(" {} {}", parameter["longflag"],
                           parameter["longflag"] == "--output" ? (folder.path() / "out").string() : value);
    }
  }
  const fs::path slides = folder.write("slides.toml", R"(energy = "elastic"
size = [24, 24]
[[tissue]]
label = 0
modulus = 1.0
[[tissue]]
label = 1
modulus = 3.0
[[shape]]
kind = "everything"
label = 0
[[shape]]
kind = "ellipse"
centre = [0.5, 0.5]
size = [0.8, 0.8]
label = 1
[[condition]]
where = "labels"
labels = [0]
slide = true
[[condition]]
where = "labels"
labels = [1]
centre = [0.5, 0.5]
size = [0.3, 0.3]
dx = 0.5
dy = 0.0
)");
  for (const std::string& scene : {std::string("circular"), slides.string()}) {
    (void)test::expect_run(0, fmt::format("{} --no_pictures {} --size 24", words, scene));
    const auto plain = test::expect_run(0, fmt::format("run {} --size 24 --no-pictures --output {}", scene,
                                                       (folder.path() / "plain").string()));
    EXPECT_EQ(test::files_in(folder.path() / "out"), test::files_in(folder.path() / "plain"));
    EXPECT_EQ(plain.output.find("slide along walls") != std::string::npos, scene != "circular");
  }
}

} // namespace
} // namespace hdmbench
