#include "harness/measure/result_file.hpp"

#include "backends/cpu/cpu.hpp"
#include "harness/scene/files.hpp"
#include "kernels/data/input_error.hpp"

#include <build_information.hpp>
#include <commit.hpp>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <ctime>
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

Context run_context(std::string_view arguments, bool quick) {
  utsname names{};
  uname(&names);
  const std::string cpu = cpu_device("").name;
  const unsigned cores = std::thread::hardware_concurrency();
  double load = 0.0;
  (void)getloadavg(&load, 1);
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
          .quick = quick,
          .load = load};
}

namespace {

constexpr int schema = 1;

/// Result files nest six deep; the limit keeps whatever walks through them by recursion off the end of the
/// stack.
constexpr int deepest = 100;

nlohmann::json parse(const std::filesystem::path& file) {
  try {
    return nlohmann::json::parse(read_file(file), [&](int depth, auto /*event*/, const auto& /*parsed*/) {
      if (depth > deepest) {
        throw InputError(fmt::format("{}: objects and arrays are more than {} deep in each other",
                                     file.string(), deepest));
      }
      return true;
    });
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: is not JSON: {}", file.string(), error.what()));
  }
}

} // namespace

ResultFile read_results(const std::filesystem::path& file) {
  const nlohmann::json document = parse(file);
  const auto refuse = [&](std::string_view why) {
    throw InputError(fmt::format("{}: {}", file.string(), why));
  };
  if (!document.is_object()) {
    refuse("must be an object");
  }
  const auto read = [&](const char* key, auto& value) {
    try {
      document.at(key).get_to(value);
    } catch (const nlohmann::json::exception& error) {
      refuse(fmt::format("\"{}\": {}", key, error.what()));
    }
  };
  int found = 0;
  read("schema", found);
  if (found != schema) {
    refuse(fmt::format("is of schema {}, but this program reads schema {}", found, schema));
  }
  ResultFile result;
  result.file = file;
  read("command", result.command);
  read("context", result.context);
  read("results", result.results);
  result.cut = document.value("cut", nlohmann::json(false)) == true;
  if (!result.results.is_array()) {
    refuse("\"results\" must be an array");
  }
  if (document.contains("arithmetic")) {
    read("arithmetic", result.arithmetic);
    if (!result.arithmetic.is_array()) {
      refuse("\"arithmetic\" must be an array");
    }
  }
  return result;
}

void require_results_writable(const std::filesystem::path& file) {
  if (!file.empty() && file != results_to_standard_output) {
    require_writable(file);
  }
}

void write_results(const std::filesystem::path& file, std::string_view command, const Context& context,
                   nlohmann::json results, bool cut) {
  if (file.empty() || (cut && !is_replaced(file))) {
    return;
  }
  nlohmann::ordered_json document{
      {"schema", schema}, {"command", command}, {"context", nlohmann::json(context)}};
  if (cut) {
    document["cut"] = true;
  }
  document["results"] = std::move(results);
  std::string text;
  try {
    text = document.dump(1);
  } catch (const nlohmann::json::type_error&) {
    text = json_text(document, 1);
    fmt::print(stderr, "{}: a name in it is not UTF-8; U+FFFD stands for what is no character\n",
               printable(file.string()));
  }
  write_text(file == results_to_standard_output ? "/dev/stdout" : file, text + "\n");
}

} // namespace hdmbench
