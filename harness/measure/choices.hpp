#pragma once

#include "backends/backend.hpp"

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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

/// Where choices are kept: $XDG_CACHE_HOME/hdmbench/choices.json, else ~/.cache/hdmbench/choices.json; empty
/// where there is neither.
[[nodiscard]] std::filesystem::path choice_cache_file();

/// Choices in a file, by backend, device, driver, version and commit of this program, and what is computed.
/// The file is read when first asked and replaced as a whole. What is wrong with it costs a note on standard
/// error and nothing else: then everything is measured anew.
class ChoiceCache final : public ChoiceStore {
public:
  explicit ChoiceCache(std::filesystem::path file) : file_(std::move(file)) {}

  [[nodiscard]] std::optional<Choice> find(std::string_view backend, const Device& device,
                                           std::string_view what) override;
  void keep(std::string_view backend, const Device& device, const Choice& choice) override;

private:
  using Key = std::array<std::string, 6>;
  [[nodiscard]] static Key key_of(std::string_view backend, const Device& device, std::string_view what);
  [[nodiscard]] std::map<Key, Choice> read() const;

  std::filesystem::path file_;
  std::optional<std::map<Key, Choice>> choices_; ///< as last read or written
};

} // namespace hdmbench
