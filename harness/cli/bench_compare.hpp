#pragma once

#include "harness/cli/command.hpp"

#include <filesystem>

namespace hdmbench::commands {

/// What `bench` takes to compare timings with those of before.
struct CompareArguments {
  std::filesystem::path before; ///< result files of bench; empty: nothing is compared
  std::filesystem::path after;  ///< empty: measured now
  double tolerance = 5.0;       ///< percent

  void add_to(const Command& command);
};

/// Compares two result files, or one with what its own command line measures now, whose results then go to
/// `json` unless that is empty. `repeats`: samples to measure; 0: enough for the test. Prints a line for
/// every timing of before. Returns the ExitStatus: disagreement where one is slower, inconclusive, missing or
/// of another device. Throws InputError.
[[nodiscard]] int compare_benches(const CompareArguments& arguments, int repeats,
                                  const std::filesystem::path& json);

} // namespace hdmbench::commands
