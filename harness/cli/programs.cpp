#include "harness/cli/programs.hpp"

#include "backends/shared/subprocess.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/pairs.hpp"

#include <random>
#include <sstream>

namespace hdmbench::commands {

namespace {

const Option<double> tolerance("--tolerance", "Percent by which a time may grow", 5.0,
                               CLI::Range(0.1, 1000.0));
const Option<int> pairs("--pairs", "How often both programs run each case", 20, CLI::Range(1, 10'000));
const Option<bool> strict("--strict", "Inconclusive is exit status 1, too");

/// What the pairs of one case are.
struct Compared {
  json row;
  std::vector<double> old_seconds{};
  std::vector<double> new_seconds{};
  std::string failure{}; ///< of one of the programs
};

/// The words of a command line that has no quotes around spaces of its own: a shell's words.
std::vector<std::string> words_of(const std::string& line) {
  return CLI::detail::split_up(line);
}

/// Seconds of a case by a program. Throws InputError where the program cannot be started; DeviceError where
/// it has no time of the case.
double seconds_by(const std::string& program, const json& row) {
  const TemporaryDirectory folder;
  const auto file = folder.path() / "bench.json";
  std::vector<std::string> words = words_of(row["command"]);
  words.front() = program;
  const std::vector<std::string> more{"--reference", "none",   "--no-ceilings", "--repeat",
                                      "3",           "--json", file.string()};
  words.insert(words.end(), more.begin(), more.end());
  const auto errors = folder.path() / "errors.txt";
  const ProcessEnd end = run_process(words, "/dev/null", errors);
  if (!end.good() || !std::filesystem::exists(file)) {
    throw DeviceError(fmt::format("{} {}: {}", program, end.text(), file_text(errors)));
  }
  for (const json& one : read_results(file).results) {
    if (one["work"] == row["work"] && !one["seconds"].empty()) {
      return one["seconds_median"];
    }
  }
  throw DeviceError(fmt::format("{} did not time it", program));
}

/// One more pair, in an order that `random` says.
void add_pair(Compared& one, const std::array<std::string, 2>& programs, std::mt19937& random) {
  if (!one.failure.empty()) {
    return;
  }
  try {
    const bool new_first = random() % 2 == 1;
    const double first = seconds_by(programs[new_first ? 1 : 0], one.row);
    const double second = seconds_by(programs[new_first ? 0 : 1], one.row);
    one.old_seconds.push_back(new_first ? second : first);
    one.new_seconds.push_back(new_first ? first : second);
  } catch (const DeviceError& error) {
    one.failure = error.what();
  }
}

json judged(const Compared& one, double borne, std::size_t cases) {
  json row = with_size({}, {one.row["width"], one.row["height"], one.row.value("depth", 1)});
  for (const char* const key : {"scene", "backend", "method", "work", "threads", "command"}) {
    row[key] = one.row[key];
  }
  std::vector<double> ratios;
  std::ranges::transform(one.new_seconds, one.old_seconds, std::back_inserter(ratios), std::divides());
  const Change change = judge_pairs(ratios, borne, cases);
  row.update({{"old_s", median(one.old_seconds)},
              {"new_s", median(one.new_seconds)},
              {"ratio", median(ratios)},
              {"ratios", ratios},
              {"verdict", one.failure.empty() ? change_names.at(static_cast<std::size_t>(change)) : "failed"},
              {"reason", one.failure}});
  return row;
}

} // namespace

Options comparison_of_programs() {
  return Options{against, tolerance, pairs, strict}.under("Compare two programs");
}

int compare_programs(const Call& call, const json& rows) {
  std::vector<Compared> cases;
  for (const json& row : rows) {
    if (row["reason"] == "") {
      cases.push_back({.row = row});
    }
  }
  const std::array programs{std::filesystem::absolute(call[against]).string(),
                            std::filesystem::read_symlink("/proc/self/exe").string()};
  const std::size_t fewest = fewest_pairs(cases.size());
  const auto count = static_cast<std::size_t>(call[pairs]);
  if (count < fewest) {
    throw InputError(
        fmt::format("--pairs {}: of {} cases fewer than {} pairs can show nothing; give more, or name "
                    "fewer scenes, sizes or --backends",
                    count, cases.size(), fewest));
  }
  std::mt19937 random(1);
  Progress progress;
  progress.set_total(static_cast<double>(count * cases.size()));
  for (std::size_t pair = 0; pair < count; ++pair) {
    for (Compared& one : cases) {
      progress.describe(fmt::format("pair {} of {}: {} on {}", pair + 1, count,
                                    one.row["scene"].get<std::string>(),
                                    one.row["backend"].get<std::string>()));
      add_pair(one, programs, random);
      progress.advance(1.0);
    }
  }
  progress.clear();
  json results = json::array();
  std::ranges::transform(cases, std::back_inserter(results), [&](const Compared& one) {
    return judged(one, call[tolerance] / 100.0, cases.size());
  });
  const auto of = [&](std::string_view verdict) {
    return std::ranges::count_if(results, [&](const json& row) { return row["verdict"] == verdict; });
  };
  fmt::print("old: {}\nnew: {}\n\n{}\n", programs[0], programs[1],
             table_text(results, "scene|size|backend|work|threads|old_s|new_s|ratio:new/old|verdict"));
  for (const json& row : results) {
    if (row["verdict"] == "failed") {
      fmt::print("{}", row_text("  {scene} on {backend}: {reason}\n", row));
    }
  }
  fmt::print("{} pairs each, sign test: {} faster, {} not slower by more than {:.3g} %, {} slower, {} "
             "inconclusive.\n",
             count, of("faster"), of("not slower"), call[tolerance], of("slower"), of("inconclusive"));
  const bool is_bad = of("slower") + of("failed") + (call[strict] ? of("inconclusive") : 0) > 0;
  call.write(std::move(results), "against");
  return is_bad ? disagreement : success;
}

} // namespace hdmbench::commands
