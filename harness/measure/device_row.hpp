#pragma once

#include "backends/backend.hpp"

#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// One line: what there was to choose from, the median of each in milliseconds, and what was chosen.
[[nodiscard]] std::string describe(const Choice& choice);

/// {what, options: [{name, seconds: [raw samples]}], chosen: name, and measured: date where it was kept}.
/// Throws Contradiction where the chosen one is not there, or has no samples.
void list_fields(Fields& fields, Choice& choice);

/// One row of `devices`' results: a device of a backend, or a backend without one.
struct DeviceRow {
  std::string backend;
  std::string description;
  std::vector<std::string> updates{}; ///< of update_names, that the backend supports
  bool available = true;
  std::string device{};
  std::string driver{};
  bool software = false;
  std::string reason{};          ///< why it is not available
  std::vector<Choice> choices{}; ///< made by measurement; none in files of before
};

void list_fields(Fields& fields, DeviceRow& row);

} // namespace hdmbench
