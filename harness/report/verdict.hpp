#pragma once

#include "harness/report/results.hpp"

#include <string>
#include <vector>

namespace hdmbench::report {

/// What the verify rows come to. Texts are plain, not HTML.
struct Summary {
  enum class State {
    good,   ///< every comparison that ran agrees, or is certified
    unsure, ///< nothing ran, or something cannot be trusted
    bad,    ///< at least one disagrees
  };
  State state = State::unsure;
  std::string sentence;
  std::vector<std::string> notes; ///< what the sentence leaves open: skipped, mistrusted, never compared
};

/// `machine` empty: all machines together.
[[nodiscard]] Summary summarise(const Results& results, const std::string& machine = {});

} // namespace hdmbench::report
