#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace hdmbench {

/// Lets `write` fill a file beside `target` (same extension) and renames it to `target` when that returns, so
/// that nobody ever sees a half-written file. On an exception the partial file is removed and `target` stays
/// as it was. Throws InputError where the folder does not exist or cannot be written.
void write_atomically(const std::filesystem::path& target,
                      const std::function<void(const std::filesystem::path& partial)>& write);

/// Throws InputError unless the folder of `target` exists, can be written to, and `target` is no folder
/// itself: a check before long work.
void require_writable(const std::filesystem::path& target);

/// write_atomically for a text.
void write_text(const std::filesystem::path& target, std::string_view text);

} // namespace hdmbench
