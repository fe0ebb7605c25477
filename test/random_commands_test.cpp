// Every command with random options on small random inputs. The options come from `hdmbench COMMAND --help`,
// so a new one is tried by itself. Only what is always true is asked for: exit status 0, 1 or 2, an end in
// time, outputs that can be read, fields that are finite and no larger than the conditions, and inputs that
// nobody touched. Every case is a number: HDMBENCH_RANDOM_CASES=1000 (default 100) says how many,
// HDMBENCH_RANDOM_CASE=NUMBER repeats one.

#include "test/files.hpp"
#include "test/person.hpp"
#include "test/program.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace hdmbench {
namespace {

using Words = std::vector<std::string>;

constexpr int usual_cases = 100;
constexpr int seconds_per_case = 120; // on a busy machine; hardly one takes 5

// ---- What can be typed, as `hdmbench --help` and `hdmbench COMMAND --help` have it

struct Option {
  Words names; ///< "--size", or one word where it is positional
  std::string type{};
  Words choices{};
  std::optional<double> low{};
  std::optional<double> high{};
  int values = 1;
  bool required = false;
  std::string description{};
};

/// "--threads INT:INT in [0 - 4096]"
Option read_option(const std::string& line) {
  Option option;
  std::istringstream words(line);
  std::string names;
  words >> names >> option.type;
  std::istringstream each(names);
  for (std::string name; std::getline(each, name, ',');) {
    if (name != "-h") {
      option.names.push_back(name);
    }
  }
  std::smatch found;
  if (std::regex_search(line, found, std::regex("\\{([^}]*)\\}"))) {
    std::istringstream list(found[1]);
    for (std::string choice; std::getline(list, choice, ',');) {
      option.choices.push_back(choice.substr(0, choice.find("->")));
    }
  }
  if (std::regex_search(line, found, std::regex("in \\[([^ ]+) - ([^\\]]+)\\]"))) {
    option.low = std::stod(found[1]);
    option.high = std::stod(found[2]);
  }
  if (std::regex_search(line, found, std::regex(" x ([0-9]+)"))) {
    option.values = std::stoi(found[1]);
  }
  option.required = line.find("REQUIRED") != std::string::npos;
  return option;
}

std::vector<Option> read_options(const std::string& command) {
  std::istringstream help(test::expect_run(0, command + " --help").output);
  std::vector<Option> options;
  for (std::string line; std::getline(help, line);) {
    static const std::regex begins("^  (-h,)?(--)?[a-z][a-z-]*.*");
    if (line.starts_with("    ") && !options.empty()) {
      options.back().description += line;
    } else if (std::regex_match(line, begins)) {
      const std::size_t gap = line.find("  ", 2);
      options.push_back(read_option(line.substr(2, gap == std::string::npos ? gap : gap - 2)));
      options.back().description = gap == std::string::npos ? "" : line.substr(gap);
    }
  }
  return options;
}

Words read_commands() {
  std::istringstream help(test::expect_run(0, "--help").output);
  Words commands;
  bool listed = false;
  for (std::string line; std::getline(help, line);) {
    std::smatch found;
    if (listed && std::regex_search(line, found, std::regex("^  ([a-z][a-z-]*)"))) {
      commands.push_back(found[1]);
    }
    listed = listed || line.starts_with("Subcommands");
  }
  return commands;
}

// ---- Small random files

/// The same draws on every machine.
class Draw {
public:
  explicit Draw(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}
  int operator()(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool once_in(int times) { return (*this)(1, times) == 1; }
  template <typename Values>
  auto one_of(const Values& values) {
    return *std::next(values.begin(), (*this)(0, static_cast<int>(values.size()) - 1));
  }

private:
  std::mt19937_64 engine_;
};

/// What a case reads: images of a person before and after, scenes, lists, results.
class Inputs {
public:
  Inputs(const fs::path& folder, const std::string& results, Draw& draw) : folder_(folder), draw_(draw) {
    test::write_person(folder, 40, {}, 1.0);
    scenes_ = {write("scene-0.toml", scene_text()), write("scene-1.toml", scene_text()), file("person.toml")};
    (void)write("nodes.txt", "1,0,0,0.5,0\n2,10,0,0.5,1\n3,0,10,0,0\n4,10,10,1,1\n");
    (void)write("elements.txt", "1,1,2,4,3\n");
    (void)write("results.json", results);
  }

  [[nodiscard]] std::string scene() { return draw_.one_of(scenes_); }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] Words all() const {
    Words names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.push_back(entry.path().string());
    }
    std::ranges::sort(names);
    return names;
  }
  /// Their bytes by name.
  [[nodiscard]] std::map<std::string, std::string> bytes() const {
    std::map<std::string, std::string> result;
    for (const std::string& name : all()) {
      result[name] = content(name);
    }
    return result;
  }

