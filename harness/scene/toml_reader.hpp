#pragma once

#include <toml++/toml.h>

#include <array>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// Typed access to one table of a scene file. Every error is an InputError with file and line. No key is
/// silently ignored: one that the table cannot have is refused at once, and finish() refuses one that nobody
/// asked for, because it has no effect in this scene.
class TomlReader {
public:
  /// `where` names the table in errors: "[schedule]". The table must outlive the reader. Throws InputError
  /// for a key that this table cannot have.
  TomlReader(const toml::table& table, std::string file, std::string where);

  /// These ask for a key, too.
  [[nodiscard]] bool has(std::string_view key) { return find(key) != nullptr; }
  [[nodiscard]] bool is_text(std::string_view key) { return has(key) && find(key)->is_string(); }

  [[nodiscard]] std::string text(std::string_view key);
  [[nodiscard]] std::string text(std::string_view key, std::string_view fallback) {
    return has(key) ? text(key) : std::string(fallback);
  }
  [[nodiscard]] double number(std::string_view key);
  [[nodiscard]] double number(std::string_view key, double fallback) {
    return has(key) ? number(key) : fallback;
  }
  [[nodiscard]] std::optional<double> optional_number(std::string_view key) {
    return has(key) ? std::optional(number(key)) : std::nullopt;
  }
  [[nodiscard]] bool boolean(std::string_view key, bool fallback);
  [[nodiscard]] int integer(std::string_view key);
  [[nodiscard]] std::array<double, 2> pair(std::string_view key);
  [[nodiscard]] std::vector<float> numbers(std::string_view key);
  /// One of `choices`; returns its index.
  [[nodiscard]] std::size_t choice(std::string_view key, std::span<const std::string_view> choices,
                                   std::size_t fallback);

  /// A table inside this one; an empty one if it is absent.
  [[nodiscard]] TomlReader table(std::string_view key);
  /// The tables of [[key]], none if absent.
  [[nodiscard]] std::vector<TomlReader> tables(std::string_view key);

  /// Throws InputError where the table has `key`, unless it `has_effect`; says where the key belongs.
  void refuse_unless(bool has_effect, std::string_view key) const;
  /// Does the same for every key that nobody asked for.
  void finish() const;

  /// Throws InputError("FILE:LINE: WHERE key: message").
  [[noreturn]] void fail(std::string_view key, std::string_view message) const;

private:
  [[nodiscard]] const toml::node* find(std::string_view key);
  [[nodiscard]] const toml::node& require(std::string_view key);
  [[nodiscard]] double as_number(std::string_view key, const toml::node& node) const;

  const toml::table& table_;
  std::string file_;
  std::string where_;
  std::set<std::string, std::less<>> asked_for_;
};

} // namespace hdmbench
