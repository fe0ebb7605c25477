#include "harness/file_output.hpp"

#include "kernels/input_error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>

namespace hdmbench {

namespace fs = std::filesystem;

namespace {

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

} // namespace

void require_writable(const fs::path& target) {
  const fs::path folder = folder_of(target);
  if (!fs::is_directory(folder)) {
    throw InputError(fmt::format("{}: {} {}", target.string(), folder.string(),
                                 fs::exists(folder) ? "is a file, not a folder" : "does not exist"));
  }
  if (fs::is_directory(target)) {
    throw InputError(fmt::format("{}: is a folder", target.string()));
  }
  if (access(folder.c_str(), W_OK) != 0) {
    throw InputError(fmt::format("{}: the folder {} cannot be written to", target.string(), folder.string()));
  }
}

void write_atomically(const fs::path& target, const std::function<void(const fs::path& partial)>& write) {
  require_writable(target);
  const fs::path partial = folder_of(target) / fmt::format(".{}.{}.partial{}", target.stem().string(),
                                                           getpid(), target.extension().string());
  std::error_code ignored;
  try {
    write(partial);
    fs::rename(partial, target);
  } catch (const fs::filesystem_error& error) {
    fs::remove(partial, ignored);
    throw InputError(fmt::format("{}: {}", target.string(), error.code().message()));
  } catch (...) {
    fs::remove(partial, ignored);
    throw;
  }
}

void write_text(const fs::path& target, std::string_view text) {
  write_atomically(target, [&](const fs::path& partial) {
    std::ofstream stream(partial, std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) {
      throw InputError(fmt::format("{}: cannot be written (disk full, or no permission?)", target.string()));
    }
  });
}

} // namespace hdmbench
