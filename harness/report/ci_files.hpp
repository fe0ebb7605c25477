#pragma once

#include "harness/measure/result_file.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>

namespace hdmbench::report {

/// Results in the two formats that continuous integration elsewhere reads. `rows` are the results of a
/// command as its own JSON has them; nothing is written where `file` is empty, as nobody asked for it. Both
/// throw InputError as write_text() does.

/// Writes rows of `verify` as JUnit XML: a comparison is a test case, named backend and mode in a class named
/// after scene, size and method. Disagreeing and mistrusted ones fail, and say the command line that repeats
/// them.
void write_junit(const std::filesystem::path& file, const nlohmann::json& rows);
/// Writes rows of `machine-code` likewise: a program is a test case, in a class named after target and text.
/// A compiler that is not there is a skipped one.
void write_junit_of_machine_code(const std::filesystem::path& file, const nlohmann::json& rows);

} // namespace hdmbench::report
