#include "harness/measure/context.hpp"

#include "backends/cpu/processor.hpp"
#include "harness/scene/row_fields.hpp"

#include <build_information.hpp>
#include <commit.hpp>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <fstream>
#include <thread>

namespace hdmbench {

namespace {

/// PRETTY_NAME of /etc/os-release, else the kernel's name.
std::string operating_system() {
  std::ifstream file("/etc/os-release");
  for (std::string line; std::getline(file, line);) {
    constexpr std::string_view key = "PRETTY_NAME=\"";
    if (line.starts_with(key) && line.size() > key.size()) {
      return line.substr(key.size(), line.size() - key.size() - 1);
    }
  }
  utsname names{};
  uname(&names);
  return fmt::format("{} {}", names.sysname, names.release);
}

} // namespace

void list_fields(Fields& fields, Context& context) {
  fields("machine", context.machine);
  fields("cpu", context.cpu);
  fields("cores", context.cores);
  fields.newer("architecture", context.architecture);
  fields("operating_system", context.operating_system);
  fields("compiler", context.compiler);
  fields("flags", context.flags);
  fields("commit", context.commit);
  fields("version", context.version);
  fields("date", context.date);
  fields("arguments", context.arguments);
  fields("quick", context.quick);
}

Context run_context(std::string_view arguments, bool quick) {
  utsname names{};
  uname(&names);
  const std::string cpu = cpu_device("").name;
  const unsigned cores = std::thread::hardware_concurrency();
  return {.machine = fmt::format("{}, {} cores", cpu, cores),
          .cpu = cpu,
          .cores = cores,
          .architecture = names.machine,
          .operating_system = operating_system(),
          .compiler = std::string(build::compiler),
          .flags = fmt::format("{} (scalar: -O2)", build::flags),
          .commit = std::string(build::commit),
          .version = std::string(build::version),
          .date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))),
          .arguments = std::string(arguments),
          .quick = quick};
}

} // namespace hdmbench
