#pragma once

#include <filesystem>
#include <string>

namespace hdmbench {

/// Throws MissingFile where there is no such file, InputError where it is a folder, or a device or a pipe,
/// which may never end.
void require_regular_file(const std::filesystem::path& file);

/// The bytes of a regular file of at most 1 GiB. Throws as require_regular_file does, and InputError where it
/// is larger or cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

} // namespace hdmbench
