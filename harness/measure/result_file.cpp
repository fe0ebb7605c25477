#include "harness/measure/result_file.hpp"

#include "harness/scene/file_input.hpp"
#include "harness/scene/file_output.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

namespace {

constexpr int schema = 1;

/// Result files nest six deep; the limit keeps whatever walks through them by recursion off the end of the
/// stack.
constexpr int deepest = 100;

/// As dump(1), but arrays of numbers stay on one line: a profile of 300 values is for machines. As deep as
/// our own documents, so recursion does.
// NOLINTNEXTLINE(misc-no-recursion)
void append_json(std::string& text, const nlohmann::ordered_json& value, std::size_t depth) {
  const bool flat =
      !value.is_structured() || value.empty() ||
      (value.is_array() && std::ranges::none_of(value, [](const auto& item) { return !item.is_number(); }));
  if (flat) {
    text += value.dump();
    return;
  }
  const bool object = value.is_object();
  text += object ? '{' : '[';
  bool first = true;
  for (const auto& [key, item] : value.items()) {
    text += first ? "\n" : ",\n";
    first = false;
    text.append(depth + 1, ' ');
    if (object) {
      text += nlohmann::json(key).dump() + ": ";
    }
    append_json(text, item, depth + 1);
  }
  text += '\n';
  text.append(depth, ' ');
  text += object ? '}' : ']';
}

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
  nlohmann::json document = parse(file);
  const JsonPlace place{file};
  Fields fields(document, place);
  int found = 0;
  fields("schema", found);
  if (found != schema) {
    place.key("schema").fail(fmt::format("is {}, but this program reads schema {}", found, schema));
  }
  ResultFile result{.file = file, .command = {}, .context = {}, .results = {}};
  fields("command", result.command);
  fields("context", result.context);
  const auto rows = document.find("results");
  if (rows == document.end() || !rows->is_array()) {
    place.key("results").fail(rows == document.end() ? "is missing" : "must be an array");
  }
  result.results = std::move(*rows);
  return result;
}

void require_results_writable(const std::filesystem::path& file) {
  if (!file.empty() && file != results_to_standard_output) {
    require_writable(file);
  }
}

void write_results(const std::filesystem::path& file, std::string_view command, Context context,
                   nlohmann::json results) {
  if (file.empty()) {
    return;
  }
  const nlohmann::ordered_json document{{"schema", schema},
                                        {"command", command},
                                        {"context", to_json_row(std::move(context))},
                                        {"results", std::move(results)}};
  std::string text;
  append_json(text, document, 0);
  write_text(file == results_to_standard_output ? "/dev/stdout" : file, text + "\n");
}

} // namespace hdmbench
