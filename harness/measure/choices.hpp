#pragma once

#include "backends/backend.hpp"

#include <string>

namespace hdmbench {

class Fields;

/// One line: what there was to choose from, the median of each in milliseconds, and what was chosen.
[[nodiscard]] std::string describe(const Choice& choice);

/// {what, options: [{name, seconds: [raw samples]}], chosen: name, and measured: date where it was kept}.
/// Throws Contradiction where the chosen one is not there, or has no samples.
void list_fields(Fields& fields, Choice& choice);

} // namespace hdmbench
