#pragma once

#include <CLI/CLI.hpp>

#include <array>
#include <span>
#include <string>
#include <string_view>

/// The program as command line modules of 3D Slicer's: lib/slicer-modules/hdmbench-COMMAND calls a command,
/// and is asked by --xml what it takes (Slicer Execution Model).
namespace hdmbench::commands {

/// The commands that are modules.
inline constexpr std::array<std::string_view, 3> slicer_modules{"run", "register", "warp"};

/// Adds --xml to a command, which prints slicer_description() and ends the program with success.
void add_slicer_description(CLI::App& command);

/// Returns the description of a command and of all its options, in the elements that Slicer's documentation
/// names. It is made of what the command was made of, so that it cannot say anything else.
[[nodiscard]] std::string slicer_description(const CLI::App& command);

/// Writes dashes for the underscores in names of options that the command has with dashes only: Slicer's
/// schema has names without dashes.
void take_underscores(const CLI::App& command, std::span<char*> words);

} // namespace hdmbench::commands
