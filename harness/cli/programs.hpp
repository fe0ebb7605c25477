#pragma once

#include "harness/cli/arguments.hpp"

/// `bench --against`: two programs timed in turn.
namespace hdmbench::commands {

inline const Option<std::filesystem::path>
    against("--against", "Run each case in turn by this other hdmbench and by this one, and compare");

/// --against, --tolerance, --pairs and --strict.
[[nodiscard]] Options comparison_of_programs();

/// Runs the cases of `rows`, which Bench has registered for the call, pair by pair in processes of their own,
/// and prints a line for each. The results are rows of "against": "old_s" and "new_s" are medians over the
/// pairs, "ratio" that of "ratios". Returns an ExitStatus: disagreement where a case is slower or one of the
/// programs has no time of a case, and with --strict where one is inconclusive. Throws InputError where the
/// other program cannot be started.
[[nodiscard]] int compare_programs(const Call& call, const json& rows);

} // namespace hdmbench::commands
