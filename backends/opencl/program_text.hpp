#pragma once

#include "backends/device/device.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// What a driver's compiler of OpenCL C is given, on whatever device.
namespace hdmbench::opencl {

/// What all kernels are built with. Numbers without a suffix are floats; nothing is flushed or fused; -w
/// because some drivers print warnings, whether asked or not.
inline constexpr std::string_view build_options = "-cl-std=CL1.2 -cl-single-precision-constant -w";

/// What a kernel is in the texts of kernels/shaders: its name, its arguments by backends/device/device.hpp,
/// its text, and the bytes of the struct that is told after the arguments, where what is told may be shorter.
struct Source {
  const char* name = "";
  std::vector<std::size_t> arguments;
  std::string_view text;
  std::size_t told_bytes = 0;
};

/// Throws std::out_of_range for a kernel that is for devices with shared memory.
[[nodiscard]] Source source_of(Kernel kernel);

/// Returns a program whose text is its constants, `language`, which is what makes these texts another
/// language's, and `text`; without options.
[[nodiscard]] ProgramText program_text(const ProgramKind& kind, std::string_view language,
                                       std::string_view text);
/// Returns a program in OpenCL C.
[[nodiscard]] ProgramText program_text(const ProgramKind& kind);

} // namespace hdmbench::opencl
