#pragma once

#include "harness/measure/result_file.hpp"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What the result files say, as raw JSON; nothing here knows HTML.
namespace hdmbench::report {

/// A result file. `results` lacks what newer files replaced.
struct Source : ResultFile {
  std::size_t replaced = 0; ///< rows that a newer file has of the same computation on the same machine
};

using Results = std::vector<Source>; ///< oldest first
using Rows = std::vector<const nlohmann::json*>;

/// Reads files, or the *.json files of folders. Of verify, golden, bench, accuracy and tradeoff a newer file
/// replaces the rows of older ones of the same computation on the same machine; of `devices` it replaces the
/// whole file. Throws InputError naming the file that is missing, is not JSON, is of another schema or has a
/// row that is no object.
[[nodiscard]] Results load_results(std::span<const std::filesystem::path> paths);

/// In the order of the newest file, newest first.
[[nodiscard]] std::vector<std::string> machines_of(const Results& results);

/// The rows of one command; `machine` empty: of all machines.
[[nodiscard]] Rows rows_of(const Results& results, std::string_view command, std::string_view machine);

/// Those of which `holds` holds, and how many they are.
[[nodiscard]] Rows rows_where(Rows rows, const std::function<bool(const nlohmann::json&)>& holds);
[[nodiscard]] inline std::int64_t count_where(const Rows& rows,
                                              const std::function<bool(const nlohmann::json&)>& holds) {
  return std::ssize(rows_where(rows, holds));
}

/// A value of a row, or nothing where it is missing or of another type; a path such as "plan.met" goes
/// inside.
[[nodiscard]] std::string text_of(const nlohmann::json& row, std::string_view path);
[[nodiscard]] std::optional<double> number_of(const nlohmann::json& row, std::string_view path);
[[nodiscard]] std::optional<bool> flag_of(const nlohmann::json& row, std::string_view path);

/// "300 x 300", or "64 x 64 x 64" of a volume.
[[nodiscard]] std::string size_of(const nlohmann::json& row);

/// Whether a row of verify or golden says agree, certified, disagree or mistrusted.
[[nodiscard]] bool was_compared(const nlohmann::json& row);
/// That a row of verify says "disagree", or "agree" with what no row may have that agrees.
[[nodiscard]] bool disagrees(const nlohmann::json& row);
/// Whether the field of a row of bench was compared with another backend's, and is the same to the bit.
[[nodiscard]] bool is_checked(const nlohmann::json& row);
/// The distance to what the method of a row approximates, px: finite elements with the Poisson ratio that it
/// has.
[[nodiscard]] std::optional<double> own_error(const nlohmann::json& row);
/// The distance that a request for an accuracy is about, px: for the thesis's energy to its fixed point.
[[nodiscard]] std::optional<double> asked_error(const nlohmann::json& row);

} // namespace hdmbench::report
