#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

/// libFuzzer's entry point, one per program of this folder; also what replay.cpp calls.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace hdmbench::fuzz {

inline std::string_view as_text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// The path of a file of this process's own with these bytes. The folder goes with the process.
[[nodiscard]] std::filesystem::path file_with(std::string_view name, std::string_view bytes);

/// Calls `read`. InputError and DeviceError are answers; anything else that it throws ends the program with a
/// message, which libFuzzer and ctest take for a failure.
void expect_an_answer(const std::function<void()>& read);

} // namespace hdmbench::fuzz
