#pragma once

#include "harness/solve/progress.hpp"
#include "test/r300/shader_compiler.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace hdmbench::test {

/// One shader and what the card's compiler makes of it.
struct InstructionRow {
  /// "candidates": what gl-fragment sends for icm, by the number of candidates; "methods": what it sends for
  /// every method; "vectors": the thesis's evaluation, see vector_candidates.hpp.
  std::string group;
  std::string shader;   ///< what tells it apart within the group
  int candidates = 0;   ///< step sizes per component; 0: the rule has none
  int energies = 0;     ///< candidate vectors whose energy is evaluated, of "vectors"; else 0
  std::string source{}; ///< GLSL 1.20
  Compilation compilation{};
  std::optional<int> scalar_operations{}; ///< none: not asked, or the tools are not installed
};

/// icm with 2 to 16 candidates, the largest number that a StepSet takes.
[[nodiscard]] std::vector<InstructionRow> measure_candidates(ShaderCompiler& compiler);
/// The methods that gl-fragment supports, the count of changed sites, the passes of the elastic energy;
/// annealing, the longest of them, also with the most candidates that fit and with the first number that does
/// not.
[[nodiscard]] std::vector<InstructionRow> measure_methods(ShaderCompiler& compiler);
/// Vectors of 2 to 6 step sizes, written in several ways.
[[nodiscard]] std::vector<InstructionRow> measure_vectors(ShaderCompiler& compiler);

/// Asks glslangValidator and spirv-opt (scalar_operations.hpp).
void add_second_opinions(std::vector<InstructionRow>& rows, Progress& progress);

/// The row of results, with the card and its limits; what the compiler did not tell is null.
[[nodiscard]] nlohmann::json to_json(const InstructionRow& row, const ShaderCompiler& compiler);

} // namespace hdmbench::test
