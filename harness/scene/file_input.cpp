#include "harness/scene/file_input.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <system_error>

namespace hdmbench {

namespace fs = std::filesystem;

void require_regular_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) {
    throw MissingFile(fmt::format("{}: there is no such file", file.string()));
  }
  if (status.type() == fs::file_type::none) {
    throw InputError(fmt::format("{}: cannot be read: {}", file.string(), error.message()));
  }
  if (!fs::is_regular_file(status)) {
    throw InputError(fmt::format(
        "{}: cannot be read: it is {}", file.string(),
        fs::is_directory(status) ? "a folder"
                                 : "a device or a pipe, which may never end; save what it gives as a file"));
  }
}

std::string read_file(const fs::path& file) {
  require_regular_file(file);
  constexpr std::uintmax_t most = std::uintmax_t{1} << 30;
  if (fs::file_size(file) > most) {
    throw InputError(fmt::format("{}: has more than the {} bytes that are read", file.string(), most));
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  if (!stream) {
    throw InputError(
        fmt::format("{}: cannot be read: {}", file.string(), std::generic_category().message(errno)));
  }
  return text;
}

} // namespace hdmbench
