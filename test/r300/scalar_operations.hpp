#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

/// A second opinion on a shader's size that knows no graphics card: Khronos's compiler and optimiser.
namespace hdmbench::test {

/// Float operations of a module without loops and calls, a vector's one per component: + - * / and their
/// fusion, negation, absolute value, floor, minimum, comparison, selection (not where it is left as a
/// branch). Throws std::runtime_error where a loop or a call is left.
[[nodiscard]] int count_scalar_operations(std::span<const std::uint32_t> spirv);

/// Those of a GLSL 1.20 fragment shader of ours after glslangValidator and spirv-opt -O, functions inlined,
/// loops unrolled, common subexpressions shared. None where one of the tools is not installed; throws
/// std::runtime_error where one fails.
[[nodiscard]] std::optional<int> scalar_operations(const std::string& fragment_shader);

} // namespace hdmbench::test
