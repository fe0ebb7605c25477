#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace hdmbench {

/// Lets `write` fill a file beside `target` (same extension) and renames it to `target` when that returns, so
/// that nobody ever sees a half-written file. A symbolic link stays one: the file that it leads to is
/// replaced, and keeps its mode. What is no regular file (a pipe, a device), and a file that is this
/// program's standard output, is written to. On an exception the partial file is removed and `target` stays
/// as it was. Throws InputError as require_writable does, and where the disk is full.
void write_atomically(const std::filesystem::path& target,
                      const std::function<void(const std::filesystem::path& partial)>& write);

/// Throws InputError unless write_atomically can write to `target`: its folder exists and can be written to,
/// and `target` is neither a folder nor read-only. A check before long work.
void require_writable(const std::filesystem::path& target);

/// Throws InputError where `target` is one of the files `inputs`, under whatever name: it would be lost.
void require_no_input(const std::filesystem::path& target, std::span<const std::filesystem::path> inputs);

/// Makes the folder that `files` go to where it is missing. Throws InputError where it cannot be made, and as
/// require_writable and require_no_input do for one of the files.
void require_folder(const std::filesystem::path& folder, std::span<const std::string> files,
                    std::span<const std::filesystem::path> inputs);

/// write_atomically for a text.
void write_text(const std::filesystem::path& target, std::string_view text);

} // namespace hdmbench
