#include "harness/report/instructions_results.hpp"

#include "harness/report/json_reader.hpp"

#include <fmt/format.h>

namespace hdmbench::report {

namespace {

std::optional<std::int64_t> count_or_null(const JsonReader& json, const std::string& key) {
  return json.holds(key) ? std::optional(json.count(key)) : std::nullopt;
}

} // namespace

InstructionsRow read_instructions(const JsonReader& json) {
  InstructionsRow row;
  row.group = json.text("group", {"candidates", "methods", "vectors"});
  row.shader = json.text("shader");
  row.candidates = json.count("candidates");
  row.energies = json.count("energies");
  row.instructions = count_or_null(json, "instructions");
  row.texture_instructions = count_or_null(json, "texture_instructions");
  row.temporaries = count_or_null(json, "temporaries");
  row.refusal = json.text("refusal");
  row.scalar_operations = count_or_null(json, "scalar_operations");
  row.device = json.text("device");
  row.driver = json.text("driver");
  row.instructions_limit = json.count("instructions_limit");
  if (row.instructions.has_value() != row.refusal.empty()) {
    json.fail("refusal", "must say why where there are no instructions, and only there");
  }
  if (row.instructions && *row.instructions > row.instructions_limit) {
    json.fail("instructions",
              fmt::format("are {} although the limit is {}", *row.instructions, row.instructions_limit));
  }
  return row;
}

} // namespace hdmbench::report
