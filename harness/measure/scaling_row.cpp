#include "harness/measure/scaling_row.hpp"

#include "harness/scene/row_fields.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace hdmbench {

void list_fields(Fields& fields, ScalingRow& row) {
  static constexpr std::array<std::string_view, 2> kinds{"strong", "weak"};
  fields("scene", row.scene);
  fields("scaling", OneOf{row.scaling, kinds});
  fields("backend", row.backend);
  fields("ranks", row.ranks);
  fields("width", row.width);
  fields("height", row.height);
  fields("seconds", row.seconds);
  fields("modelled_seconds", row.modelled_seconds);
  fields("messages", row.messages);
  fields("bytes", row.bytes);
}

double model_error(const ScalingRow& row) {
  return row.modelled_seconds / std::ranges::min(row.seconds) - 1.0;
}

WorthRanks worth_ranks(const std::vector<ScalingRow>& modelled) {
  constexpr double nine_tenths = 0.9;
  for (std::size_t i = 1; i < modelled.size(); ++i) {
    if (modelled[i].modelled_seconds > nine_tenths * modelled[i - 1].modelled_seconds) {
      return {.ranks = modelled[i - 1].ranks};
    }
  }
  return {.ranks = modelled.back().ranks, .ends = false};
}

} // namespace hdmbench
