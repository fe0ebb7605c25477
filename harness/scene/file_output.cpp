#include "harness/scene/file_output.hpp"

#include "harness/scene/temporary_directory.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <system_error>

namespace hdmbench {

namespace fs = std::filesystem;

namespace {

InputError unwritable(const fs::path& target, std::string_view why) {
  return InputError(fmt::format("{}: {}", target.string(), why));
}

InputError unwritable(const fs::path& target, int error_number) {
  return unwritable(target, "cannot be written: " + std::generic_category().message(error_number));
}

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

/// Of the file itself, not of a link to it. Throws InputError where links lead back to themselves.
fs::file_status status_of(const fs::path& target) {
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (status.type() == fs::file_type::none) {
    throw unwritable(target, error.value());
  }
  return status;
}

/// The file that symbolic links lead to, which need not exist.
fs::path followed(fs::path target) {
  while (fs::is_symlink(target)) { // status_of() has seen that they end
    target = folder_of(target) / fs::read_symlink(target);
  }
  return target;
}

/// The descriptor of standard output or standard error, where `target` is what one of them goes to:
/// /dev/stdout, and the file that the shell made of it. Nothing where it is neither.
std::optional<int> standard_stream(const fs::path& target) {
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat own {};
    struct stat wanted {};
    if (fstat(stream, &own) == 0 && stat(target.c_str(), &wanted) == 0 && own.st_dev == wanted.st_dev &&
        own.st_ino == wanted.st_ino) {
      return stream;
    }
  }
  return std::nullopt;
}

/// Whether `target` is written to, not replaced.
bool is_written_to(const fs::path& target) {
  const fs::file_status status = status_of(target);
  return fs::exists(status) && (!fs::is_regular_file(status) || standard_stream(target));
}

void copy_to(const fs::path& target, const fs::path& from) {
  std::fflush(stdout); // what has been printed comes first
  const std::optional<int> own = standard_stream(target);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> to(
      own ? fdopen(dup(*own), "wb") : std::fopen(target.c_str(), "wb"), std::fclose);
  if (to == nullptr) {
    throw unwritable(target, errno);
  }
  std::ifstream content(from, std::ios::binary);
  std::array<char, 1U << 16U> block{};
  do {
    content.read(block.data(), block.size());
    const auto length = static_cast<std::size_t>(content.gcount());
    if (std::fwrite(block.data(), 1, length, to.get()) != length) {
      throw unwritable(target, errno);
    }
  } while (content);
  if (std::fflush(to.get()) != 0) {
    throw unwritable(target, errno);
  }
}

/// Of a file that is there, also for root, who may write to every file.
void require_permission(const fs::path& target, const fs::file_status& status) {
  constexpr fs::perms writable = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  const bool read_only = (status.permissions() & writable) == fs::perms::none;
  if (read_only || access(target.c_str(), W_OK) != 0) {
    throw unwritable(target, "is read-only");
  }
}

} // namespace

void require_writable(const fs::path& target) {
  const fs::file_status status = status_of(target);
  if (fs::is_directory(status)) {
    throw unwritable(target, "is a folder");
  }
  if (fs::exists(status) && !standard_stream(target)) {
    require_permission(target, status);
  }
  if (is_written_to(target)) {
    return;
  }
  const fs::path folder = folder_of(followed(target));
  if (!fs::is_directory(folder)) {
    throw unwritable(target, fmt::format("{} {}", folder.string(),
                                         fs::exists(folder) ? "is a file, not a folder" : "does not exist"));
  }
  if (access(folder.c_str(), W_OK) != 0) {
    throw unwritable(target, fmt::format("the folder {} cannot be written to", folder.string()));
  }
}

void require_no_input(const fs::path& target, std::span<const fs::path> inputs) {
  for (const fs::path& input : inputs) {
    std::error_code missing;
    if (fs::is_regular_file(input, missing) && fs::equivalent(target, input, missing)) {
      throw unwritable(
          target, fmt::format("would replace the input {}; give another name or folder", input.string()));
    }
  }
}

void require_folder(const fs::path& folder, std::span<const std::string> files,
                    std::span<const fs::path> inputs) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    std::error_code missing;
    throw unwritable(folder, fs::exists(folder, missing) ? "is a file, not a folder"
                                                         : "the folder cannot be made: " + error.message());
  }
  for (const std::string& file : files) {
    require_no_input(folder / file, inputs);
    require_writable(folder / file);
  }
}

void write_atomically(const fs::path& target, const std::function<void(const fs::path& partial)>& write) {
  require_writable(target);
  if (is_written_to(target)) {
    const TemporaryDirectory folder;
    const fs::path whole = folder.path() / target.filename();
    write(whole);
    copy_to(target, whole);
    return;
  }
  const fs::path file = followed(target);
  const fs::path partial = folder_of(file) / fmt::format(".{}.{}.partial{}", file.stem().string(), getpid(),
                                                         target.extension().string());
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

} // namespace hdmbench
