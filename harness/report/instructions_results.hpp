#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

/// What `instruction_count` of test/r300/ wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

/// One fragment shader, compiled for the thesis's card.
struct InstructionsRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string group;       ///< "candidates", "methods" or "vectors"
  std::string shader;
  std::int64_t candidates = 0; ///< step sizes; 0: none
  std::int64_t energies = 0;   ///< of "vectors": how many are evaluated per site
  /// None: the compiler gave the shader up, for the reason in `refusal`.
  std::optional<std::int64_t> instructions;
  std::optional<std::int64_t> texture_instructions;
  std::optional<std::int64_t> temporaries;
  std::string refusal;
  std::optional<std::int64_t> scalar_operations; ///< none: not counted
  std::string device;
  std::string driver;
  std::int64_t instructions_limit = 0;
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself: a shader that both fits and is refused, or neither, or fits beyond the limit.
[[nodiscard]] InstructionsRow read_instructions(const JsonReader& json);

} // namespace hdmbench::report
