#include "harness/check/golden_file.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <golden_text.hpp>

#include <algorithm>
#include <charconv>

namespace hdmbench {

namespace {

constexpr int schema = 1;

std::uint64_t parse_hash(const std::string& text) {
  std::uint64_t hash = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, hash, 16);
  if (text.size() != 16 || result.ec != std::errc{} || result.ptr != end) {
    throw InputError(fmt::format("\"{}\" is no hash of 16 hexadecimal digits", text));
  }
  return hash;
}

GoldenEntry read_entry(const nlohmann::json& json) {
  GoldenEntry entry;
  entry.problem = {.scene = json.at("scene"),
                   .size = Extent{json.at("width"), json.at("height")},
                   .method = json.at("method")};
  entry.inputs.scene = parse_hash(json.at("inputs"));
  for (const nlohmann::json& level : json.at("levels")) {
    entry.levels.push_back({level.at("level"), level.at("iterations"), parse_hash(level.at("hash"))});
    if (level.contains("loaded")) {
      entry.inputs.levels.push_back(parse_hash(level.at("loaded")));
    }
  }
  return entry;
}

std::string hash_text(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

template <typename Value>
nlohmann::json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

std::string entry_text(const GoldenEntry& entry) {
  std::string text = fmt::format(
      "  {{\"scene\": {}, \"width\": {}, \"height\": {}, \"method\": \"{}\", \"inputs\": \"{:016x}\", "
      "\"levels\": [",
      nlohmann::json(entry.problem.scene).dump(), entry.problem.size->width, entry.problem.size->height,
      entry.problem.method, entry.inputs.scene);
  for (std::size_t i = 0; i < entry.levels.size(); ++i) {
    const GoldenLevel& level = entry.levels[i];
    text += fmt::format("{}    {{\"level\": {}, \"iterations\": {}, ", i > 0 ? ",\n" : "\n", level.level,
                        level.iterations);
    if (!entry.inputs.levels.empty()) {
      text += fmt::format("\"loaded\": \"{:016x}\", ", entry.inputs.levels.at(i));
    }
    text += fmt::format("\"hash\": \"{:016x}\"}}", level.hash);
  }
  return text + "]}";
}

} // namespace

std::string golden_text(const std::vector<GoldenEntry>& entries) {
  std::string text = fmt::format("{{\"schema\": {}, \"cases\": [", schema);
  for (const GoldenEntry& entry : entries) {
    text += (&entry == entries.data() ? "\n" : ",\n") + entry_text(entry);
  }
  return text + "]}\n";
}

std::vector<GoldenEntry> read_golden(std::string_view text, std::string_view name) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    if (json.at("schema") != schema) {
      throw InputError(fmt::format("this program reads schema {}", schema));
    }
    std::vector<GoldenEntry> entries;
    for (const nlohmann::json& entry : json.at("cases")) {
      entries.push_back(read_entry(entry));
    }
    return entries;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: {}", name, error.what()));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", name, error.what()));
  }
}

const std::vector<GoldenEntry>& committed_golden() {
  static const std::vector<GoldenEntry> entries = read_golden(sources::golden_text, "golden.json");
  return entries;
}

const GoldenEntry* find_golden(const std::vector<GoldenEntry>& entries, const Case& problem) {
  const auto found = std::ranges::find(entries, problem, &GoldenEntry::problem);
  return found != entries.end() ? &*found : nullptr;
}

nlohmann::json golden_row(const GoldenResult& result, const GoldenOutcome& outcome) {
  nlohmann::json levels = nlohmann::json::array();
  for (const GoldenLevel& level : outcome.levels) {
    levels.push_back(
        {{"level", level.level}, {"iterations", level.iterations}, {"hash", hash_text(level.hash)}});
  }
  const auto in_one_piece =
      outcome.in_one_piece ? std::optional(hash_text(*outcome.in_one_piece)) : std::nullopt;
  return {{"scene", result.problem.scene},
          {"width", result.problem.size->width},
          {"height", result.problem.size->height},
          {"method", result.problem.method},
          {"inputs", hash_text(result.inputs.scene)},
          {"inputs_reason", result.inputs_reason},
          {"backend", outcome.backend},
          {"device", outcome.device.name},
          {"levels", levels},
          {"in_one_piece", or_null(in_one_piece)},
          {"first_difference", or_null(outcome.first_difference)},
          {"verdict", name_of(outcome.verdict)},
          {"reason", outcome.reason}};
}

} // namespace hdmbench
