#pragma once

#include "harness/report/results.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hdmbench::report {

/// What the rows of one command come to. Texts are plain, not HTML.
struct Summary {
  enum class State {
    good,   ///< everything that ran holds
    unsure, ///< nothing ran, or something failed or cannot be trusted
    bad,    ///< at least one result is wrong
  };
  State state = State::unsure;
  std::string sentence;
  std::vector<std::string> notes; ///< what the sentence leaves open: skipped, mistrusted, never compared
};

/// Of the verify rows. `machine` empty: all machines together.
[[nodiscard]] Summary summarise(const Results& results, const std::string& machine = {});

/// Of the golden rows, none where there are none: bad where a hash differs, unsure where there was nothing
/// golden to compare with.
[[nodiscard]] std::optional<Summary> summarise_golden(const Results& results,
                                                      const std::string& machine = {});

/// Of the accuracy rows, none where there are none: what failed, else the distances of ICM to FEM. Bad where
/// float32 leaves the derived bound or a field is not valid; unsure where a row has no result or float32 was
/// not compared.
[[nodiscard]] std::optional<Summary> summarise_accuracy(const Results& results,
                                                        const std::string& machine = {});

} // namespace hdmbench::report
