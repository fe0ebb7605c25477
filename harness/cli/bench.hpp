#pragma once

#include "harness/cli/gates.hpp"
#include "harness/ranks/message_passing.hpp"

namespace hdmbench::commands {

struct BenchArguments : CommonArguments {
  int repeats = 3;
  std::vector<std::string> work{"dense", "active"};
  bool scaling = false;
  bool no_ceilings = false;
  std::filesystem::path benchmark_json{}; ///< empty: nobody asked for it
  std::string reference{};                ///< "none" or a backend; empty: scalar, none for a large image
  std::filesystem::path before{};         ///< result file of bench to compare with; empty: none
  std::filesystem::path after{};          ///< with this one; empty: with what is measured now
  double tolerance = 5.0;                 ///< percent
  Gates gates{};
};

/// `bench --compare`: two result files, or one with what its own command line measures now, with `repeats`
/// samples; whose results then go to --json. Prints a line for every timing of before. Returns the
/// ExitStatus: disagreement where one is slower, inconclusive, missing or of another device. Throws
/// InputError.
[[nodiscard]] int compare_benches(const BenchArguments& arguments, const Call& call, int repeats);

/// `bench --scaling strong|weak` on ranks: the same image on 1, 2, 4 ... of them, or an image that grows with
/// them. "strong" or "weak" stands before the scenes. Returns an ExitStatus.
[[nodiscard]] int bench_on_ranks(const BenchArguments& arguments, const Call& call, Ranks& ranks);

} // namespace hdmbench::commands
