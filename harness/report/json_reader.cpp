#include "harness/report/json_reader.hpp"

#include "harness/report/joined.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <system_error>
#include <utility>

namespace hdmbench::report {

namespace {

/// Result files nest six deep; the limit keeps whatever walks through them by recursion off the end of the
/// stack.
constexpr int deepest = 100;

} // namespace

nlohmann::json read_json(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) {
    throw InputError(fmt::format("{}: is a folder, not a result file", file.string()));
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    const std::error_code error(errno, std::generic_category());
    throw InputError(fmt::format("{}: cannot be read: {}", file.string(), error.message()));
  }
  try {
    return nlohmann::json::parse(stream, [&](int depth, auto /*event*/, const auto& /*parsed*/) {
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

JsonReader::JsonReader(const nlohmann::json& object, std::filesystem::path file, std::string where)
    : object_(&object), file_(std::move(file)), where_(std::move(where)) {
  if (!object_->is_object()) {
    throw InputError(fmt::format("{}: {} must be an object, but is {}", file_.string(),
                                 where_.empty() ? "the document" : '"' + where_ + '"', object_->type_name()));
  }
}

std::string JsonReader::text(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (!found.is_string()) {
    fail_type(key, "a string");
  }
  return found.get<std::string>();
}

std::string JsonReader::text(const std::string& key, const std::vector<std::string>& allowed) const {
  std::string found = text(key);
  if (std::ranges::find(allowed, found) == allowed.end()) {
    fail(key, fmt::format("is \"{}\", but must be one of: {}", found, joined(allowed, ", ")));
  }
  return found;
}

std::vector<std::string> JsonReader::texts(const std::string& key) const {
  const nlohmann::json& found = value(key);
  const auto is_text = [](const nlohmann::json& element) { return element.is_string(); };
  if (!found.is_array() || !std::ranges::all_of(found, is_text)) {
    fail_type(key, "an array of strings");
  }
  return found.get<std::vector<std::string>>();
}

bool JsonReader::flag(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (!found.is_boolean()) {
    fail_type(key, "true or false");
  }
  return found.get<bool>();
}

std::int64_t JsonReader::count(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (!found.is_number_integer()) {
    fail_type(key, "an integer");
  }
  const auto number = found.get<std::int64_t>();
  if (number < 0) {
    fail(key, fmt::format("is {}, but must not be negative", found.dump()));
  }
  return number;
}

double JsonReader::number(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (!found.is_number()) {
    fail_type(key, "a number");
  }
  return found.get<double>();
}

std::optional<double> JsonReader::number_or_null(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (found.is_null()) {
    return std::nullopt;
  }
  if (!found.is_number()) {
    fail_type(key, "a number or null");
  }
  return found.get<double>();
}

std::vector<double> JsonReader::numbers(const std::string& key) const {
  const nlohmann::json& found = value(key);
  const auto is_number = [](const nlohmann::json& element) { return element.is_number(); };
  if (!found.is_array() || !std::ranges::all_of(found, is_number)) {
    fail_type(key, "an array of numbers");
  }
  return found.get<std::vector<double>>();
}

std::vector<double> JsonReader::numbers_or_gaps(const std::string& key) const {
  const nlohmann::json& found = value(key);
  const auto fits = [](const nlohmann::json& element) { return element.is_number() || element.is_null(); };
  if (!found.is_array() || !std::ranges::all_of(found, fits)) {
    fail_type(key, "an array of numbers or null");
  }
  std::vector<double> result;
  result.reserve(found.size());
  for (const nlohmann::json& element : found) {
    result.push_back(element.is_null() ? std::nan("") : element.get<double>());
  }
  return result;
}

std::vector<std::vector<double>> JsonReader::lists_of_numbers(const std::string& key) const {
  const nlohmann::json& found = value(key);
  const auto is_number = [](const nlohmann::json& element) { return element.is_number(); };
  const auto is_list = [&](const nlohmann::json& list) {
    return list.is_array() && std::ranges::all_of(list, is_number);
  };
  if (!found.is_array() || !std::ranges::all_of(found, is_list)) {
    fail_type(key, "an array of arrays of numbers");
  }
  return found.get<std::vector<std::vector<double>>>();
}

JsonReader JsonReader::object(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (!found.is_object()) {
    fail_type(key, "an object");
  }
  return {found, file_, path_of(key)};
}

std::optional<JsonReader> JsonReader::object_or_null(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (found.is_null()) {
    return std::nullopt;
  }
  if (!found.is_object()) {
    fail_type(key, "an object or null");
  }
  return JsonReader(found, file_, path_of(key));
}

std::vector<JsonReader> JsonReader::objects(const std::string& key) const {
  const nlohmann::json& found = value(key);
  if (!found.is_array()) {
    fail_type(key, "an array");
  }
  std::vector<JsonReader> result;
  for (const nlohmann::json& element : found) {
    result.emplace_back(element, file_, fmt::format("{}[{}]", path_of(key), result.size()));
  }
  return result;
}

void JsonReader::fail(const std::string& key, const std::string& what) const {
  throw InputError(fmt::format("{}: \"{}\" {}", file_.string(), path_of(key), what));
}

const nlohmann::json& JsonReader::value(const std::string& key) const {
  const auto found = object_->find(key);
  if (found == object_->end()) {
    fail(key, "is missing");
  }
  return *found;
}

void JsonReader::fail_type(const std::string& key, const std::string& expected) const {
  fail(key, fmt::format("must be {}, but is {}", expected, value(key).type_name()));
}

std::string JsonReader::path_of(const std::string& key) const {
  return where_.empty() ? key : where_ + '.' + key;
}

void require_samples(const JsonReader& json, const std::vector<double>& seconds,
                     const std::optional<double>& median) {
  if (seconds.empty() || !median) {
    json.fail("valid", "is true although there are no seconds");
  }
  const auto [low, high] = std::ranges::minmax(seconds);
  if (low <= 0.0) {
    json.fail("seconds", "must be greater than 0");
  }
  if (*median < low || *median > high) {
    json.fail("seconds_median", "is not between the smallest and the largest of \"seconds\"");
  }
}

} // namespace hdmbench::report
