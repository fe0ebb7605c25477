#pragma once

#include "harness/scene/temporary_directory.hpp"

#include <filesystem>
#include <fstream>
#include <string_view>

namespace hdmbench::test {

/// A folder for the files of a test.
class TemporaryFolder : public TemporaryDirectory {
public:
  [[nodiscard]] std::filesystem::path write(std::string_view name, std::string_view text) const {
    const auto file = path() / name;
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
};

} // namespace hdmbench::test
