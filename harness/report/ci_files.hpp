#pragma once

#include "harness/measure/result_file.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>

namespace hdmbench::report {

/// Writes rows of `bench` in Google Benchmark's JSON schema (its compare.py, dashboards): a sample is a
/// repetition, `real_time` are seconds of a whole solution without set-up, reported in milliseconds. A row
/// that is not valid is an error. Nothing is written where `file` is empty, as nobody asked for it. Throws
/// InputError as write_text() does.
void write_google_benchmark(const std::filesystem::path& file, const Context& context,
                            const nlohmann::json& rows);

} // namespace hdmbench::report
