#include "backends/shared/subprocess.hpp"
#include "harness/check/machine_code/compilers.hpp"
#include "harness/check/machine_code/operations.hpp"
#include "harness/scene/files.hpp"

#ifdef HDMBENCH_WITH_VULKAN
#include "backends/vulkan/machine_code.hpp"
#endif

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <vector>

namespace hdmbench {

namespace {

using nlohmann::json;
using Path = std::filesystem::path;

/// The first argument of a process that compiles: its second one is a folder of SPIR-V modules 0, 1, ...
constexpr std::string_view question = "--compile-by-radv";

#ifdef HDMBENCH_WITH_VULKAN
json fields_of(const vulkan::MachineCode& code) {
  const Operations found = count_operations(InstructionSet::amd, code.assembly);
  const auto said = [&](const char* name) {
    const auto at = code.statistics.find(name);
    return at == code.statistics.end() ? json() : json(at->second);
  };
  return {{"multiplies", found.multiplies},     {"adds", found.adds},
          {"fused", found.fused.size()},        {"fused_lines", found.fused},
          {"instructions", found.instructions}, {"registers", said("VGPRs")},
          {"spills", said("Spilled VGPRs")},    {"local_bytes", said("Scratch size")},
          {"shared_bytes", said("LDS size")},   {"occupancy", said("Subgroups per SIMD")}};
}

/// Prints a row for each module, then the driver's name.
void compile(const Path& folder) {
  std::vector<vulkan::Words> modules;
  for (Path file = folder / "0"; std::filesystem::exists(file);
       file = folder / std::to_string(modules.size())) {
    const std::string bytes = file_text(file);
    std::memcpy(modules.emplace_back(bytes.size() / sizeof(std::uint32_t)).data(), bytes.data(),
                bytes.size());
  }
  const std::string driver = vulkan::compile_by_radv(
      modules, [](const vulkan::MachineCode& code) { fmt::print("{}\n", fields_of(code).dump()); });
  fmt::print("{}\n", json(driver).dump());
}

void write_modules(std::span<const GpuProgram> programs, Word word, const Path& folder) {
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const vulkan::Words kept = vulkan::spirv_of(programs[i].kind);
    const vulkan::Words words = word == Word::kept ? kept : vulkan::without_no_contraction(kept);
    const auto bytes = std::as_bytes(std::span(words));
    write_text(folder / std::to_string(i), {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
}
#else
void compile(const Path& /*folder*/) {}

void write_modules(std::span<const GpuProgram> /*programs*/, Word /*word*/, const Path& /*folder*/) {
  throw DeviceError("this build was configured without Vulkan (-DHDMBENCH_VULKAN=ON), whose texts these are");
}
#endif

} // namespace

void compile_apart(int argc, const char* const* argv) {
  const auto folder = asked_subject(argc, argv, question);
  if (!folder) {
    return;
  }
  try {
    compile(*folder);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    std::fflush(stdout);
    std::_Exit(EXIT_FAILURE);
  }
  std::fflush(stdout);
  std::_Exit(EXIT_SUCCESS); // a driver's threads and handlers may hang
}

json compile_by_radv_apart(const GpuTarget& target, std::span<const GpuProgram> programs, Word word) {
  const TemporaryDirectory folder;
  write_modules(programs, word, folder.path());
  const MemoryFile output;
  const MemoryFile errors;
  const ProcessOptions options{
      .environment = {{"RADV_FORCE_FAMILY", std::string(target.name)}, {"MESA_SHADER_CACHE_DISABLE", "true"}},
      .seconds = 600.0};
  const ProcessEnd end =
      ask_own_program(question, folder.path().string(), output.path(), errors.path(), options);
  if (!end.good()) {
    throw DeviceError(end.exit_status == EXIT_FAILURE
                          ? file_text(errors.path())
                          : fmt::format("RADV {}: {}", end.sentence(options), file_text(errors.path())));
  }
  json rows = json::array();
  std::istringstream lines(file_text(output.path()));
  for (std::string line; std::getline(lines, line);) {
    rows.push_back(json::parse(line));
  }
  if (rows.size() != programs.size() + 1) {
    throw DeviceError(fmt::format("RADV answered {} times on {} programs", rows.size(), programs.size()));
  }
  return rows;
}

} // namespace hdmbench
