#include "harness/comparison/interleave.hpp"

#include "harness/subprocess.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <span>

namespace hdmbench::comparison {

namespace {

std::string line_of(const Words& words) {
  std::string line;
  for (const std::string& word : words) {
    line += (line.empty() ? "" : " ") + word;
  }
  return line;
}

void append(std::vector<report::BenchRow>& rows, report::Context& context, report::Results found) {
  std::ranges::move(found.bench, std::back_inserter(rows));
  context = found.contexts.back();
}

} // namespace

report::Results run_bench(const std::filesystem::path& program, const Words& words, int repeats) {
  const TemporaryDirectory folder;
  const std::filesystem::path output = folder.path() / "output.txt";
  const std::filesystem::path errors = folder.path() / "errors.txt";
  const std::filesystem::path json = folder.path() / "bench.json";
  Words line{program.string(), "bench"};
  line.insert(line.end(), words.begin(), words.end());
  line.insert(line.end(), {"--repeat", std::to_string(repeats), "--json", json.string()});
  const ProcessEnd end = run_process(line, output, errors);
  // Status 1 is a field that disagrees: its row says so. Status 2 with a file, a device that failed.
  if (end.signal != 0 || !std::filesystem::exists(json)) {
    throw InputError(
        fmt::format("{} failed ({}): {}", line_of(line), end.text(), file_text(errors) + file_text(output)));
  }
  return report::load_results(std::array{json});
}

BothSides interleave(const std::filesystem::path& first, const std::filesystem::path& second,
                     const std::vector<Words>& runs, int samples, Progress& progress) {
  BothSides found;
  progress.set_total(2.0 * samples * static_cast<double>(runs.size()));
  for (const Words& words : runs) {
    for (int sample = 0; sample < samples; ++sample) {
      for (int turn = 0; turn < 2; ++turn) {
        const bool old = (sample + turn) % 2 == 0;
        progress.describe(fmt::format("compare {}: sample {} of {}, {}", line_of(words), sample + 1, samples,
                                      old ? "old" : "new"));
        report::Results results = run_bench(old ? first : second, words, 1);
        append(old ? found.first : found.second, old ? found.first_context : found.second_context,
               std::move(results));
        progress.advance(1.0);
      }
    }
  }
  return found;
}

} // namespace hdmbench::comparison
