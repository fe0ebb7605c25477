#pragma once

#include "harness/check/verify.hpp"

#include <filesystem>
#include <string>

namespace hdmbench {

/// Writes the step of a comparison (Comparison::step, not null) as a program that stands alone: its texts as
/// they were compiled, the bytes of its arrays, what was expected and what was found, reproduce.cpp, which
/// does it again by the same API, and README.txt, which says what differed, how to build that, and `repeat`,
/// the command line that found it. Makes the folder where it is missing. Throws InputError where
/// it cannot be made or a file cannot be written.
void write_reproducer(const std::filesystem::path& folder, const Comparison& comparison,
                      const std::string& repeat);

} // namespace hdmbench
