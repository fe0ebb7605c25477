#include "harness/context.hpp"

#include "backends/cpu_device.hpp"
#include "harness/file_output.hpp"

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

/// As dump(1), but arrays of numbers stay on one line: a profile of 300 values is for machines. As deep as
/// our own documents, so recursion does.
// NOLINTNEXTLINE(misc-no-recursion)
void append_json(std::string& text, const nlohmann::ordered_json& value, std::size_t depth) {
  const bool flat =
      !value.is_structured() || value.empty() ||
      (value.is_array() && std::ranges::none_of(value, [](const auto& item) { return !item.is_number(); }));
  if (flat) {
    text += value.dump();
    return;
  }
  const bool object = value.is_object();
  text += object ? '{' : '[';
  bool first = true;
  for (const auto& [key, item] : value.items()) {
    text += first ? "\n" : ",\n";
    first = false;
    text.append(depth + 1, ' ');
    if (object) {
      text += nlohmann::json(key).dump() + ": ";
    }
    append_json(text, item, depth + 1);
  }
  text += '\n';
  text.append(depth, ' ');
  text += object ? '}' : ']';
}

} // namespace

nlohmann::json run_context(std::string_view arguments, bool quick) {
  utsname names{};
  uname(&names);
  const std::string cpu = cpu_device("").name;
  const unsigned cores = std::thread::hardware_concurrency();
  return {{"machine", fmt::format("{}, {} cores", cpu, cores)},
          {"cpu", cpu},
          {"cores", cores},
          {"architecture", names.machine},
          {"operating_system", operating_system()},
          {"compiler", build::compiler},
          {"flags", fmt::format("{} (scalar: -O2)", build::flags)},
          {"commit", build::commit},
          {"version", build::version},
          {"date", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))},
          {"arguments", arguments},
          {"quick", quick}};
}

void write_results(const std::filesystem::path& file, std::string_view command, nlohmann::json context,
                   nlohmann::json results) {
  const nlohmann::ordered_json document{
      {"schema", 1}, {"command", command}, {"context", std::move(context)}, {"results", std::move(results)}};
  std::string text;
  append_json(text, document, 0);
  write_text(file, text + "\n");
}

} // namespace hdmbench
