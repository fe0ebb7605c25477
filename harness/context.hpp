#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <string_view>

namespace hdmbench {

/// Where and how a result came about: machine, cpu, cores, operating_system, compiler, flags, commit,
/// version, date (UTC), arguments (of the command line, without the program's name) and quick.
[[nodiscard]] nlohmann::json run_context(std::string_view arguments, bool quick);

/// Writes {"schema": 1, "command", "context", "results"}. Throws InputError.
void write_results(const std::filesystem::path& file, std::string_view command, nlohmann::json context,
                   nlohmann::json results);

} // namespace hdmbench
