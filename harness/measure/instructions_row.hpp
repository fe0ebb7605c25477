#pragma once

#include <optional>
#include <string>

namespace hdmbench {

class Fields;

/// One row of what `instruction_count` of test/r300/ writes: a fragment shader, compiled for the thesis's
/// card.
struct InstructionsRow {
  std::string group; ///< "candidates", "methods" or "vectors"
  std::string shader;
  int candidates = 0;                ///< step sizes; 0: none
  int energies = 0;                  ///< of "vectors": how many are evaluated per site
  std::optional<int> instructions{}; ///< none: the compiler gave the shader up, for the reason in `refusal`
  std::optional<int> texture_instructions{};
  std::optional<int> temporaries{};
  std::optional<int> flow_control{};
  std::string refusal{};
  std::optional<int> scalar_operations{}; ///< none: not counted
  std::string device;
  std::string driver;
  int instructions_limit = 0;
  int temporaries_limit = 0;
};

void list_fields(Fields& fields, InstructionsRow& row);

} // namespace hdmbench
