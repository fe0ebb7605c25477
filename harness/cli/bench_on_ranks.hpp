#pragma once

#include "harness/cli/arguments.hpp"
#include "harness/ranks/message_passing.hpp"

#include <string>

namespace hdmbench::commands {

/// `bench --scaling strong|weak` on ranks: the same image on 1, 2, 4 ... of them, or an image that grows with
/// them. "strong" or "weak" stands before the scenes. Returns an ExitStatus.
[[nodiscard]] int bench_scaling_on_ranks(CommonArguments arguments, bool scaling, int repeats,
                                         const std::string& line, Ranks& ranks);

} // namespace hdmbench::commands
