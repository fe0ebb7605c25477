#pragma once

#include <CLI/CLI.hpp>

#include <filesystem>
#include <string>

namespace hdmbench::commands {

/// What `bench` takes to compare timings with those of before.
struct CompareArguments {
  std::filesystem::path old_results;
  std::filesystem::path new_results;
  std::filesystem::path old_program;
  double tolerance = 5.0; ///< percent

  void add_to(CLI::App& command);
  [[nodiscard]] bool wanted() const { return !old_results.empty() || !old_program.empty(); }
};

/// Measures what is missing, by running this program (and the old one) again as separate processes, prints
/// one line per timing and its verdict, writes `json` unless empty. `bench` is the command with its own
/// options, `line` the command line from "bench" on, which says what to run where no old results do.
/// `repeats`: samples a side; 0: as many as the test needs. Returns the ExitStatus: disagreement where
/// something is slower than tolerated. Throws InputError.
[[nodiscard]] int compare_benches(const CompareArguments& arguments, const CLI::App& bench,
                                  const std::string& line, int repeats, const std::filesystem::path& json);

} // namespace hdmbench::commands
