#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

/// What a command declares of itself. CLI11 does the work in command.cpp alone: its headers take six seconds
/// to compile wherever they are used, and thirty files declare commands.
namespace hdmbench::commands {

/// An option of a command, which owns it. Calls that declare return the option itself.
class Option {
public:
  explicit Option(CLI::Option* option) : option_(option) {}

  /// Values from `low` to `high`, both allowed.
  Option range(int low, int high);
  Option range(double low, double high);
  /// One of these words.
  Option one_of(const std::vector<std::string>& words);
  /// The heading above it in the help; empty: it is not in the help.
  Option group(std::string_view heading);
  /// Lists have this between their words.
  Option delimiter(char character);
  /// So many values.
  Option expected(int values);
  Option required();
  /// Shows the variable's value as the default in the help.
  Option capture_default_str();
  Option excludes(const std::string& name);
  Option needs(Option other);
  /// Where it is given several times, the last one counts.
  Option take_last();

  [[nodiscard]] std::string name() const;                    ///< "--size", or "scene" where it has no dashes
  [[nodiscard]] std::vector<std::string> long_names() const; ///< without dashes
  [[nodiscard]] std::string heading() const;                 ///< its group
  [[nodiscard]] bool is_positional() const;
  [[nodiscard]] bool takes_values() const;               ///< it is no flag
  [[nodiscard]] char delimiter() const;                  ///< 0: it is no list
  [[nodiscard]] std::size_t count() const;               ///< how often it was given
  [[nodiscard]] std::vector<std::string> values() const; ///< as they were given

private:
  CLI::Option* option_;
};

/// A command, or the program itself. It refers to what its program owns; variables must live as long as that.
class Command {
public:
  explicit Command(CLI::App& command) : command_(&command) {}

  [[nodiscard]] Command add_subcommand(const std::string& name, const std::string& description) const;
  /// For the types that command.cpp lists at its end. `names`: "--sizes,--size", or a word without dashes.
  template <typename Value>
  Option add_option(const std::string& names, Value& variable, const std::string& description) const;
  /// Calls `take` with the word that is given.
  Option add_option(const std::string& names, const std::function<void(const std::string&)>& take,
                    const std::string& description) const;
  Option add_flag(const std::string& names, bool& variable, const std::string& description) const;
  /// Calls `take` where the flag is given.
  Option add_flag(const std::string& names, const std::function<void()>& take,
                  const std::string& description) const;
  /// What runs where the user calls the command.
  void callback(const std::function<void()>& run) const;

  [[nodiscard]] std::string name() const;
  [[nodiscard]] std::vector<Option> options() const;
  /// None where there is no option of this name.
  [[nodiscard]] std::optional<Option> find(const std::string& option) const;
  /// The same, which has to be there: throws CLI::OptionNotFound.
  [[nodiscard]] Option option(const std::string& name) const;
  /// How often that option was given.
  [[nodiscard]] std::size_t count(const std::string& option) const;

private:
  CLI::App* command_;
};

} // namespace hdmbench::commands
