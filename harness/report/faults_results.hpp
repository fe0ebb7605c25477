#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// What `hdmbench faults` wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

/// What the cross-check said of one fault on one scene.
struct FaultOnScene {
  std::string scene; ///< with the method where it is not icm: "random, coloured"
  std::int64_t width = 0;
  std::int64_t height = 0;
  bool exact = false;
  std::string verdict; ///< of verify, or "error"
  std::int64_t sites_differing = 0;
  std::int64_t uncertified = 0;
  std::string reason; ///< of skipped, mistrusted and error
};

/// One planted fault, or a control.
struct FaultRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string fault;
  std::string what;
  std::string backend;
  std::string layer;    ///< session, shader or driver
  std::string expected; ///< disagree, let through or either
  bool caught = false;
  bool as_expected = false;
  std::string not_planted; ///< why not; empty: it was
  std::vector<FaultOnScene> scenes;

  /// Something was compared.
  [[nodiscard]] bool ran() const;
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself: caught although no scene says so, or as expected although it was not planted.
[[nodiscard]] FaultRow read_fault(const JsonReader& json);

} // namespace hdmbench::report
