#pragma once

#include "test/r300/shader_compiler.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace hdmbench::test {

/// One shader and what the card's compiler makes of it.
struct InstructionRow {
  std::string group;
  std::string shader; ///< what tells it apart within the group
  int candidates = 0; ///< step sizes per component; 0: the rule has none
  int energies = 0;   ///< candidate vectors whose energy is evaluated, of "vectors"; else 0
  Compilation compilation{};
};

/// "candidates": what gl-fragment sends for icm with 2 to 16 candidates, the largest number that a StepSet
/// takes. "methods": for every method that it supports, the count of changed sites, the passes of the elastic
/// energy, and annealing, the longest of them, also with the most candidates that fit and the first number
/// that does not. "vectors": thesis_shader() for 2 to 6 step sizes, and one vector more than 4 x 4.
[[nodiscard]] std::vector<InstructionRow> measure_instructions(ShaderCompiler& compiler);

/// The thesis's shader as it may have been: a site's whole energy for every candidate VECTOR (its Algorithms
/// 1 to 4 have Gamma as a set of vectors), (4.7)-(4.17) line by line, unrolled because fragment programs of
/// its time had no loops. Its source is not printed; this is ours, in GLSL 1.20. The first `vectors` of
/// `steps` x `steps` vectors; -1: all.
[[nodiscard]] std::string thesis_shader(int steps, int vectors = -1);

/// The row of results, with the card and its limits; what the compiler did not tell is null.
[[nodiscard]] nlohmann::json to_json(const InstructionRow& row, const ShaderCompiler& compiler);

} // namespace hdmbench::test
