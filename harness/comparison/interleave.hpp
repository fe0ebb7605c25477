#pragma once

#include "harness/progress.hpp"
#include "harness/report/results.hpp"

#include <filesystem>
#include <string>
#include <vector>

/// hdmbench, this one or an older one, as a program that is run for its timings.
namespace hdmbench::comparison {

/// One run: what stands after "bench" on the command line.
using Words = std::vector<std::string>;

/// Runs `program bench WORDS --repeat N --json FILE` and reads the file. Throws InputError with what the
/// program printed where it leaves none; fields that disagree are a row's matter.
[[nodiscard]] report::Results run_bench(const std::filesystem::path& program, const Words& words,
                                        int repeats);

/// What both sides measured.
struct BothSides {
  std::vector<report::BenchRow> first;
  std::vector<report::BenchRow> second;
  report::Context first_context; ///< of the last run
  report::Context second_context;
};

/// Each of `runs` `samples` times by both programs in turn, a process a sample: old, new, new, old, old, ...,
/// so that whatever drifts hits both alike.
[[nodiscard]] BothSides interleave(const std::filesystem::path& first, const std::filesystem::path& second,
                                   const std::vector<Words>& runs, int samples, Progress& progress);

} // namespace hdmbench::comparison
