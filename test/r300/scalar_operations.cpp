#include "test/r300/scalar_operations.hpp"

#include "harness/scene/temporary_directory.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace hdmbench::test {

namespace {

/// SPIR-V: a header of five words, then instructions whose first word is length << 16 | opcode.
constexpr std::size_t header = 5;
constexpr std::uint32_t op_ext_inst = 12;
constexpr std::uint32_t op_type_vector = 23;
constexpr std::uint32_t op_function_call = 57;
constexpr std::uint32_t op_loop_merge = 246;

std::uint32_t opcode_of(std::uint32_t word) {
  return word & 0xffffU;
}

/// Of float results, and of what is made of float comparisons: OpFNegate, OpFAdd, OpFSub, OpFMul, OpFDiv,
/// OpVectorTimesScalar, OpSelect, OpFOrdEqual to OpFUnordGreaterThanEqual.
bool is_componentwise(std::uint32_t opcode) {
  return opcode == 127 || opcode == 129 || opcode == 131 || opcode == 133 || opcode == 136 || opcode == 142 ||
         opcode == 169 || (opcode >= 180 && opcode <= 191);
}

constexpr std::uint32_t op_dot = 148;

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

/// SPIR-V needs newer GLSL, and a location for the output.
std::string modern(std::string text) {
  replace_all(text, "#extension GL_ARB_texture_rectangle : require", "");
  replace_all(text, "#version 120", "#version 450\nlayout(location = 0) out vec4 fragment_colour;");
  replace_all(text, "texture2DRect", "texture");
  replace_all(text, "gl_FragColor", "fragment_colour");
  return text;
}

std::vector<std::uint32_t> read_words(const std::string& file) {
  std::vector<std::uint32_t> words(std::filesystem::file_size(file) / sizeof(std::uint32_t));
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(words.data()),
            static_cast<std::streamsize>(words.size() * sizeof(std::uint32_t)));
  return words;
}

void write_words(const std::string& file, const std::vector<std::uint32_t>& words) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(words.data()),
             static_cast<std::streamsize>(words.size() * sizeof(std::uint32_t)));
}

/// spirv-opt unrolls the loops that ask for it, which GLSL has no word for.
void ask_for_unrolling(std::vector<std::uint32_t>& words) {
  for (std::size_t at = header; at < words.size(); at += words[at] >> 16) {
    if (opcode_of(words[at]) == op_loop_merge) {
      words[at + 3] |= 1U;
    }
  }
}

void run(const std::string& command) {
  if (std::system(command.c_str()) != 0) {
    throw std::runtime_error("failed: " + command);
  }
}

} // namespace

int count_scalar_operations(std::span<const std::uint32_t> spirv) {
  std::map<std::uint32_t, int> components; // by the type's or the value's id; 1 where there is none
  std::map<std::uint32_t, std::uint32_t> types;
  const auto size = [&](std::uint32_t type) {
    const auto found = components.find(type);
    return found == components.end() ? 1 : found->second;
  };
  int operations = 0;
  for (std::size_t at = header; at < spirv.size(); at += spirv[at] >> 16) {
    const std::uint32_t opcode = opcode_of(spirv[at]);
    if (opcode == op_loop_merge || opcode == op_function_call) {
      throw std::runtime_error("a loop or a call is left in the module: its operations cannot be counted");
    }
    if (opcode == op_type_vector) {
      components[spirv[at + 1]] = static_cast<int>(spirv[at + 3]);
    } else if (is_componentwise(opcode) || opcode == op_ext_inst) {
      operations += size(spirv[at + 1]);
    } else if (opcode == op_dot) {
      const auto operand = types.find(spirv[at + 3]);
      operations += 2 * (operand == types.end() ? 1 : size(operand->second)) - 1;
    }
    if (spirv[at] >> 16 >= 3) {
      types[spirv[at + 2]] = spirv[at + 1]; // type and result of whatever has both
    }
  }
  return operations;
}

std::optional<int> scalar_operations(const std::string& fragment_shader) {
  if (std::system("command -v glslangValidator >/dev/null && command -v spirv-opt >/dev/null") != 0) {
    return std::nullopt;
  }
  const TemporaryDirectory folder;
  const auto file = [&](const char* name) { return (folder.path() / name).string(); };
  std::ofstream(file("shader.frag")) << modern(fragment_shader);
  run(fmt::format("glslangValidator --quiet -G --auto-map-locations --auto-map-bindings -o '{}' '{}'",
                  file("shader.spv"), file("shader.frag")));
  std::vector<std::uint32_t> words = read_words(file("shader.spv"));
  ask_for_unrolling(words);
  write_words(file("loops.spv"), words);
  run(fmt::format(
      "spirv-opt --merge-return --inline-entry-points-exhaustive --eliminate-dead-functions "
      "--scalar-replacement=100 --ssa-rewrite --ccp --eliminate-dead-branches --loop-unroll -O '{}' -o '{}'",
      file("loops.spv"), file("optimised.spv")));
  return count_scalar_operations(read_words(file("optimised.spv")));
}

} // namespace hdmbench::test
