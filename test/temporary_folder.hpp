#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace hdmbench::test {

/// An empty folder of the running test's own, removed with the object.
class TemporaryFolder {
public:
  TemporaryFolder() {
    const auto* information = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string("hdmbench-") + information->test_suite_name() + "-" + information->name() +
                       "-" + std::to_string(getpid());
    for (char& c : name) {
      c = c == '/' ? '-' : c;
    }
    path_ = std::filesystem::temp_directory_path() / name;
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  [[nodiscard]] std::filesystem::path write(std::string_view name, std::string_view text) const {
    const auto file = path_ / name;
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

private:
  std::filesystem::path path_;
};

} // namespace hdmbench::test
