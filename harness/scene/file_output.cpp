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

/// stdout or stderr, where `target` is what one of them goes to: /dev/stdout, and the file that the shell
/// made of it. Nothing where it is neither.
std::FILE* standard_stream(const fs::path& target) {
  for (std::FILE* const stream : {stdout, stderr}) {
    struct stat own {};
    struct stat wanted {};
    if (fstat(fileno(stream), &own) == 0 && stat(target.c_str(), &wanted) == 0 &&
        own.st_dev == wanted.st_dev && own.st_ino == wanted.st_ino) {
      return stream;
    }
  }
  return nullptr;
}

/// Whether `target` is written to, not replaced.
bool is_written_to(const fs::path& target) {
  const fs::file_status status = status_of(target);
  return fs::exists(status) && (!fs::is_regular_file(status) || standard_stream(target) != nullptr);
}

void copy_to(const fs::path& target, const fs::path& from) {
  std::FILE* const own = standard_stream(target);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> opened(
      own == nullptr ? std::fopen(target.c_str(), "wb") : nullptr, std::fclose);
  std::FILE* const to = own == nullptr ? opened.get() : own;
  if (to == nullptr) {
    throw unwritable(target, errno);
  }
  std::ifstream content(from, std::ios::binary);
  std::array<char, 1U << 16U> block{};
  do {
    content.read(block.data(), block.size());
    const auto length = static_cast<std::size_t>(content.gcount());
    if (std::fwrite(block.data(), 1, length, to) != length) {
      throw unwritable(target, errno);
    }
  } while (content);
  if (std::fflush(to) != 0) {
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
  if (fs::exists(status) && standard_stream(target) == nullptr) {
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
