#pragma once

#include "harness/scene/row_fields.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// One reason not to trust a result, found before or after the run.
struct Warning {
  std::string kind;                   ///< a word that stays the same: "fold-over"
  std::string message;                ///< what is seen, with its numbers
  std::string advice;                 ///< what to do about it, by options of this program where there are any
  std::optional<std::size_t> sites{}; ///< how many sites (fold-over: cells between sites) show it
};

using Warnings = std::vector<Warning>;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Warning, kind, message, advice, sites)

/// A block for people, lines of at most 110 characters that end in a newline; one line where nothing was
/// found.
[[nodiscard]] std::string warnings_text(std::span<const Warning> warnings);

} // namespace hdmbench
