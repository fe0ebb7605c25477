#include "harness/check/golden_row.hpp"

#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace hdmbench {

static void list_fields(Fields& fields, GoldenRow::Level& level) {
  fields("level", level.level);
  fields("iterations", level.iterations);
  fields("hash", level.hash);
}

void list_fields(Fields& fields, GoldenRow& row) {
  fields("scene", row.scene);
  fields("width", row.width);
  fields("height", row.height);
  fields("method", row.method);
  fields("inputs", row.inputs);
  fields("inputs_reason", row.inputs_reason);
  fields("backend", row.backend);
  fields("device", row.device);
  fields("levels", row.levels);
  fields("in_one_piece", row.in_one_piece);
  fields("first_difference", row.first_difference);
  fields("verdict", row.verdict);
  fields("reason", row.reason);
}

GoldenRow golden_row(const GoldenResult& result, const GoldenOutcome& outcome) {
  const auto text = [](std::uint64_t hash) { return fmt::format("{:016x}", hash); };
  GoldenRow row{.scene = result.problem.scene,
                .width = result.problem.extent.width,
                .height = result.problem.extent.height,
                .method = result.problem.method,
                .inputs = text(result.inputs.scene),
                .inputs_reason = result.inputs_reason,
                .backend = outcome.backend,
                .device = outcome.device.name,
                .first_difference = outcome.first_difference,
                .verdict = outcome.verdict,
                .reason = outcome.reason};
  std::ranges::transform(outcome.levels, std::back_inserter(row.levels), [&](const GoldenLevel& level) {
    return GoldenRow::Level{level.level, level.iterations, text(level.hash)};
  });
  if (outcome.in_one_piece) {
    row.in_one_piece = text(*outcome.in_one_piece);
  }
  return row;
}

} // namespace hdmbench
