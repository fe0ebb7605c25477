#include "harness/report/ci_files.hpp"

#include "harness/report/results.hpp"
#include "harness/scene/file_output.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace hdmbench::report {

void write_google_benchmark(const std::filesystem::path& file, const Context& context,
                            const nlohmann::json& rows) {
  if (file.empty()) {
    return;
  }
  constexpr double milliseconds = 1000.0;
  nlohmann::ordered_json benchmarks = nlohmann::ordered_json::array();
  for (const nlohmann::json& row : rows) {
    const std::string threads = row.value("threads", nlohmann::json()).is_null()
                                    ? std::string()
                                    : fmt::format("/threads:{}", row.at("threads").get<int>());
    std::string size = size_of(row);
    std::erase(size, ' '); // "300x300"
    const std::string name = fmt::format("{}/{}/{}/{}{}", text_of(row, "scene"), size, text_of(row, "method"),
                                         text_of(row, "backend"), threads);
    const auto samples = row.at("seconds").get<std::vector<double>>();
    const bool fails = samples.empty() || row.value("valid", nlohmann::json()) == false;
    for (std::size_t i = 0; i < std::max<std::size_t>(1, samples.size()); ++i) {
      const double time = samples.empty() ? 0.0 : samples[i] * milliseconds;
      nlohmann::ordered_json entry{{"name", name},
                                   {"run_name", name},
                                   {"run_type", "iteration"},
                                   {"repetitions", samples.size()},
                                   {"repetition_index", i},
                                   {"threads", 1},
                                   {"iterations", 1},
                                   {"real_time", time},
                                   {"cpu_time", time},
                                   {"time_unit", "ms"},
                                   {"label", text_of(row, "device")}};
      if (fails) {
        entry["error_occurred"] = true;
        entry["error_message"] = text_of(row, "reason");
      }
      benchmarks.push_back(std::move(entry));
    }
  }
  const nlohmann::ordered_json document{{"context",
                                         {{"date", context.date},
                                          {"host_name", context.machine},
                                          {"executable", "hdmbench " + context.arguments},
                                          {"num_cpus", context.cores},
                                          {"library_build_type", "release"},
                                          {"hdmbench_commit", context.commit}}},
                                        {"benchmarks", std::move(benchmarks)}};
  write_text(file, document.dump(1) + "\n");
}

} // namespace hdmbench::report