  /// No target and no start is further than that, pixels.
  static constexpr int farthest = 8;

private:
  static constexpr std::string_view tissues =
      "[[tissue]]\nlabel = 0\nmodulus = 10.0\n[[tissue]]\nlabel = 1\nmodulus = 20.0\n";

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return file(name);
  }

  std::string number(double low, double high) {
    return fmt::format("{:.4f}", low + (high - low) * draw_(0, 1000) / 1000.0);
  }

  std::string conditions() {
    std::string text;
    for (int count = draw_(1, 3); count > 0; --count) {
      const std::string where = draw_.one_of(Words{"left", "right", "top", "bottom", "border"});
      text += fmt::format("[[condition]]\nwhere = \"{}\"\n", where);
      text += draw_.once_in(4) ? fmt::format("outward = {}\n", number(-farthest, farthest))
                               : fmt::format("dx = {}\ndy = {}\n", number(-farthest, farthest),
                                             number(-farthest, farthest));
      text += draw_.once_in(3) ? fmt::format("confidence = {}\n", number(0.0, 1.0)) : "";
    }
    return text;
  }

  std::string scene_text() {
    std::string text = fmt::format("size = [{}, {}]\n", draw_(1, 24), draw_(1, 24));
    text += draw_.once_in(3) ? fmt::format("spacing = {}\n", number(0.1, 3.0)) : "";
    text += draw_.once_in(3) ? fmt::format("poisson = {}\n", number(-0.5, 0.5)) : "";
    const bool elastic = draw_.once_in(4);
    text += elastic ? "energy = \"elastic\"\n"
                    : fmt::format("penalty = {}\n[schedule]\niterations = {}\nalignment = \"{}\"\n",
                                  number(0.1, 1000.0), draw_(0, 30), draw_.one_of(Words{"corner", "center"}));
    if (draw_.once_in(3)) {
      text += fmt::format("[random]\nseed = {}\nmodulus = [1.0, {}]\ndisplacement = {}\nobserved = {}\n",
                          draw_(0, 99), number(1.0, 1000.0), number(0.0, farthest), number(0.0, 1.0));
    } else {
      text += fmt::format(
          "[[shape]]\nkind = \"everything\"\nlabel = 0\n[[shape]]\nkind = \"ellipse\"\nlabel = 1\n"
          "centre = [{}, 0.5]\nsize = [0.4, {}]\n{}",
          number(0.0, 1.0), number(0.1, 1.0), tissues);
    }
    return text + conditions();
  }

  fs::path folder_;
  Draw& draw_;
  Words scenes_;
};

// ---- A line of random arguments

/// What keeps a command short; an option that was drawn stands in its place.
const std::map<std::string, Words> usual{
    {"accuracy", {"--quick", "--size 12", "--backends openmp", "--repeat 1"}},
    {"atlas", {"--quick"}},
    {"bench", {"--size 16", "--backends openmp", "--repeat 1", "--no-ceilings"}},
    {"browser", {"--size 8"}},
    {"continuum", {"--sizes 8,12"}},
    {"detect", {"--simulations 3"}},
    {"energy-plot", {"--points 5"}},
    {"faults", {"--faults nan-at-one-site", "--size 24"}},
    {"golden", {"--backends openmp"}},
    {"implementations", {"--size 8", "--backends openmp", "--limit-seconds 30"}},
    {"probe", {"--backends openmp"}},
    {"rivals", {"--quick", "--size 40"}},
    {"tradeoff", {"--quick", "--size 12", "--backends openmp"}},
    {"tune", {"--evaluations 4", "--size 12"}},
    {"verify", {"--size 12", "--backends openmp"}},
};

/// Not tried, because they take long whatever else is said.
const std::set<std::string> too_long{"accuracy --full", "rivals --knobs", "rivals --spread", "golden --write",
                                     "run --within"};

class Line {
public:
  Line(std::string command, Inputs& inputs, const fs::path& output, Draw& draw)
      : command_(std::move(command)), inputs_(inputs), output_(output), draw_(draw) {}

