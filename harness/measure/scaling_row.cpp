#include "harness/measure/scaling_row.hpp"

#include "harness/scene/row_fields.hpp"
#include "harness/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace hdmbench {

void list_fields(Fields& fields, ScalingRow& row) {
  static constexpr std::array<std::string_view, 2> kinds{"strong", "weak"};
  fields("scene", row.scene);
  fields.newer("energy", OneOf{row.energy, energy_names});
  fields("scaling", OneOf{row.scaling, kinds});
  fields("backend", row.backend);
  fields("ranks", row.ranks);
  fields("width", row.width);
  fields("height", row.height);
  fields("seconds", row.seconds);
  fields("modelled_seconds", row.modelled_seconds);
  fields("messages", row.messages);
  fields("bytes", row.bytes);
  fields.newer("message_seconds", row.message_seconds);
}

void require_consistent(const ScalingRow& row) {
  refuse_if(row.seconds.empty() && !row.modelled_seconds, "modelled_seconds",
            "of a row without \"seconds\" must be a number");
}

double model_error(const ScalingRow& row) {
  return row.modelled_seconds.value() / std::ranges::min(row.seconds) - 1.0;
}

std::string model_error_text(const ScalingRow& row) {
  return row.modelled_seconds ? fmt::format("{:+.0f} %", 100.0 * model_error(row)) : "-";
}

WorthRanks worth_ranks(const std::vector<ScalingRow>& modelled) {
  constexpr double nine_tenths = 0.9;
  for (std::size_t i = 1; i < modelled.size(); ++i) {
    if (modelled[i].modelled_seconds.value() > nine_tenths * modelled[i - 1].modelled_seconds.value()) {
      return {.ranks = modelled[i - 1].ranks};
    }
  }
  return {.ranks = modelled.back().ranks, .ends = false};
}

} // namespace hdmbench
