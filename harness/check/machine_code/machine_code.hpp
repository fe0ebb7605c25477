#pragma once

#include "harness/check/machine_code/compilers.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

/// What the compilers of GPUs make of every program that the backends would compile there, read from its
/// machine code, on a machine without a GPU. Where no multiplication is fused with a sum the bits are the
/// specification's, as far as arithmetic goes.
namespace hdmbench {

struct MachineCodeOptions {
  std::vector<std::string> targets{}; ///< names; empty: all
  std::vector<std::string> kernels{}; ///< words, one of which "elastic.cl relax load 3 axes" has; empty: all
  Word word = Word::kept;
};

/// A row for each program and target: "kernel", "text", "axes", "target", "gpu", "compiler"; "multiplies",
/// "adds", "fused" and "fused_lines" as Operations; "instructions"; "registers" of an invocation of
/// "registers_of", "spills" of them, "local_bytes" of an invocation, "shared_bytes" of a work group,
/// "occupancy" (groups of lanes in a processor's queue), "denormals", each null or absent where the compiler
/// does not say it; "verdict" and "reason". Of a compiler that is not there one row, of kernel "all". The
/// verdict is "no fused operation", "fused", "refused" (by the compiler) or "not there". Throws InputError
/// for an unknown target, or where no program is left.
[[nodiscard]] nlohmann::json machine_code(const MachineCodeOptions& options, Progress& progress);

} // namespace hdmbench
