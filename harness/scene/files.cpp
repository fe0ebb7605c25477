#include "harness/scene/files.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <system_error>

namespace hdmbench {

namespace fs = std::filesystem;

namespace {

InputError unusable(const fs::path& file, std::string_view why) {
  return InputError(fmt::format("{}: {}", file.string(), why));
}

InputError unwritable(const fs::path& target, int error_number) {
  return unusable(target, "cannot be written: " + std::generic_category().message(error_number));
}

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

/// The file that symbolic links lead to, which need not exist. Throws InputError where they lead back to
/// themselves.
fs::path followed(fs::path target) {
  std::error_code error;
  if (fs::status(target, error).type() == fs::file_type::none) {
    throw unwritable(target, error.value());
  }
  while (fs::is_symlink(target)) {
    target = folder_of(target) / fs::read_symlink(target);
  }
  return target;
}

/// The descriptor of standard output or standard error, where `target` is what one of them goes to:
/// /dev/stdout, and the file that the shell made of it. -1 where it is neither.
int standard_stream(const fs::path& target) {
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat own {};
    struct stat wanted {};
    if (fstat(stream, &own) == 0 && stat(target.c_str(), &wanted) == 0 && own.st_dev == wanted.st_dev &&
        own.st_ino == wanted.st_ino) {
      return stream;
    }
  }
  return -1;
}

void copy_to(const fs::path& target, const fs::path& from) {
  std::fflush(stdout); // what has been printed comes first
  const int own = standard_stream(target);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> to(
      own >= 0 ? fdopen(dup(own), "wb") : std::fopen(target.c_str(), "wb"), std::fclose);
  std::ifstream content(from, std::ios::binary);
  std::array<char, 1U << 16U> block{};
  bool is_written = to != nullptr;
  while (is_written && content) {
    content.read(block.data(), block.size());
    const auto length = static_cast<std::size_t>(content.gcount());
    is_written = std::fwrite(block.data(), 1, length, to.get()) == length;
  }
  if (!is_written || std::fflush(to.get()) != 0) {
    throw unwritable(target, errno);
  }
}

} // namespace

bool is_replaced(const fs::path& target) { // not: a pipe, a device, a standard stream
  return !fs::exists(target) || (fs::is_regular_file(target) && standard_stream(target) < 0);
}

void require_writable(const fs::path& target) {
  const fs::path file = followed(target);
  if (fs::is_directory(target)) {
    throw unusable(target, "is a folder");
  }
  if (fs::exists(target) && standard_stream(target) < 0) {
    constexpr fs::perms writable = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
    const fs::perms own = fs::status(target).permissions(); // root may write to every file
    if ((own & writable) == fs::perms::none || access(target.c_str(), W_OK) != 0) {
      throw unusable(target, "is read-only");
    }
  }
  if (const fs::path folder = folder_of(file); is_replaced(target)) {
    if (!fs::is_directory(folder)) {
      throw unusable(target, fmt::format("{} {}", folder.string(),
                                         fs::exists(folder) ? "is a file, not a folder" : "does not exist"));
    }
    if (access(folder.c_str(), W_OK) != 0) {
      throw unusable(target, fmt::format("the folder {} cannot be written to", folder.string()));
    }
  }
}

void require_no_input(const fs::path& target, std::span<const fs::path> inputs) {
  for (const fs::path& input : inputs) {
    std::error_code missing;
    if (fs::is_regular_file(input, missing) && fs::equivalent(target, input, missing)) {
      throw unusable(target,
                     fmt::format("would replace the input {}; give another name or folder", input.string()));
    }
  }
}

void require_folder(const fs::path& folder, std::span<const std::string> files,
                    std::span<const fs::path> inputs) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    std::error_code missing;
    throw unusable(folder, fs::exists(folder, missing) ? "is a file, not a folder"
                                                       : "the folder cannot be made: " + error.message());
  }
  for (const std::string& file : files) {
    require_no_input(folder / file, inputs);
    require_writable(folder / file);
  }
}

void write_atomically(const fs::path& target, const std::function<void(const fs::path& partial)>& write) {
  require_writable(target);
  if (!is_replaced(target)) {
    const TemporaryDirectory folder;
    const fs::path whole = folder.path() / target.filename();
    write(whole);
    copy_to(target, whole);
    return;
  }
  const fs::path file = followed(target);
  const fs::path partial =
      folder_of(file) / fmt::format(".{}.partial.{}", getpid(), target.filename().string());
  std::error_code ignored;
  try {
    write(partial);
    if (fs::exists(file)) {
      fs::permissions(partial, fs::status(file).permissions());
    }
    fs::rename(partial, file);
  } catch (const fs::filesystem_error& error) {
    fs::remove(partial, ignored);
    throw unwritable(target, error.code().value());
  } catch (...) {
    fs::remove(partial, ignored);
    throw;
  }
}

void write_text(const fs::path& target, std::string_view text) {
  write_atomically(target, [&](const fs::path& partial) {
    errno = 0;
    std::ofstream stream(partial, std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) {
      throw unwritable(target, errno != 0 ? errno : EIO);
    }
  });
}

void require_regular_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) {
    throw MissingFile(fmt::format("{}: there is no such file", file.string()));
  }
  if (status.type() != fs::file_type::none && !fs::is_regular_file(status)) {
    throw unusable(file, fs::is_directory(status) ? "cannot be read: it is a folder"
                                                  : "cannot be read: it is a device or a pipe, which may "
                                                    "never end; save what it gives as a file");
  }
  if (error || access(file.c_str(), R_OK) != 0) {
    throw unusable(file, "cannot be read: " + std::generic_category().message(error ? error.value() : errno));
  }
}

std::string read_file(const fs::path& file) {
  require_regular_file(file);
  constexpr std::uintmax_t most = std::uintmax_t{1} << 30;
  if (fs::file_size(file) > most) {
    throw unusable(file, fmt::format("has more than the {} bytes that are read", most));
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  if (!stream) {
    throw unusable(file, "cannot be read: " + std::generic_category().message(errno));
  }
  return text;
}

/// Bytes of the character that `text` begins with; 0 where they are none that can be printed.
static std::size_t printable_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(0);
  if (first < 0x80) {
    return first == '\n' || first == '\t' || (first >= 0x20 && first != 0x7F) ? 1 : 0;
  }
  if (first < 0xC2 || first > 0xF4) {
    return 0;
  }
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  std::uint32_t code = first & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) {
      return 0;
    }
    code = code << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> least{0, 0, 0xA0, 0x800, 0x10000}; // below 0xA0: control characters
  const bool is_character = code >= least.at(length) && code <= 0x10FFFF &&
                            (code < 0xD800 || code > 0xDFFF) && (code & 0xFFFEU) != 0xFFFE;
  return is_character ? length : 0;
}

std::string printable(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = printable_character(text);
    result += length > 0 ? std::string(text.substr(0, length))
                         : fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result;
}

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (fs::temp_directory_path() / "hdmbench-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw unusable(name, "no temporary directory: " + std::generic_category().message(errno));
  }
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

} // namespace hdmbench