  std::string random(const std::vector<Option>& options, const Words& methods) {
    methods_ = methods;
    Words words{command_};
    const int share = draw_(0, 6); // of the options: some lines have few, some have many
    std::set<std::string> drawn;
    for (const Option& option : options) {
      const std::string name = draw_.one_of(option.names);
      // Without a scene commands take large ones of their own.
      const bool wanted = option.required || !name.starts_with("--") || draw_(1, 40) <= share;
      if (name == "--help" || !wanted || too_long.contains(command_ + " " + name)) {
        continue;
      }
      drawn.insert(option.names.begin(), option.names.end());
      if (name.starts_with("--")) {
        words.push_back(name);
      }
      for (int i = 0; i < option.values && !option.type.empty(); ++i) {
        words.push_back(quoted(value(option)));
      }
    }
    if (const auto found = usual.find(command_); found != usual.end()) {
      for (const std::string& one : found->second) {
        if (!drawn.contains(one.substr(0, one.find(' ')))) {
          words.push_back(one);
        }
      }
    }
    return fmt::format("{}", fmt::join(words, " "));
  }

private:
  static std::string quoted(const std::string& word) { return "'" + word + "'"; }

  std::string output_file(const char* name) { return (output_ / name).string(); }

  std::string value(const Option& option) {
    if (draw_.once_in(25)) {
      return draw_.one_of(Words{"", "nan", "-1", "1e30", "x", "0", "no-such-file", "1,,2", "\xff"});
    }
    if (!option.choices.empty()) {
      return draw_.one_of(option.choices);
    }
    const bool whole = option.type.find("INT") != std::string::npos;
    if (option.low) {
      return whole ? fmt::format("{:.0f}", std::min(*option.low + draw_(0, 3), *option.high))
                   : fmt::format("{}",
                                 draw_.one_of(std::vector<double>{
                                     *option.low, std::min(*option.low + 2.5, *option.high), *option.high}));
    }
    if (whole) {
      return fmt::format("{}", draw_(0, 9));
    }
    if (option.type.starts_with("FLOAT")) {
      return draw_.one_of(Words{"0", "0.01", "0.5", "0.9", "1", "1.9", "3", "1000", "-2"});
    }
    return text(option);
  }

  /// Of a TEXT: by its name, else any word of its description or any file.
  std::string text(const Option& option) {
    const std::string& name = option.names.back();
    const bool writes = option.description.find("Write") != std::string::npos ||
                        option.description.find("Also a") != std::string::npos;
    const std::string person = inputs_.file("person.toml");
    const std::map<std::string, Words> known{
        {"rivals scene", {person}},
        {"golden scenes", {"square", "tie-rich"}},
        {"entries", {"oscillation", "undetermined", "layers"}},
        {"--faults", {"nan-at-one-site", "drift", "sound"}},
        {"scene", {inputs_.scene()}},
        {"scenes", {inputs_.scene()}},
        {"--scene", {person, person, person, inputs_.scene()}},
        {"--other", {person}},
        {"source", {inputs_.file("source.nrrd")}},
        {"target", {inputs_.file("target.nrrd"), inputs_.file("target.nrrd"), inputs_.file("source.nrrd")}},
        {"--roi", {inputs_.file("region.nrrd")}},
        {"nodes", {inputs_.file("nodes.txt")}},
        {"--elements", {inputs_.file("elements.txt")}},
        {"input", {inputs_.file("positions.nrrd")}},
        {"results", {inputs_.file("results.json")}},
        {"--compare", {inputs_.file("results.json")}},
        {"--with", {inputs_.file("results.json")}},
        {"--json", {output_file("row.json")}},
        {"--output", {output_file("out")}},
        {"fem-to-image --output", {output_file("out.nrrd"), output_file("out")}},
        {"output", {output_file("positions.nrrd")}},
        {"fem-to-image --size", {"9", "16", "24x17"}},
        {"--steps", {"thesis", "fine", "0,-1,1", "0.5"}},
        {"--at", {"0.5px", "0.1px"}},
        {"--size", {"1", "2", "9", "16", "24x17", "1x9", "33"}},
        {"--sizes", {"9", "16", "24x17"}},
        {"--backend", {"openmp", "scalar", "openmp", "scalar", "opencl", "gl-compute"}},
        {"--backends", {"openmp", "scalar"}},
        {"--require", {"openmp", "scalar"}},
        {"--device", {"0"}},
        {"--method", methods_},
        {"--methods", methods_},
        {"--sites", {"0", "1", "2", "3"}},
        {"--accuracy", {"0.5px", "0.01px", "3px"}},
        {"--truth", {"fem", inputs_.file("positions.nrrd")}},
    };
    if (writes && !known.contains(name)) {
      return output_file("written.png");
    }
    for (const std::string& key : {command_ + " " + name, name}) {
      if (const auto found = known.find(key); found != known.end()) {
        return draw_.one_of(found->second);
      }
    }
    Words pool = inputs_.all();
    std::istringstream words(option.description);
    for (std::string word; words >> word;) {
      word.erase(std::remove_if(
                     word.begin(), word.end(),
                     [](char c) { return std::string_view("'\"();:,").find(c) != std::string_view::npos; }),
                 word.end());
      pool.push_back(word);
    }
    return draw_.one_of(pool);
  }

