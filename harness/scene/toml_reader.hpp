#pragma once

#include "kernels/data/input_error.hpp"

#include <toml++/toml.h>

#include <array>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A TOML text; `file` is for errors. Throws toml::parse_error, and InputError for keys of so many parts that
/// reading them would end the stack.
[[nodiscard]] toml::table parse_toml(const std::string& text, const std::string& file);

/// Typed access to one table of a scene file. Every error is an InputError with file and line. No key is
/// silently ignored: one that the table cannot have is refused at once, and finish() refuses one that nobody
/// asked for, because it has no effect in this scene. Numbers are checked by the table of keys in
/// toml_reader.cpp.
class TomlReader {
public:
  /// `where` names the table in errors: "[schedule]". The table must outlive the reader. Throws InputError
  /// for a key that this table cannot have.
  TomlReader(const toml::table& table, std::string file, std::string where);

  /// These ask for a key, too.
  [[nodiscard]] bool has(std::string_view key) { return find(key) != nullptr; }

  /// Whether the key is there and a list; asks for it, too.
  [[nodiscard]] bool is_list(std::string_view key);

  /// The value of a key that must be there: a double, int, bool, std::string, std::array<double, 2> or
  /// std::vector<float>.
  template <typename Value>
  [[nodiscard]] Value get(std::string_view key);

  /// The value of a key that must be there as the command line takes it: a text, a number or several with
  /// commas.
  [[nodiscard]] std::string text(std::string_view key);

  /// A list of so many numbers that must be there, one along each axis where at most three.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, std::size_t least, std::size_t most);

  /// Leaves `into` as it is where the key is not there.
  template <typename Value>
  void read(std::string_view key, Value& into) {
    if (has(key)) {
      into = get<Value>(key);
    }
  }
  template <typename Value>
  void read(std::string_view key, std::optional<Value>& into) {
    if (has(key)) {
      into = get<Value>(key);
    }
  }
  /// One of `choices`, the names of the enumerators.
  template <typename Enumeration>
  void read(std::string_view key, std::span<const std::string_view> choices, Enumeration& into) {
    if (has(key)) {
      into = static_cast<Enumeration>(choice(key, choices));
    }
  }
  /// Returns the index of the value in `choices`, among which it must be.
  [[nodiscard]] std::size_t choice(std::string_view key, std::span<const std::string_view> choices);

  /// Calls `use`; what it refuses is the fault of `key`.
  template <typename Use>
  void blame(std::string_view key, const Use& use) const {
    try {
      use();
    } catch (const InputError& error) {
      fail(key, std::string("is wrong: ") + error.what());
    }
  }

  /// A table inside this one; an empty one if it is absent.
  [[nodiscard]] TomlReader table(std::string_view key);
  /// The tables of [[key]], none if absent.
  [[nodiscard]] std::vector<TomlReader> tables(std::string_view key);

  /// Throws InputError where the table has `key`, unless it `has_effect`; says where the key belongs.
  void refuse_unless(bool has_effect, std::string_view key) const;
  /// Does the same for every key that nobody asked for.
  void finish() const;

  /// Throws InputError("FILE:LINE: WHERE key message").
  [[noreturn]] void fail(std::string_view key, std::string_view message) const;

private:
  [[nodiscard]] const toml::node* find(std::string_view key);
  [[nodiscard]] const toml::node& require(std::string_view key);
  [[nodiscard]] double number(std::string_view key, const toml::node& node) const;

  const toml::table& table_;
  std::string file_;
  std::string where_;
  std::set<std::string, std::less<>> asked_for_;
};

template <>
std::string TomlReader::get(std::string_view key);
template <>
double TomlReader::get(std::string_view key);
template <>
bool TomlReader::get(std::string_view key);
template <>
int TomlReader::get(std::string_view key);
template <>
std::array<double, 2> TomlReader::get(std::string_view key);
template <>
std::vector<float> TomlReader::get(std::string_view key);

} // namespace hdmbench
