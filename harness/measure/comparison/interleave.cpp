#include "harness/measure/comparison/interleave.hpp"

#include "harness/measure/result_file.hpp"
#include "harness/measure/subprocess.hpp"
#include "harness/scene/temporary_directory.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <iterator>
#include <utility>

namespace hdmbench::comparison {

namespace {

std::string line_of(const Words& words) {
  std::string line;
  for (const std::string& word : words) {
    line += (line.empty() ? "" : " ") + word;
  }
  return line;
}

} // namespace

void Side::append(Side side) {
  std::ranges::move(side.rows, std::back_inserter(rows));
  context = std::move(side.context);
}

Side load_bench(const std::filesystem::path& file) {
  const ResultFile results = read_results(file);
  if (results.command != "bench" || results.results.empty()) {
    throw InputError(
        fmt::format("{}: has no timings; hdmbench bench --json FILE writes them", file.string()));
  }
  return {results.rows<BenchRow>(), results.context};
}

Side run_bench(const std::filesystem::path& program, const Words& words, int repeats) {
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
  return load_bench(json);
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
        (old ? found.first : found.second).append(run_bench(old ? first : second, words, 1));
        progress.advance(1.0);
      }
    }
  }
  return found;
}

} // namespace hdmbench::comparison
