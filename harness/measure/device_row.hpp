#pragma once

#include "backends/backend.hpp"

#include <string>
#include <vector>

namespace hdmbench {

class Fields;

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
