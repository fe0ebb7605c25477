#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace hdmbench {

/// Throws MissingFile where there is no such file, InputError where it is a folder, or a device or a pipe,
/// which may never end.
void require_regular_file(const std::filesystem::path& file);

/// The bytes of a regular file of at most 1 GiB. Throws as require_regular_file does, and InputError where it
/// is larger or cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

/// Lets `write` fill a file beside `target` (same end of the name) and renames it to `target` when that
/// returns, so that nobody ever sees a half-written file. A symbolic link stays one: the file that it leads
/// to is replaced, and keeps its mode. What is no regular file (a pipe, a device), and a file that is this
/// program's standard output, is written to. On an exception the partial file is removed and `target` stays
/// as it was. Throws InputError as require_writable does, and where the disk is full.
void write_atomically(const std::filesystem::path& target,
                      const std::function<void(const std::filesystem::path& partial)>& write);

/// Whether write_atomically() replaces `target`, or makes it, and does not write to it as to a pipe.
[[nodiscard]] bool is_replaced(const std::filesystem::path& target);

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

/// The text for people and for files of text: names of files can have any bytes. Line feeds and tabs stay;
/// what is no character (bytes that are not UTF-8, control characters, U+FFFE and U+FFFF) is written as its
/// bytes, "\\x1b".
[[nodiscard]] std::string printable(std::string_view text);

/// An empty folder that goes with the object. Throws InputError where none can be made.
class TemporaryDirectory {
public:
  TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

} // namespace hdmbench
