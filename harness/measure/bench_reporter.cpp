#include "harness/measure/bench_case.hpp"
#include "harness/measure/median.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <ostream>

namespace hdmbench {

using nlohmann::json;

namespace {

using Run = benchmark::BenchmarkReporter::Run;

double seconds(double time, const Run& run) {
  return time / benchmark::GetTimeUnitMultiplier(run.time_unit);
}

void set_medians(const Run& run, json& row) {
  if (row["seconds"].empty()) { // the library was asked for aggregates only
    row["seconds"].push_back(seconds(run.GetAdjustedRealTime(), run));
  }
  const auto samples = row["seconds"].get<std::vector<double>>();
  row["seconds_median"] = median(samples); // the library's is another in the last bits: it knows sums
  const auto [least, most] = std::ranges::minmax(samples);
  row["spread_percent"] = 50.0 * (most - least) / median(samples);
  row["processor_seconds"] = seconds(run.GetAdjustedCPUTime(), run);
  const auto counted = [&](const char* counter, const char* key, double factor) {
    if (const auto found = run.counters.find(counter); found != run.counters.end()) {
      row[key] = found->second.value * factor;
    }
  };
  for (const auto& [key, part] : parts) {
    counted(key, key, 1.0);
  }
  for (const char* const key : {"device_seconds", "launch_seconds"}) { // of one step
    counted(key, key, 1.0);
  }
  counted("site_updates_per_second", "msites_per_second", 1e-6);
  counted("bytes_per_second", "gigabytes_per_second", giga);
  counted("operations_per_second", "gigaoperations_per_second", giga);
  counted("percent_of_ceiling", "percent_of_ceiling", 1.0);
}

} // namespace

bool Bench::Reporter::ReportContext(const Context& context) {
  return printer_ == nullptr || printer_->ReportContext(context);
}

void Bench::Reporter::ReportRuns(const std::vector<Run>& runs) {
  bench_.progress_.clear();
  Case& one = **std::ranges::find_if(
      bench_.cases_, [&](const auto& other) { return other->name == runs.front().run_name.function_name; });
  if (!shown_.empty() && shown_.back()->place != one.place) {
    show();
  }
  take(runs, one.row);
  one.close();
  if (shown_.empty() || shown_.back() != &one) {
    shown_.push_back(&one);
  }
  if (printer_) {
    printer_->ReportRuns(runs);
  }
  hear_.keep(bench_.rows());
}

void Bench::Reporter::Finalize() {
  show();
  if (printer_) {
    printer_->Finalize();
  }
}

/// The medians are the library's; of one repetition it makes none.
void Bench::Reporter::take(const std::vector<Run>& runs, json& row) const {
  for (const Run& run : runs) {
    if (run.error_occurred) {
      row.update({{"valid", false}, {"reason", run.error_message}});
      continue;
    }
    if (run.run_type == Run::RT_Iteration) {
      row["seconds"].push_back(seconds(run.GetAdjustedRealTime(), run));
      row["solutions_per_sample"] = run.iterations;
    }
    if (run.aggregate_name == "median" || run.repetitions <= 1) {
      set_medians(run, row);
    }
  }
}

void Bench::Reporter::show() {
  json rows = json::array();
  for (Case* const one : std::exchange(shown_, {})) {
    bench_.compare_speeds(*one);
    rows.push_back(one->row);
  }
  if (!rows.empty()) {
    hear_.show(rows);
  }
}

void tell_library(const Context& context) {
  for (const auto& [key, value] : {std::pair{"hdmbench_commit", context.commit},
                                   {"hdmbench_arguments", context.arguments},
                                   {"compiler", context.compiler},
                                   {"flags", context.flags},
                                   {"machine", context.machine}}) {
    benchmark::AddCustomContext(key, value);
  }
}

nlohmann::json Bench::run(std::vector<std::string> flags, std::ostream& printed, const Hear& hear) {
  flags.insert(flags.begin(), "hdmbench");
  std::vector<char*> words;
  std::ranges::transform(flags, std::back_inserter(words), [](std::string& flag) { return flag.data(); });
  int count = static_cast<int>(words.size());
  const auto refuse = [] { // in place of ending the program
    throw InputError(
        "a flag of Google Benchmark has a value that it does not know; formats are console, json "
        "and csv, units ns, us, ms and s");
  };
  benchmark::Initialize(&count, words.data(), refuse);
  if (count > 1) {
    throw InputError(fmt::format("Google Benchmark does not take {}", words[1]));
  }
  const bool prints = std::ranges::any_of(
      flags, [](const std::string& flag) { return flag.starts_with("--benchmark_format"); });
  std::unique_ptr<benchmark::BenchmarkReporter> printer(prints ? benchmark::CreateDefaultDisplayReporter()
                                                               : nullptr);
  if (printer) {
    printer->SetOutputStream(&printed);
  }
  Reporter reporter(*this, std::move(printer), hear);
  reporter.SetOutputStream(&printed);
  if (benchmark::RunSpecifiedBenchmarks(&reporter) == 0) {
    throw InputError(fmt::format("no case fits --benchmark_filter={}; --benchmark_list_tests names the cases",
                                 benchmark::GetBenchmarkFilter()));
  }
  progress_.clear();
  return rows();
}

nlohmann::json Bench::registered() const {
  json rows = json::array();
  for (const auto& one : cases_) {
    rows.push_back(one->row);
    rows.back()["reason"] = one->refusal;
  }
  return rows;
}

nlohmann::json Bench::rows() const {
  json rows = json::array();
  for (const auto& one : cases_) {
    if (one->is_reported) {
      compare_speeds(*one);
      rows.push_back(one->row);
    }
  }
  return rows;
}

} // namespace hdmbench
