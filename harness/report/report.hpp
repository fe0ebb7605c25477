#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace hdmbench {

/// Writes one HTML page that needs nothing else: style, scripts, results and pictures are inside it.
/// `results` are files that --json wrote, or folders in which all *.json files are taken; pictures are those
/// that the results name, relative to the JSON file, and those that lie in such a folder. The page goes
/// without a picture that is missing, that it does not show, or that would make it larger than 3 MB. Lists of
/// more than a hundred numbers stay out of it. Written beside the target and renamed. Throws InputError
/// naming a file that is missing, not JSON, or of another schema.
void write_report(std::span<const std::filesystem::path> results, const std::filesystem::path& page);

/// The same results on a screen of a terminal: the verdict of each machine, and the speed on its first scene
/// at the largest size. Throws as write_report does of the files.
[[nodiscard]] std::string summary_text(std::span<const std::filesystem::path> results);

} // namespace hdmbench
