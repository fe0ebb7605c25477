#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What is written in assembly.
enum class InstructionSet {
  amd,   ///< GCN and RDNA, as LLVM writes it
  ptx,   ///< NVIDIA's, before its assembler
  sass,  ///< NVIDIA's own
  intel, ///< Gen, as IGC writes it
};

/// The arithmetic of a program on floats of 32 bits. A multiply-add that rounds its product, as v_mac_f32 of
/// AMD's GCN does, is a multiplication and an addition.
struct Operations {
  int instructions = 0; ///< of any kind
  int multiplies = 0;
  int adds = 0;
  /// Instructions that round a product and a sum once, and in PTX those that its assembler may make one of.
  /// Each with its line of the text that was compiled where the assembly tells, else as it is.
  std::vector<std::string> fused;
};

/// `source`: the text that was compiled, whose lines the assembly may name (.loc).
[[nodiscard]] Operations count_operations(InstructionSet set, std::string_view assembly,
                                          std::string_view source = {});

} // namespace hdmbench
