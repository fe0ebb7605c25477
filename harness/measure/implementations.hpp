#pragma once

#include "harness/check/verify.hpp"
#include "harness/solve/progress.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// The same comparison on every driver of this machine: an implementation of OpenGL or Vulkan that agrees
/// says nothing about the next one.
namespace hdmbench {

class Fields;

/// How a process is made to use another driver than the one installed for it.
struct Implementation {
  std::string name; ///< "softpipe"
  std::vector<std::pair<std::string, std::string>> environment;
};

/// "as installed", what Mesa can be asked for, and every Vulkan driver that has a file where the loader looks
/// (VK_DRIVER_FILES or VK_ICD_FILENAMES, where set, or its folders) or where a browser keeps one. Whether it
/// is there, and for which backends, is not known yet.
[[nodiscard]] std::vector<Implementation> known_implementations();

/// One row of `devices`' results: a device of a backend, or a backend without one.
struct DeviceRow {
  std::string backend;
  std::string description;
  std::vector<std::string> updates{}; ///< of update_names, that the backend supports
  bool available = true;
  std::string device{};
  std::string driver{};
  bool software = false;
  std::string reason{}; ///< why it is not available
};

void list_fields(Fields& fields, DeviceRow& row);

/// How a comparison on an implementation ended.
enum class Outcome { passed, failed, absent, out_of_time, out_of_memory, crashed, refused };
inline constexpr std::array<std::string_view, 7> outcome_names{
    "passed", "failed", "absent", "out of time", "out of memory", "crashed", "refused"};
[[nodiscard]] constexpr const auto& names_of(Outcome) {
  return outcome_names;
}
[[nodiscard]] constexpr std::string_view name_of(Outcome outcome) {
  return outcome_names[static_cast<std::size_t>(outcome)];
}

/// One row of `implementations`' results: a backend on a device that an implementation brings.
struct ImplementationRow {
  std::string backend;
  std::string implementation;
  std::string device{};
  std::string driver{};
  Outcome outcome = Outcome::absent;
  Tier tier = Tier::none; ///< the lowest of its comparisons
  std::int64_t scenes = 0;
  std::int64_t comparisons = 0;
  std::int64_t sites_compared = 0;
  std::int64_t sites_differing = 0;
  double seconds = 0.0;        ///< of the whole process
  std::int64_t peak_bytes = 0; ///< resident
  std::string reason{};        ///< why it did not pass
  std::string repeat{};        ///< a command line for a shell
};
void list_fields(Fields& fields, ImplementationRow& row);

struct ImplementationOptions {
  std::filesystem::path program;       ///< hdmbench itself
  std::vector<std::string> verify{};   ///< further arguments of `verify`
  std::vector<std::string> backends{}; ///< empty: all but the reference
  double seconds = 0.0;                ///< a process may take
  std::int64_t resident_bytes = 0;     ///< a process may take
};

/// Asks every implementation for its devices, leaves out those that an earlier one has shown, and runs
/// `verify` on each of the others, every time in a process of its own: a driver that hangs or crashes is a
/// row. Throws InputError where the program cannot be started.
[[nodiscard]] std::vector<ImplementationRow>
verify_implementations(const std::vector<Implementation>& implementations,
                       const ImplementationOptions& options, Progress& progress);

} // namespace hdmbench