  std::string command_;
  Inputs& inputs_;
  fs::path output_;
  Draw& draw_;
  Words methods_;
};

// ---- What must hold

bool is_finite(const std::vector<float>& values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

void expect_readable_image(const fs::path& file) {
  if (content(file).substr(0, 2000).find("kinds: vector") != std::string::npos) {
    const VectorField field = read_vector(file).pixels;
    EXPECT_TRUE(is_finite(field.x) && is_finite(field.y)) << file;
  } else {
    EXPECT_TRUE(is_finite(read_scalar(file).pixels.values)) << file;
  }
}

/// Of `run`: no tissue goes further than what pulls it, or the row says why.
void expect_in_range(const nlohmann::json& row) {
  if (row.contains("largest_displacement") && row.contains("mean_energy") && row["warnings"].empty()) {
    EXPECT_LE(row["largest_displacement"], 1.5 * Inputs::farthest + 1.0) << row;
  }
}

void expect_readable_outputs(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& file = entry.path();
    EXPECT_EQ(file.string().find("partial"), std::string::npos) << file;
    if (entry.is_directory()) {
      continue;
    }
    if (file.extension() == ".json") {
      const nlohmann::json document = test::read_json(file);
      EXPECT_EQ(document.at("schema"), 1) << file;
      std::ranges::for_each(document.at("results"), expect_in_range);
    } else if (file.extension() == ".nrrd" && file.stem() != "row") {
      expect_readable_image(file);
    } else {
      EXPECT_GT(fs::file_size(file), 0U) << file;
    }
  }
}

class RandomCommands : public ImageFiles {
protected:
  void try_case(int number) {
    Draw draw(number);
    const fs::path in = path("in");
    const fs::path out = path("out");
    fs::remove_all(in);
    fs::remove_all(out);
    fs::create_directories(in);
    fs::create_directories(out);
    Inputs inputs(in, results_, draw);
    const std::string command = commands_.at(static_cast<std::size_t>(number) % commands_.size());
    const std::string line = Line(command, inputs, out, draw).random(read_options(command), methods_);
    SCOPED_TRACE(
        fmt::format("hdmbench {}\nto repeat it: HDMBENCH_RANDOM_CASE={} random_commands_test", line, number));
    const auto before = inputs.bytes();
    const test::Outcome outcome =
        test::hdmbench(line, fmt::format("cd '{}' && timeout {}", out.string(), seconds_per_case));
    EXPECT_THAT(outcome.status, testing::AnyOf(0, 1, 2)) << outcome.output; // 124: it did not end in time
    EXPECT_THAT(outcome.output, testing::Not(testing::AnyOf(testing::HasSubstr("internal error"),
                                                            testing::ContainsRegex("[0-9]{20}"))));
    EXPECT_FALSE(outcome.output.empty());
    ++counts_[outcome.status];
    EXPECT_TRUE(before == inputs.bytes()) << "an input is another one now";
    ASSERT_NO_THROW(expect_readable_outputs(out)) << outcome.output;
  }

  void SetUp() override {
    ImageFiles::SetUp();
    if (IsSkipped()) {
      return;
    }
    const fs::path results = path("results.json");
    test::expect_run(0, "bench square --size 9 --backends openmp --repeat 1 --no-ceilings --json " +
                            results.string());
    results_ = test::read_json(results).dump();
    commands_ = read_commands();
    ASSERT_GE(commands_.size(), 20U);
    const std::string listed = test::expect_run(0, "methods").output;
    const std::regex name("\n *([a-z][a-z0-9-]+)  ");
    for (std::sregex_iterator found(listed.begin(), listed.end(), name), end; found != end; ++found) {
      methods_.push_back((*found)[1]);
    }
    ASSERT_GE(methods_.size(), 6U) << listed;
  }

  std::string results_; ///< of bench
  Words commands_;
  Words methods_;
  std::map<int, int> counts_; ///< by exit status
};

TEST_F(RandomCommands, EndWithAStatusAndReadableOutputs) {
  if (const char* const one = std::getenv("HDMBENCH_RANDOM_CASE")) {
    return try_case(std::stoi(one));
  }
  const char* const wanted = std::getenv("HDMBENCH_RANDOM_CASES");
  const int cases = wanted == nullptr ? usual_cases : std::stoi(wanted);
  for (int number = 0; number < cases && !HasFailure(); ++number) {
    try_case(number);
  }
  fmt::print("{} commands ended with 0, {} with 1, {} with 2\n", counts_[0], counts_[1], counts_[2]);
  EXPECT_GT(4 * (counts_[0] + counts_[1]), cases) << "most lines are refused: what is tried says little";
}

} // namespace
} // namespace hdmbench
