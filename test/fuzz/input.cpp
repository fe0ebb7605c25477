#include "test/fuzz/input.hpp"

#include "backends/backend.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

namespace hdmbench::fuzz {

namespace {

namespace fs = std::filesystem;

class OwnFolder {
public:
  OwnFolder() : path_(parent() / fmt::format("hdmbench-fuzz-{}", getpid())) { fs::create_directories(path_); }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  ~OwnFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  [[nodiscard]] const fs::path& path() const { return path_; }

private:
  /// In memory where there is such a folder: thousands of files a second.
  static fs::path parent() {
    const fs::path in_memory = "/dev/shm";
    return access(in_memory.c_str(), W_OK) == 0 ? in_memory : fs::temp_directory_path();
  }

  fs::path path_;
};

} // namespace

std::filesystem::path file_with(std::string_view name, std::string_view bytes) {
  static const OwnFolder folder;
  auto file = folder.path() / name;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  if (!(stream << bytes << std::flush)) {
    fmt::print(stderr, "{} cannot be written\n", file.string());
    std::abort();
  }
  return file;
}

void expect_an_answer(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError&) {
  } catch (const DeviceError&) {
  } catch (const std::exception& error) {
    fmt::print(stderr, "neither InputError nor DeviceError: {}\n", error.what());
    std::abort();
  }
}

} // namespace hdmbench::fuzz
