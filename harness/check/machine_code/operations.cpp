#include "harness/check/machine_code/operations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <initializer_list>

namespace hdmbench {

namespace {

enum class Meaning { none, other, multiply, add, multiply_and_add, fused };

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

std::string_view trimmed(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  const std::size_t last = line.find_last_not_of(" \t\r");
  return first == std::string_view::npos ? std::string_view() : line.substr(first, last - first + 1);
}

std::string_view first_word(std::string_view line) {
  return line.substr(0, line.find_first_of(" \t;"));
}

/// "v_dual_fmac_f32"
Meaning amd_operation(std::string_view name) {
  if (!is_one_of(name.substr(0, name.find('_')),
                 {"v", "s", "ds", "buffer", "global", "flat", "scratch", "image", "exp"})) {
    return Meaning::none;
  }
  if (name.starts_with("v_dot") || name.starts_with("v_fma_mix") || name.starts_with("v_mad_mix")) {
    return Meaning::fused;
  }
  const std::size_t type = name.find("_f32");
  if (!name.starts_with("v_") || type == std::string_view::npos || type < 2) {
    return Meaning::other;
  }
  std::string_view core = name.substr(2, type - 2);
  for (const std::string_view prefix : {"dual_", "pk_"}) {
    core.remove_prefix(core.starts_with(prefix) ? prefix.size() : 0);
  }
  core = core.substr(0, core.find("_legacy"));
  return core == "mul"                                        ? Meaning::multiply
         : is_one_of(core, {"add", "sub", "subrev"})          ? Meaning::add
         : is_one_of(core, {"mad", "mac", "madak", "madmk"})  ? Meaning::multiply_and_add
         : is_one_of(core, {"fma", "fmac", "fmaak", "fmamk"}) ? Meaning::fused
                                                              : Meaning::other;
}

/// "mul.rn.f32". Without a rounding of its own ptxas may fuse an operation (PTX ISA: mul, add).
Meaning ptx_operation(std::string_view name) {
  const std::string_view core = name.substr(0, name.find('.'));
  if (!name.ends_with(".f32") || !is_one_of(core, {"mul", "add", "sub", "fma", "mad"})) {
    return Meaning::other;
  }
  const bool is_rounded = name.find(".rn") != std::string_view::npos;
  return !is_rounded || core == "fma" || core == "mad" ? Meaning::fused
         : core == "mul"                               ? Meaning::multiply
                                                       : Meaning::add;
}

/// "FMUL.FTZ"
Meaning sass_operation(std::string_view name) {
  const std::string_view core = name.substr(0, name.find('.'));
  return is_one_of(core, {"FMUL", "FMUL32I"})   ? Meaning::multiply
         : is_one_of(core, {"FADD", "FADD32I"}) ? Meaning::add
         : core.starts_with("FFMA")             ? Meaning::fused
                                                : Meaning::other;
}

/// "mul (8|M0) r2.0<1>:f r12.3<0;1,0>:f ...", without what comes before the name.
Meaning intel_operation(std::string_view line) {
  const std::string_view name = first_word(line);
  const bool is_float = line.find(":f ") != std::string_view::npos;
  return !is_float                                                       ? Meaning::other
         : name == "mul"                                                 ? Meaning::multiply
         : name == "add"                                                 ? Meaning::add
         : is_one_of(name, {"mad", "mac", "madm", "lrp", "pln", "line"}) ? Meaning::fused
                                                                         : Meaning::other;
}

/// That of a line; `line` is trimmed, and not empty.
Meaning operation_of(InstructionSet set, std::string_view line) {
  switch (set) {
  case InstructionSet::amd:
    return amd_operation(first_word(line));
  case InstructionSet::ptx:
    if (line.starts_with('@')) {
      line = trimmed(line.substr(std::min(line.find_first_of(" \t"), line.size())));
    }
    return !line.ends_with(';') || line.starts_with('.') ? Meaning::none : ptx_operation(first_word(line));
  case InstructionSet::sass: {
    const std::size_t address_end = line.find("*/");
    if (!line.starts_with("/*0") || address_end == std::string_view::npos || line.size() < address_end + 3) {
      return Meaning::none;
    }
    line = trimmed(line.substr(address_end + 2));
    return sass_operation(first_word(
        line.starts_with('@') ? trimmed(line.substr(std::min(line.find(' '), line.size()))) : line));
  }
  case InstructionSet::intel: {
    const bool is_predicated = line.starts_with('(');
    line = is_predicated ? trimmed(line.substr(std::min(line.find(')') + 1, line.size()))) : line;
    const std::string_view size = trimmed(line.substr(std::min(line.find(' '), line.size())));
    return size.starts_with('(') && size.find("|M") < size.find(')') ? intel_operation(line) : Meaning::none;
  }
  }
  return Meaning::none;
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// The line of the text that what follows comes from: ".loc FILE LINE COLUMN"; 0 where this is none.
std::size_t line_named(std::string_view line) {
  constexpr std::string_view mark = ".loc";
  if (!line.starts_with(mark)) {
    return 0;
  }
  line = trimmed(line.substr(mark.size()));
  line = trimmed(line.substr(std::min(line.find(' '), line.size())));
  std::size_t number = 0;
  std::from_chars(line.data(), line.data() + line.size(), number);
  return number;
}

} // namespace

Operations count_operations(InstructionSet set, std::string_view assembly, std::string_view source) {
  const std::vector<std::string_view> text = lines_of(source);
  Operations found;
  std::size_t from = 0; // line of the text, counted from 1
  const auto add = [&](std::string_view instruction) {
    const Meaning operation = operation_of(set, instruction);
    found.instructions += operation == Meaning::none ? 0 : 1;
    const bool is_both = operation == Meaning::multiply_and_add;
    found.multiplies += is_both || operation == Meaning::multiply ? 1 : 0;
    found.adds += is_both || operation == Meaning::add ? 1 : 0;
    if (operation == Meaning::fused) {
      found.fused.push_back(
          from > 0 && from <= text.size()
              ? fmt::format("line {}: {} ({})", from, trimmed(text[from - 1]), first_word(instruction))
              : std::string(instruction));
    }
  };
  for (std::string_view line : lines_of(assembly)) {
    line = trimmed(line);
    const std::size_t named = line_named(line);
    from = named > 0 ? named : from;
    if (line.empty() || named > 0) {
      continue;
    }
    constexpr std::string_view pair = " :: "; // two operations in one instruction of RDNA 3
    const std::size_t second = set == InstructionSet::amd ? line.find(pair) : std::string_view::npos;
    add(line.substr(0, second));
    if (second != std::string_view::npos) {
      --found.instructions;
      add(line.substr(second + pair.size()));
    }
  }
  return found;
}

} // namespace hdmbench
