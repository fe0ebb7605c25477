// What every command goes through: its options become CLI11's, its words and its outputs are checked.

#include "harness/cli/arguments.hpp"

#include "harness/ranks/message_passing.hpp"

#include <iterator>
#include <sstream>
#include <utility>

namespace hdmbench::commands {

bool Call::speaks() const {
  return ranks == nullptr || ranks->is_first();
}

SessionOptions Call::session() const {
  return {.device = (*this)[option::device], .threads = (*this)[option::threads]};
}

void Call::write(nlohmann::json rows, std::string_view kind) const {
  if (speaks()) {
    write_results((*this)[option::json], kind.empty() ? command->get_name() : kind,
                  run_context(line, (*this)[option::quick]), std::move(rows));
  }
}

void Call::keep(const nlohmann::json& rows, std::string_view kind) const {
  if (speaks() && (*this)[option::json] != results_to_standard_output) {
    write_results((*this)[option::json], kind.empty() ? command->get_name() : kind,
                  run_context(line, (*this)[option::quick]), rows, true);
  }
}

template <typename Value>
void add_option(CLI::App& command, Call& call, const Option<Value>& option) {
  Value& value = call[option];
  if constexpr (std::is_same_v<Value, bool>) {
    command.add_flag(option.names, value, option.help);
  } else {
    constexpr bool is_file = std::is_same_v<Value, OutputFile>;
    constexpr bool is_output = is_file || std::is_same_v<Value, OutputFolder>;
    using Read = std::conditional_t<is_output, std::filesystem::path, Value>;
    CLI::Option& added = *command.add_option(option.names, static_cast<Read&>(value), option.help);
    added.capture_default_str();
    if (const std::string text = added.get_default_str(); text == "[]" || text == "0") {
      added.default_str("");
    }
    if (!added.get_positional() && added.get_items_expected_max() > 1) {
      added.delimiter(',');
    }
    if (option.count > 0) {
      added.expected(option.count);
    }
    if (!option.check.get_description().empty()) {
      added.check(option.check);
    }
    const std::string_view content = content_names.at(static_cast<std::size_t>(option.content));
    if (is_output) {
      added.type_name(
          fmt::format("{}{}{}", is_file ? "FILE" : "FOLDER", content.empty() ? "" : ":", content));
    } else if (!content.empty()) {
      added.type_name(std::string(content));
    }
  }
}

// The types that a command may have options of.
#define HDMBENCH_OPTION_OF(...) template void add_option(CLI::App&, Call&, const Option<__VA_ARGS__>&);
HDMBENCH_OPTION_OF(bool)
HDMBENCH_OPTION_OF(std::string)
HDMBENCH_OPTION_OF(std::filesystem::path)
HDMBENCH_OPTION_OF(OutputFile)
HDMBENCH_OPTION_OF(OutputFolder)
HDMBENCH_OPTION_OF(int)
HDMBENCH_OPTION_OF(std::size_t)
HDMBENCH_OPTION_OF(double)
HDMBENCH_OPTION_OF(std::optional<int>)
HDMBENCH_OPTION_OF(std::optional<double>)
HDMBENCH_OPTION_OF(std::vector<std::string>)
HDMBENCH_OPTION_OF(std::vector<std::filesystem::path>)
HDMBENCH_OPTION_OF(std::vector<int>)
HDMBENCH_OPTION_OF(std::vector<double>)
#undef HDMBENCH_OPTION_OF

Options Options::without(std::initializer_list<std::string_view> names) const {
  Options rest = *this;
  std::erase_if(rest.all_, [&](const One& one) { return contains(names, one.names); });
  return rest;
}

Options Options::under(const char* heading) const {
  Options moved = *this;
  std::ranges::for_each(moved.all_, [&](One& one) { one.heading = heading; });
  return moved;
}

void Options::add_to(CLI::App& command, Call& call) const {
  for (const One& one : all_) {
    command.option_defaults()->group(one.heading);
    one.add(command, call);
  }
}

void add_command(CLI::App& program, Call& call, const char* name, int (*run)(Call& call), const char* help,
                 const Options& options, const std::vector<std::string>& rules, bool takes_energies) {
  CLI::App& command = *program.add_subcommand(name, help);
  options.add_to(command, call);
  for (const std::string& rule : rules) {
    std::istringstream words(rule);
    std::string subject;
    std::string verb;
    words >> subject >> verb;
    CLI::Option& option = *command.get_option(subject);
    for (std::string other; words >> other;) {
      verb == "is" ? option.required() : verb == "needs" ? option.needs(other) : option.excludes(other);
    }
  }
  // A map that moves keeps its elements in place, and CLI11 writes to these.
  command.callback([&, run, takes_energies,
                    own = std::make_shared<decltype(call.values)>(std::exchange(call.values, {}))] {
    call.command = &command;
    call.values = std::move(*own);
    call.schedule.takes_energies = takes_energies;
    call.status = run(call);
  });
}

void refuse_idle(const CLI::App& command, const std::vector<std::string>& options, std::string_view why) {
  std::vector<std::string> given;
  std::ranges::copy_if(options, std::back_inserter(given),
                       [&](const std::string& option) { return command.count(option) > 0; });
  if (!given.empty()) {
    throw InputError(
        fmt::format("{} {} no effect here: {}", joined(given, ", "), given.size() > 1 ? "have" : "has", why));
  }
}

void require_known_options(const CLI::App& command, const std::vector<std::string>& words) {
  std::vector<std::string> known{"--help"};
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      known.push_back("--" + name);
    }
  }
  for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) { // what follows "--" are no options
    const std::size_t equals = words[i].find('=');
    const std::string name = words[i].substr(0, equals);
    if (!name.starts_with("--")) {
      continue;
    }
    if (!contains(known, name)) {
      throw InputError(fmt::format(
          "{} has no option {}; {}", command.get_name(), name,
          did_you_mean(name, known, fmt::format("hdmbench {} --help lists them", command.get_name()))));
    }
    const std::string list = equals != std::string::npos ? words[i].substr(equals + 1)
                             : i + 1 < words.size()      ? words[i + 1]
                                                         : name;
    const bool is_list = command.get_option(name)->get_delimiter() == ',';
    if (is_list && fmt::format(",{},", list).find(",,") != std::string::npos) {
      throw InputError(fmt::format("{} {}: a word is missing before or after a comma", name, list));
    }
  }
}

void require_outputs(const CLI::App& command) {
  namespace fs = std::filesystem;
  std::vector<fs::path> inputs;
  std::vector<fs::path> outputs;
  for (const CLI::Option* const option : command.get_options()) {
    const std::string type = option->get_type_name();
    for (const std::string& value : option->results()) {
      std::error_code missing;
      if (type.starts_with("FILE") || type == "FOLDER") {
        outputs.emplace_back(value);
        if (type != "FOLDER") {
          require_results_writable(value);
        }
      } else if (fs::is_directory(value, missing)) {
        std::ranges::copy_if(fs::directory_iterator(value, missing), std::back_inserter(inputs),
                             [](const fs::path& file) { return file.extension() == ".json"; });
      } else {
        std::ranges::move(files_of_scene(value), std::back_inserter(inputs));
      }
    }
  }
  for (const fs::path& output : outputs) {
    require_no_input(output, inputs);
  }
}

} // namespace hdmbench::commands
