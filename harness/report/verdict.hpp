#pragma once

#include "harness/report/results.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench::report {

enum class State {
  good,   ///< all that ran holds
  unsure, ///< something was skipped, failed, cannot be trusted or does not reach what was asked
  bad,    ///< at least one result is wrong
};
/// The names that page.css has for them.
NLOHMANN_JSON_SERIALIZE_ENUM(State, {{State::good, "good"}, {State::unsure, "unsure"}, {State::bad, "bad"}})

/// A sentence about the rows of one command.
struct Finding {
  State state = State::good;
  std::string sentence;
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Finding, state, sentence)

/// One of the numbers below the verdict: "366 x", "as fast as ...".
struct Figure {
  State state = State::good;
  std::string value;
  std::string text;
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Figure, state, value, text)

/// What the results of a machine come to, in plain text.
struct Verdict {
  State state = State::unsure;
  std::string sentence;        ///< the worst that was found
  std::vector<Finding> notes;  ///< all else, the worst first
  std::vector<Figure> figures; ///< as figures_of
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Verdict, state, sentence, notes, figures)

/// Comparisons that agree, the fastest and the nearest to finite elements, as far as they were measured.
[[nodiscard]] std::vector<Figure> figures_of(const Results& results, std::string_view machine);

/// A row that contradicts itself ("agree" although sites differ) counts as wrong, one without a verdict as
/// not compared. `machine` empty: all machines together.
[[nodiscard]] Verdict verdict_of(const Results& results, std::string_view machine);

} // namespace hdmbench::report
