#include "test/fuzz/input.hpp"

#include "backends/backend.hpp"
#include "harness/scene/temporary_directory.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>

namespace hdmbench::fuzz {

std::filesystem::path file_with(std::string_view name, std::string_view bytes) {
  static const TemporaryDirectory folder;
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
