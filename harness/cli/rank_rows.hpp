#pragma once

#include "harness/ranks/message_passing.hpp"
#include "harness/scene/row_fields.hpp"

#include <string>
#include <vector>

namespace hdmbench::commands {

/// Of all ranks, by rank, on the first one; nothing on the others. Collective.
template <typename Row>
[[nodiscard]] std::vector<Row> gather_rows(const std::vector<Row>& own, Ranks& ranks) {
  nlohmann::json list = nlohmann::json::array();
  for (const Row& row : own) {
    list.push_back(row);
  }
  std::vector<Row> rows;
  for (const std::string& text : ranks.gather(list.dump())) {
    for (const nlohmann::json& row : nlohmann::json::parse(text)) {
      rows.push_back(row.get<Row>());
    }
  }
  return rows;
}

/// The network's name of this machine; empty where it has none.
[[nodiscard]] std::string machine_name();

} // namespace hdmbench::commands
