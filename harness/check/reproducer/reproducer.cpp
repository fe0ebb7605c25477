#include "harness/check/reproducer/reproducer.hpp"

#include "backends/device/recording.hpp"
#include "harness/scene/files.hpp"

#include <cuda_text.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gl_text.hpp>
#include <nlohmann/json.hpp>
#include <opencl_text.hpp>
#include <replay_text.hpp>
#include <vulkan_text.hpp>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// The program that does a step again whose texts have this ending.
std::string_view program_for(std::string_view ending) {
  static const std::map<std::string_view, std::string_view> all{{"comp", sources::gl_text},
                                                                {"spv", sources::vulkan_text},
                                                                {"cl", sources::opencl_text},
                                                                {"cu", sources::cuda_text}};
  return all.at(ending);
}

/// The command that builds it and runs it: the lines of its first comment that are indented.
std::string build_line(std::string_view program) {
  constexpr std::string_view indented = "//   ";
  std::string lines;
  while (program.starts_with("//")) {
    const std::string_view line = program.substr(0, program.find('\n') + 1);
    lines += line.starts_with(indented) ? fmt::format("  {}", line.substr(indented.size())) : "";
    program.remove_prefix(line.size());
  }
  return lines;
}

std::string_view as_text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string literal(std::string_view text) {
  return nlohmann::json(text).dump();
}

/// A command as step.inc has it. `number`: of the command.
std::string command_text(const RecordedStep& step, const RecordedStep::Told& told, std::size_t number) {
  if (!told.program) {
    return fmt::format(R"({{-1, {{{{0, {}}}}}, {{}}, {{}}, 0, 0, {{0, 0, 0}}, true, "written{}.bin", {}}})",
                       told.arrays.front().second, number, told.first);
  }
  const ProgramText& program = step.programs[*told.program];
  std::vector<std::string> bound;
  const auto bind = [&](std::size_t binding) {
    const auto at = std::ranges::find(told.arrays, binding, &std::pair<std::size_t, std::size_t>::first);
    if (at != told.arrays.end() || !program.arguments.empty()) {
      bound.push_back(
          fmt::format("{{{}, {}}}", binding, at == told.arrays.end() ? -1 : static_cast<int>(at->second)));
    }
  };
  if (program.arguments.empty()) {
    std::ranges::for_each(told.arrays, [&](const auto& one) { bind(one.first); });
  } else {
    std::ranges::for_each(program.arguments, bind);
  }
  const Dispatch& dispatch = told.dispatch;
  const auto words = std::span(dispatch.words).first(dispatch.word_count);
  const auto steps = std::span(dispatch.steps).first(dispatch.step_count > 0 ? dispatch.steps.size() : 0);
  std::vector<std::string> floats;
  std::ranges::transform(steps, std::back_inserter(floats),
                         [](float one) { return fmt::format("{:a}F", one); });
  const std::size_t bytes = std::max((words.size() + steps.size()) * sizeof(float), program.told_bytes);
  return fmt::format("{{{}, {{{}}}, {{{}}}, {{{}}}, {}, {}, {{{}, {}, {}}}, {}, nullptr, 0}}", *told.program,
                     fmt::join(bound, ", "), fmt::join(words, ", "), fmt::join(floats, ", "),
                     dispatch.step_count, bytes, dispatch.groups.width, dispatch.groups.height,
                     dispatch.groups.depth, !dispatch.beside);
}

std::string step_text(const RecordedStep& step) {
  std::string text = fmt::format("const std::string device_name = {};\n\nconst std::vector<Array> arrays{{\n",
                                 literal(step.device.name));
  constexpr std::array<std::string_view, 3> kinds{"pairs", "fours", "words"};
  for (std::size_t i = 0; i < step.arrays.size(); ++i) {
    text += fmt::format("    {{{}, \"array{}.bin\"}},\n",
                        kinds.at(static_cast<std::size_t>(step.arrays[i].kind)), i);
  }
  text += "};\n\nconst std::vector<Program> programs{\n";
  for (std::size_t i = 0; i < step.programs.size(); ++i) {
    const ProgramText& program = step.programs[i];
    std::vector<std::string> options;
    std::ranges::transform(program.options, std::back_inserter(options), literal);
    text += fmt::format("    {{\"program{}.{}\", \"{}\", {{{}}}, {}}},\n", i, program.ending, program.entry,
                        fmt::join(options, ", "), program.lanes);
  }
  text += "};\n\nconst std::vector<Command> commands{\n";
  for (std::size_t i = 0; i < step.told.size(); ++i) {
    text += fmt::format("    {},\n", command_text(step, step.told[i], i));
  }
  text += "};\n\nconst std::vector<Made> all_made{\n";
  for (std::size_t i = 0; i < step.made.size(); ++i) {
    text += fmt::format("    {{{}, {}, \"expected{}.bin\", \"found{}.bin\"}},\n", step.made[i].array,
                        step.made[i].first, i, i);
  }
  return text + "};\n";
}

std::string readme(const Comparison& comparison, std::string_view program, const std::string& repeat) {
  return fmt::format(
      R"({}, {} ({}), computes other bits than the specification:

  {}
{}
The step in which they first differ, without anything around it. Build and run, in this folder:

{}
It says which numbers are not as expected: exit status 1; 0 where all are, 2 where it could not be done.

  reproduce.cpp   does the step again; replay.hpp reads files and compares
  step.inc        the step: arrays, programs, and what the device is told
  program*        the texts as the driver's compiler was given them
  array*.bin      what each array has before the step; written*.bin is written during it
  expected*.bin   what the step should make; found*.bin is what it made

Found by: {}
)",
      comparison.backend, comparison.device.name, comparison.device.driver, comparison.first->text(),
      comparison.why.empty() ? "" : fmt::format("  why: {}\n", comparison.why), build_line(program), repeat);
}

/// All files and what they have, but for README.txt.
std::map<std::string, std::string> files_of(const RecordedStep& step) {
  std::map<std::string, std::string> files{{"replay.hpp", std::string(sources::replay_text)},
                                           {"step.inc", step_text(step)}};
  for (std::size_t i = 0; i < step.arrays.size(); ++i) {
    files.emplace(fmt::format("array{}.bin", i), as_text(step.arrays[i].before));
  }
  for (std::size_t i = 0; i < step.programs.size(); ++i) {
    files.emplace(fmt::format("program{}.{}", i, step.programs[i].ending), step.programs[i].bytes);
    files["reproduce.cpp"] = program_for(step.programs[i].ending);
  }
  for (std::size_t i = 0; i < step.told.size(); ++i) {
    if (!step.told[i].program) {
      files.emplace(fmt::format("written{}.bin", i), as_text(step.told[i].bytes));
    }
  }
  for (std::size_t i = 0; i < step.made.size(); ++i) {
    files.emplace(fmt::format("expected{}.bin", i), as_text(step.made[i].expected));
    files.emplace(fmt::format("found{}.bin", i), as_text(step.made[i].found));
  }
  return files;
}

} // namespace

void write_reproducer(const std::filesystem::path& folder, const Comparison& comparison,
                      const std::string& repeat) {
  std::map<std::string, std::string> files = files_of(*comparison.step);
  files.emplace("README.txt", readme(comparison, files.at("reproduce.cpp"), repeat));
  std::vector<std::string> names;
  std::ranges::transform(files, std::back_inserter(names), [](const auto& file) { return file.first; });
  require_folder(folder, names, {});
  for (const auto& [name, bytes] : files) {
    write_text(folder / name, bytes);
  }
}

} // namespace hdmbench
