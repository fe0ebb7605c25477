#pragma once

#include "harness/check/faults/planted.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// What the cross-check said of one fault on one scene.
struct FaultOnScene {
  std::string scene; ///< TrialScene::label
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string method{}; ///< empty in files of before
  bool exact = false;
  std::string verdict; ///< of verify, or "error"
  std::int64_t sites_differing = 0;
  std::int64_t uncertified = 0;
  std::int64_t counts_differing = 0;
  std::string reason{}; ///< of skipped, mistrusted and error
};

/// One row of `faults`' results: a planted fault, or a control.
struct FaultRow {
  std::string fault;
  std::string what;
  std::string backend;
  std::string device{};
  faults::Layer layer = faults::Layer::session;
  faults::Expected expected = faults::Expected::disagree;
  bool caught = false;
  bool as_expected = false;
  std::string not_planted{}; ///< why not; empty: it was
  std::vector<FaultOnScene> scenes{};

  /// Something was compared.
  [[nodiscard]] bool ran() const;
};

void list_fields(Fields& fields, FaultRow& row);

} // namespace hdmbench
