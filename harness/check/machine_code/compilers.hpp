#pragma once

#include "harness/check/machine_code/programs.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace hdmbench {

/// Which compiler makes the machine code of a target.
enum class GpuCompiler { radv, clang_amd, clang_nvidia, ocloc };

/// A GPU that need not be there.
struct GpuTarget {
  std::string_view name; ///< the compiler's: "navi21"
  std::string_view gpu;  ///< for people: "AMD RDNA 2"
  GpuCompiler compiler;
  int registers;     ///< that an invocation may have; 0: the compiler does not say how many it took
  bool fuses = true; ///< whether the compiler fuses what is not forbidden
};

[[nodiscard]] std::span<const GpuTarget> gpu_targets();

/// The text without the word that forbids to fuse operations, or as it is.
enum class Word { kept, taken_out };

/// The compiler with its version. Throws DeviceError that says which package has it where it is not there.
[[nodiscard]] std::string compiler_of(GpuCompiler compiler);

/// What a compiler that works on files, which are made in `folder`, makes of a program: the fields of a row
/// of machine_code() from "multiplies" on, as far as it says them. Throws DeviceError with its words where it
/// refuses.
[[nodiscard]] nlohmann::json compile_file(const GpuTarget& target, const GpuProgram& program, Word word,
                                          const std::filesystem::path& folder);

/// Returns the rows of all programs by RADV, in order, and then its name with its version. RADV runs in a
/// process of its own, which RADV_FORCE_FAMILY is set for. Throws DeviceError where it is not there, refuses
/// or crashes. Needs compile_apart().
[[nodiscard]] nlohmann::json compile_by_radv_apart(const GpuTarget& target,
                                                   std::span<const GpuProgram> programs, Word word);

/// Stands first in main(): in a process that compile_by_radv_apart() has started it compiles, and does not
/// return.
void compile_apart(int argc, const char* const* argv);

} // namespace hdmbench
