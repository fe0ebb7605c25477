#include "harness/cli/commands.hpp"

#include <filesystem>
#include <optional>
#include <vector>

namespace hdmbench::commands {

template <typename Value>
CLI::Option* add_option(CLI::App& command, const std::string& names, Value& variable,
                        const std::string& help) {
  return command.add_option(names, variable, help);
}

CLI::Option* add_flag(CLI::App& command, const std::string& names, bool& variable, const std::string& help) {
  return command.add_flag(names, variable, help);
}

// The types that a command may have options of.
#define HDMBENCH_OPTION_OF(...)                                                                              \
  template CLI::Option* add_option(CLI::App&, const std::string&, __VA_ARGS__&, const std::string&);
HDMBENCH_OPTION_OF(std::string)
HDMBENCH_OPTION_OF(std::filesystem::path)
HDMBENCH_OPTION_OF(int)
HDMBENCH_OPTION_OF(std::size_t)
HDMBENCH_OPTION_OF(double)
HDMBENCH_OPTION_OF(std::optional<std::string>)
HDMBENCH_OPTION_OF(std::optional<int>)
HDMBENCH_OPTION_OF(std::optional<double>)
HDMBENCH_OPTION_OF(std::vector<std::string>)
HDMBENCH_OPTION_OF(std::vector<std::filesystem::path>)
HDMBENCH_OPTION_OF(std::vector<int>)
HDMBENCH_OPTION_OF(std::vector<double>)
#undef HDMBENCH_OPTION_OF

} // namespace hdmbench::commands
