#include "harness/cli/commands.hpp"

#include "harness/measure/result_file.hpp"
#include "harness/ranks/message_passing.hpp"

#include <optional>
#include <utility>
#include <vector>

namespace hdmbench::commands {

bool Call::speaks() const {
  return ranks == nullptr || ranks->is_first();
}

void Call::write(nlohmann::json rows, bool quick, std::string_view kind) const {
  if (speaks()) {
    write_results(json, kind.empty() ? command->get_name() : kind, run_context(line, quick), std::move(rows));
  }
}

template <typename Value>
CLI::Option* add_option(CLI::App& command, const std::string& names, Value& variable,
                        const std::string& help) {
  return command.add_option(names, variable, help);
}

CLI::Option* add_flag(CLI::App& command, const std::string& names, bool& variable, const std::string& help) {
  return command.add_flag(names, variable, help);
}

CLI::Option* add_output(CLI::App& command, const std::string& names, std::filesystem::path& file,
                        const std::string& help) {
  return command.add_option(names, file, help)->type_name("FILE");
}

CLI::Option* add_output_folder(CLI::App& command, std::filesystem::path& folder, const std::string& help) {
  return command.add_option("--output", folder, help)->type_name("FOLDER");
}

CLI::Option* add_json(CLI::App& command, Call& call, const std::string& help) {
  return add_output(command, "--json", call.json, help);
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
