#include "harness/cli/command.hpp"

#include <CLI/CLI.hpp>

#include <filesystem>

namespace hdmbench::commands {

Option Option::range(int low, int high) {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option Option::range(double low, double high) {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option Option::group(std::string_view heading) {
  option_->group(std::string(heading));
  return *this;
}

Option Option::delimiter(char character) {
  option_->delimiter(character);
  return *this;
}

Option Option::expected(int values) {
  option_->expected(values);
  return *this;
}

Option Option::required() {
  option_->required();
  return *this;
}

Option Option::capture_default_str() {
  option_->capture_default_str();
  return *this;
}

Option Option::excludes(const std::string& name) {
  option_->excludes(name);
  return *this;
}

Option Option::needs(Option other) {
  option_->needs(other.option_);
  return *this;
}

Option Option::take_last() {
  option_->take_last();
  return *this;
}

std::string Option::name() const {
  return option_->get_name();
}

std::vector<std::string> Option::long_names() const {
  return option_->get_lnames();
}

std::string Option::heading() const {
  return option_->get_group();
}

bool Option::is_positional() const {
  return option_->get_positional();
}

bool Option::takes_values() const {
  return option_->get_items_expected_max() > 0;
}

char Option::delimiter() const {
  return option_->get_delimiter();
}

std::size_t Option::count() const {
  return option_->count();
}

std::vector<std::string> Option::values() const {
  return option_->results();
}

Command Command::add_subcommand(const std::string& name, const std::string& description) const {
  return Command(*command_->add_subcommand(name, description));
}

template <typename Value>
Option Command::add_option(const std::string& names, Value& variable, const std::string& description) const {
  return Option(command_->add_option(names, variable, description));
}

Option Command::add_option(const std::string& names, const std::function<void(const std::string&)>& take,
                           const std::string& description) const {
  return Option(command_->add_option_function<std::string>(names, take, description));
}

Option Command::add_flag(const std::string& names, bool& variable, const std::string& description) const {
  return Option(command_->add_flag(names, variable, description));
}

Option Command::add_flag(const std::string& names, const std::function<void()>& take,
                         const std::string& description) const {
  return Option(command_->add_flag_callback(names, take, description));
}

void Command::callback(const std::function<void()>& run) const {
  command_->callback(run);
}

std::string Command::name() const {
  return command_->get_name();
}

std::vector<Option> Command::options() const {
  std::vector<Option> all;
  for (CLI::Option* const option : command_->get_options()) {
    all.emplace_back(option);
  }
  return all;
}

std::optional<Option> Command::find(const std::string& option) const {
  CLI::Option* const found = command_->get_option_no_throw(option);
  return found == nullptr ? std::nullopt : std::optional(Option(found));
}

Option Command::option(const std::string& name) const {
  return Option(command_->get_option(name));
}

std::size_t Command::count(const std::string& option) const {
  return command_->count(option);
}

// The types that a command may have options of.
#define HDMBENCH_OPTION_OF(...)                                                                              \
  template Option Command::add_option(const std::string&, __VA_ARGS__&, const std::string&) const;
HDMBENCH_OPTION_OF(std::string)
HDMBENCH_OPTION_OF(std::filesystem::path)
HDMBENCH_OPTION_OF(int)
HDMBENCH_OPTION_OF(std::size_t)
HDMBENCH_OPTION_OF(double)
HDMBENCH_OPTION_OF(std::optional<std::string>)
HDMBENCH_OPTION_OF(std::optional<std::filesystem::path>)
HDMBENCH_OPTION_OF(std::optional<int>)
HDMBENCH_OPTION_OF(std::optional<double>)
HDMBENCH_OPTION_OF(std::vector<std::string>)
HDMBENCH_OPTION_OF(std::vector<std::filesystem::path>)
HDMBENCH_OPTION_OF(std::vector<int>)
HDMBENCH_OPTION_OF(std::vector<unsigned>)
HDMBENCH_OPTION_OF(std::vector<double>)
#undef HDMBENCH_OPTION_OF

} // namespace hdmbench::commands
