#pragma once

#include "harness/scene/row_fields.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <string_view>

namespace hdmbench {

/// Where, when and from what a result came about.
struct Context {
  std::string machine; ///< "AMD EPYC, 2 cores"
  std::string cpu;
  unsigned cores = 0;
  std::string architecture;
  std::string operating_system;
  std::string compiler;
  std::string flags;
  std::string commit;
  std::string version;
  std::string date;      ///< UTC, ISO 8601, so that texts sort as times
  std::string arguments; ///< of the command line, without the program's name: "verify square --size 300"
  bool quick = false;
  double load = 0.0; ///< processes that wanted a processor in the minute before; of an idle machine 0
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Context, machine, cpu, cores, architecture, operating_system,
                                                compiler, flags, commit, version, date, arguments, quick,
                                                load)

/// Returns the context of this program here and now.
[[nodiscard]] Context run_context(std::string_view arguments, bool quick);

/// What `--json` writes: {"schema": 1, "command", "context", "results": [rows]}, and "cut": true where the
/// command was ended before it had all rows.
struct ResultFile {
  std::filesystem::path file;
  std::string command; ///< "verify"
  Context context;
  nlohmann::json results; ///< an array
  /// Rows as `probe` has them, which the browser's page writes beside its results; else none.
  nlohmann::json arithmetic = nlohmann::json::array();
  bool cut = false;
};

/// The document as text, with `indent` spaces a step; -1: on one line. Bytes that are not UTF-8, as names of
/// files can have them, are U+FFFD.
template <typename Json>
[[nodiscard]] std::string json_text(const Json& document, int indent = -1) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Throws InputError where the file cannot be read, is not JSON or not a result file.
[[nodiscard]] ResultFile read_results(const std::filesystem::path& file);

/// The name of a result file that means standard output.
inline constexpr std::string_view results_to_standard_output = "-";

/// Before long work: throws InputError unless write_results can write to `file`.
void require_results_writable(const std::filesystem::path& file);

/// Nothing where `file` is empty: nobody asked for results; nor of `cut` ones where a file is not replaced.
/// The text is json_text(), with a line on standard error where that replaced something. Throws InputError.
void write_results(const std::filesystem::path& file, std::string_view command, const Context& context,
                   nlohmann::json results, bool cut = false);

} // namespace hdmbench
