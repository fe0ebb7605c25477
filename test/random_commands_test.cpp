// Every command with random options on small random inputs. The options come from `hdmbench COMMAND --help`,
// so a new one is tried by itself. Only what is always true is asked for: exit status 0, 1 or 2, an end in
// time, outputs that can be read, fields that are finite and no larger than the conditions, and inputs that
// nobody touched. Every case is a number: HDMBENCH_RANDOM_CASES=1000 (default 100) says how many,
// HDMBENCH_RANDOM_CASE=NUMBER repeats one.

#include "harness/scene/images/images.hpp"
#include "test/files.hpp"
#include "test/help_options.hpp"
#include "test/program.hpp"
#include "test/random_inputs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace hdmbench {
namespace {

namespace fs = std::filesystem;
using test::Draw;
using test::Inputs;
using test::Option;
using test::Words;

constexpr int usual_cases = 100;
constexpr int seconds_per_case = 120; // on a busy machine; hardly one takes 5

std::optional<int> environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::nullopt : std::optional(std::stoi(value));
}

// ---- A line of random arguments

/// What keeps a command short; an option that was drawn stands in its place.
const std::map<std::string, Words> usual{
    {"accuracy", {"--quick", "--size 12", "--backends openmp", "--repeat 1"}},
    {"atlas", {"--quick"}},
    {"bench", {"--size 16", "--backends openmp", "--repeat 1", "--no-ceilings"}},
    {"browser", {"--size 8"}},
    {"continuum", {"--sizes 8,12", "--contrasts 3"}},
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
const std::set<std::string> too_long{"accuracy --full", "devices --measure", "rivals --knobs",
                                     "rivals --spread", "golden --write",    "run --within"};

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
        {"entries", {"oscillation", "undetermined", "no-zero-step"}},
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
        {"--sites", {"0,0", "0,1", "1,0", "3,2"}},
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
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  if (bytes.substr(0, 2000).find("kinds: vector") != std::string::npos) {
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

class RandomCommands : public testing::Test {
protected:
  void try_case(int number) {
    Draw draw(number);
    const fs::path in = folder_.path() / "in";
    const fs::path out = folder_.path() / "out";
    fs::remove_all(folder_.path());
    fs::create_directories(in);
    fs::create_directories(out);
    Inputs inputs(in, results_, draw);
    const std::string command = commands_.at(static_cast<std::size_t>(number) % commands_.size());
    const std::string line = Line(command, inputs, out, draw).random(test::read_options(command), methods_);
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
    if (!have_images()) {
      GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
    }
    const fs::path results = folder_.path() / "results.json";
    test::expect_run(0, "bench square --size 9 --backends openmp --repeat 1 --no-ceilings --json " +
                            results.string());
    results_ = test::read_json(results).dump();
    commands_ = test::read_commands();
    ASSERT_GE(commands_.size(), 20U);
    const std::string listed = test::expect_run(0, "methods").output;
    const std::regex name("\n *([a-z][a-z0-9-]+)  ");
    for (std::sregex_iterator found(listed.begin(), listed.end(), name), end; found != end; ++found) {
      methods_.push_back((*found)[1]);
    }
    ASSERT_GE(methods_.size(), 6U) << listed;
  }

  test::TemporaryFolder folder_;
  std::string results_; ///< of bench
  Words commands_;
  Words methods_;
  std::map<int, int> counts_; ///< by exit status
};

TEST_F(RandomCommands, EndWithAStatusAndReadableOutputs) {
  if (const auto one = environment("HDMBENCH_RANDOM_CASE")) {
    try_case(*one);
    return;
  }
  const int cases = environment("HDMBENCH_RANDOM_CASES").value_or(usual_cases);
  for (int number = 0; number < cases && !HasFailure(); ++number) {
    try_case(number);
  }
  fmt::print("{} commands ended with 0, {} with 1, {} with 2\n", counts_[0], counts_[1], counts_[2]);
  EXPECT_GT(4 * (counts_[0] + counts_[1]), cases) << "most lines are refused: what is tried says little";
}

} // namespace
} // namespace hdmbench
