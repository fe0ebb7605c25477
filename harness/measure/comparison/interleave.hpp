#pragma once

#include "harness/measure/bench_row.hpp"
#include "harness/measure/context.hpp"
#include "harness/solve/progress.hpp"

#include <filesystem>
#include <string>
#include <vector>

/// hdmbench, this one or an older one, as a program that is run for its timings.
namespace hdmbench::comparison {

/// One run: what stands after "bench" on the command line.
using Words = std::vector<std::string>;

/// What one program measured.
struct Side {
  std::vector<BenchRow> rows;
  Context context;

  /// Its context replaces that of this one.
  void append(Side side);
};

/// Throws InputError where the file is not of bench, or has no rows.
[[nodiscard]] Side load_bench(const std::filesystem::path& file);

/// Runs `program bench WORDS --repeat N --json FILE` and reads the file. Throws InputError with what the
/// program printed where it leaves none; fields that disagree are a row's matter.
[[nodiscard]] Side run_bench(const std::filesystem::path& program, const Words& words, int repeats);

/// What both sides measured; the contexts are of their last runs.
struct BothSides {
  Side first;
  Side second;
};

/// Each of `runs` `samples` times by both programs in turn, a process a sample: old, new, new, old, old, ...,
/// so that whatever drifts hits both alike.
[[nodiscard]] BothSides interleave(const std::filesystem::path& first, const std::filesystem::path& second,
                                   const std::vector<Words>& runs, int samples, Progress& progress);

} // namespace hdmbench::comparison
