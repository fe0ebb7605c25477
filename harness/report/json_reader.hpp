#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench::report {

/// Parses a file. Throws InputError naming it where it cannot be read or is not JSON.
[[nodiscard]] nlohmann::json read_json(const std::filesystem::path& file);

/// One JSON object whose keys are required: each access throws InputError naming the file and the key where
/// the key is missing or its value has another type. Refers to the JSON, which must outlive it.
class JsonReader {
public:
  /// `where` is the path of `object` inside the file: "" or "results[3]".
  JsonReader(const nlohmann::json& object, std::filesystem::path file, std::string where);

  [[nodiscard]] std::string text(const std::string& key) const;
  /// A text that must be one of `allowed`.
  [[nodiscard]] std::string text(const std::string& key, const std::vector<std::string>& allowed) const;
  [[nodiscard]] std::vector<std::string> texts(const std::string& key) const;
  [[nodiscard]] bool flag(const std::string& key) const;
  /// >= 0
  [[nodiscard]] std::int64_t count(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key) const;
  /// JSON has no NaN and no infinity: writers put null, which is `nullopt` here.
  [[nodiscard]] std::optional<double> number_or_null(const std::string& key) const;
  [[nodiscard]] std::vector<double> numbers(const std::string& key) const;
  /// null becomes NaN
  [[nodiscard]] std::vector<double> numbers_or_gaps(const std::string& key) const;
  [[nodiscard]] std::vector<std::vector<double>> lists_of_numbers(const std::string& key) const;
  [[nodiscard]] JsonReader object(const std::string& key) const;
  [[nodiscard]] std::optional<JsonReader> object_or_null(const std::string& key) const;
  [[nodiscard]] std::vector<JsonReader> objects(const std::string& key) const;

  [[nodiscard]] bool has(const std::string& key) const { return object_->contains(key); }
  /// Whether `key` is there and not null.
  [[nodiscard]] bool holds(const std::string& key) const { return has(key) && !object_->at(key).is_null(); }
  [[nodiscard]] const nlohmann::json& json() const { return *object_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

  /// Throws InputError about `key` of this object.
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

private:
  [[nodiscard]] const nlohmann::json& value(const std::string& key) const;
  [[noreturn]] void fail_type(const std::string& key, const std::string& expected) const;
  [[nodiscard]] std::string path_of(const std::string& key) const;

  const nlohmann::json* object_;
  std::filesystem::path file_;
  std::string where_;
};

/// Throws InputError about "seconds" or "seconds_median" of `json` unless there are samples, all of them
/// greater than 0, with the median between them.
void require_samples(const JsonReader& json, const std::vector<double>& seconds,
                     const std::optional<double>& median);

} // namespace hdmbench::report
