// Every command with random options on small random inputs. The options come from `hdmbench COMMAND --help`,
// so a new one is tried by itself; random_commands.toml has what they are given. Only what is always true is
// asked for: exit status 0, 1 or 2, an end in time, outputs that can be read, fields that are finite and no
// larger than the conditions, and inputs that nobody touched. Every case is a number:
// HDMBENCH_RANDOM_CASES=1000 (default 100) says how many, HDMBENCH_RANDOM_CASE=NUMBER repeats one.

#include "test/files.hpp"
#include "test/person.hpp"
#include "test/program.hpp"

#include <toml++/toml.h>

#include <regex>

namespace hdmbench {
namespace {

using Words = std::vector<std::string>;
using WordsByName = std::map<std::string, Words>;

constexpr int usual_cases = 100;
constexpr int seconds_per_case = 120; // on a busy machine; hardly one takes 5
constexpr double farthest = 8.0;      // pixels, of what random_commands.toml pulls

/// A table of random_commands.toml.
WordsByName words_of(const char* table) {
  static const toml::table data = toml::parse_file(HDMBENCH_SOURCE "/test/random_commands.toml");
  WordsByName result;
  for (const auto& [name, value] : *data[table].as_table()) {
    value.as_array()->for_each(
        [&](const toml::value<std::string>& one) { result[std::string(name.str())].push_back(one.get()); });
  }
  return result;
}

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

Words split(const std::string& text, char border) {
  std::istringstream stream(text);
  Words words;
  for (std::string word; std::getline(stream, word, border);) {
    words.push_back(word);
  }
  return words;
}

/// "--threads INT:INT in [0 - 4096]"
Option read_option(const std::string& line) {
  Option option;
  std::istringstream words(line);
  std::string names;
  words >> names >> option.type;
  option.names = split(names, ',');
  std::smatch found;
  if (std::regex_search(line, found, std::regex("\\{([^}]*)\\}"))) {
    for (const std::string& choice : split(found[1], ',')) {
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
  std::vector<Option> options;
  for (const std::string& line : split(test::expect_run(0, command + " --help").output, '\n')) {
    static const std::regex begins("^  (--)?[a-z][a-z-]*.*");
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

/// The first groups of what matches in what the program says.
Words found_in(const std::string& arguments, const char* after, const char* pattern) {
  std::string text = test::expect_run(0, arguments).output;
  text.erase(0, std::min(text.find(after), text.size()));
  const std::regex name(pattern);
  Words words;
  for (std::sregex_iterator found(text.begin(), text.end(), name), end; found != end; ++found) {
    words.push_back((*found)[1]);
  }
  return words;
}

// ---- Lines and files

/// The same draws on every machine.
class Draw {
public:
  Draw(int seed, const WordsByName& rules) : engine_(static_cast<std::uint64_t>(seed)), rules_(rules) {}

  int operator()(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  template <typename Value>
  Value one_of(const std::vector<Value>& values) {
    return values.at(static_cast<std::size_t>((*this)(0, static_cast<int>(values.size()) - 1)));
  }

  /// With what <...> stands for in its places.
  std::string expand(const std::string& rule) {
    static const std::regex place("<([^<>]*)>");
    std::string text;
    auto from = rule.cbegin();
    for (std::smatch found; std::regex_search(from, rule.cend(), found, place); from = found[0].second) {
      text.append(from, found[0].first);
      const std::string word = found[1];
      const std::size_t dots = word.find("..");
      text += dots == word.npos ? expand(one_of(rules_.at(word)))
                                : number(word.substr(0, dots), word.substr(dots + 2));
    }
    return text.append(from, rule.cend());
  }

private:
  std::string number(const std::string& low, const std::string& high) {
    if (low.find('.') == low.npos) {
      return fmt::format("{}", (*this)(std::stoi(low), std::stoi(high)));
    }
    const double span = std::stod(high) - std::stod(low);
    return fmt::format("{:.4f}", std::stod(low) + span * (*this)(0, 1000) / 1000.0);
  }

  std::mt19937_64 engine_;
  const WordsByName& rules_;
};

class Line {
public:
  Line(std::string command, const WordsByName& rules, Draw& draw)
      : command_(std::move(command)), rules_(rules), draw_(draw) {}

  std::string random() {
    const WordsByName usual = words_of("usual");
    const Words too_long = words_of("too_long").at("options");
    Words words{command_};
    const int share = draw_(0, 6); // of the options: some lines have few, some have many
    std::set<std::string> drawn;
    for (const Option& option : read_options(command_)) {
      const std::string name = draw_.one_of(option.names);
      // Without a scene commands take large ones of their own.
      const bool wanted = option.required || !name.starts_with("--") || draw_(1, 40) <= share;
      if (name == "--help" || name == "-h" || !wanted ||
          std::ranges::count(too_long, command_ + " " + name) > 0) {
        continue;
      }
      drawn.insert(option.names.begin(), option.names.end());
      if (name.starts_with("--")) {
        words.push_back(name);
      }
      for (int i = 0; i < option.values && !option.type.empty(); ++i) {
        words.push_back(fmt::format("'{}'", value(option)));
      }
    }
    if (const auto found = usual.find(command_); found != usual.end()) {
      std::ranges::copy_if(found->second, std::back_inserter(words), [&](const std::string& one) {
        return !drawn.contains(one.substr(0, one.find(' ')));
      });
    }
    return fmt::format("{}", fmt::join(words, " "));
  }

private:
  std::string value(const Option& option) {
    if (draw_(1, 25) == 1) {
      return draw_.expand("<a mistake>");
    }
    if (!option.choices.empty()) {
      return draw_.one_of(option.choices);
    }
    const bool whole = option.type.find("INT") != std::string::npos;
    if (option.low) {
      const double near = std::min(*option.low + (whole ? draw_(0, 3) : 2.5), *option.high);
      return fmt::format("{}", whole ? near : draw_.one_of(std::vector{*option.low, near, *option.high}));
    }
    return whole                              ? draw_.expand("<0..9>")
           : option.type.starts_with("FLOAT") ? draw_.expand("<a number>")
                                              : text(option);
  }

  /// Of a TEXT: by its name, else any word of its description or any file.
  std::string text(const Option& option) {
    const std::string& name = option.names.back();
    for (const std::string& key : {command_ + " " + name, name}) {
      if (rules_.contains(key)) {
        return draw_.expand(fmt::format("<{}>", key));
      }
    }
    if (option.description.find("Write") != std::string::npos ||
        option.description.find("Also a") != std::string::npos) {
      return draw_.expand("<out>/written.png");
    }
    Words pool;
    for (const auto& file : fs::directory_iterator(rules_.at("in").front())) {
      pool.push_back(file.path());
    }
    std::ranges::sort(pool);
    static const std::regex marks("['\"();:,]");
    std::istringstream words(std::regex_replace(option.description, marks, ""));
    for (std::string word; words >> word;) {
      pool.push_back(word);
    }
    return draw_.one_of(pool);
  }

  std::string command_;
  const WordsByName& rules_;
  Draw& draw_;
};

// ---- What must hold

void expect_finite(const std::vector<float>& values, const fs::path& file) {
  EXPECT_TRUE(std::ranges::all_of(values, [](float value) { return std::isfinite(value); })) << file;
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
      for (const nlohmann::json& row : document.at("results")) {
        // Of `run`: no tissue goes further than what pulls it, or the row says why.
        if (row.contains("largest_displacement") && row.contains("mean_energy") && row["warnings"].empty()) {
          EXPECT_LE(row["largest_displacement"], 1.5 * farthest + 1.0) << row;
        }
      }
    } else if (file.extension() != ".nrrd" || file.stem() == "row") {
      EXPECT_GT(fs::file_size(file), 0U) << file;
    } else if (content(file).substr(0, 2000).find("kinds: vector") != std::string::npos) {
      const VectorField field = read_vector(file).pixels;
      expect_finite(field[0], file);
      expect_finite(field[1], file);
    } else {
      expect_finite(read_scalar(file).pixels.values, file);
    }
  }
}

class RandomCommands : public ImageFiles {
protected:
  void try_case(int number) {
    const fs::path in = path("in");
    const fs::path out = path("out");
    Draw draw(number, rules_);
    for (const fs::path& folder : {in, out}) {
      fs::remove_all(folder);
      fs::create_directories(folder);
    }
    test::write_person(in, 40, {}, 1.0);
    fs::copy_file(path("results.json"), in / "results.json");
    for (const auto& [name, text] : words_of("files")) {
      std::ofstream(in / name, std::ios::binary) << draw.expand(text.front());
    }
    const std::string command = commands_.at(static_cast<std::size_t>(number) % commands_.size());
    const std::string line = Line(command, rules_, draw).random();
    SCOPED_TRACE(
        fmt::format("hdmbench {}\nto repeat it: HDMBENCH_RANDOM_CASE={} random_commands_test", line, number));
    const auto before = test::files_in(in);
    const test::Outcome outcome =
        test::hdmbench(line, fmt::format("cd '{}' && timeout {}", out.string(), seconds_per_case));
    EXPECT_THAT(outcome.status, testing::AnyOf(0, 1, 2)) << outcome.output; // 124: it did not end in time
    EXPECT_THAT(outcome.output, testing::Not(testing::AnyOf(testing::HasSubstr("internal error"),
                                                            testing::ContainsRegex("[0-9]{20}"))));
    EXPECT_FALSE(outcome.output.empty());
    ++counts_[outcome.status];
    EXPECT_TRUE(before == test::files_in(in)) << "an input is another one now";
    ASSERT_NO_THROW(expect_readable_outputs(out)) << outcome.output;
  }

  void SetUp() override {
    ImageFiles::SetUp();
    if (IsSkipped()) {
      return;
    }
    test::expect_run(0, "bench square --size 9 --backends openmp --repeat 1 --no-ceilings --json " +
                            path("results.json").string());
    commands_ = found_in("--help", "Solve:", "\n  ([a-z][a-z-]*)");
    ASSERT_GE(commands_.size(), 20U);
    rules_ = words_of("rules");
    rules_["in"] = {path("in").string()};
    rules_["out"] = {path("out").string()};
    rules_["a mistake"].emplace_back("\xff"); // no text
    rules_["method"] = found_in("methods", "", "\n *([a-z][a-z0-9-]+)  ");
    ASSERT_GE(rules_["method"].size(), 6U);
  }

  Words commands_;
  WordsByName rules_;
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
