#pragma once

#include "harness/check/verify.hpp"
#include "harness/cli/arguments.hpp"

#include <span>
#include <vector>

namespace hdmbench::commands {

/// What the comparisons of a scene came to, on standard output: a row for each backend, what was not
/// compared, and of what differs the first site and the command line that repeats it.
void print_scene(const Scene& scene, const std::vector<Comparison>& comparisons,
                 const CommonArguments& arguments);

/// What all comparisons come to, by backend.
void print_tiers(std::span<const Comparison> comparisons);

} // namespace hdmbench::commands
