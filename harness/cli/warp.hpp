#pragma once

#include "harness/solve/progress.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// What `warp` and `run --warp` share: pictures that a displacement moves.
namespace hdmbench::commands {

/// Returns what the pictures are called when they have moved: "t1.nrrd" of "t1.nii.gz", `ending` being nrrd.
/// Throws InputError where two would have one name, or one cannot be read.
[[nodiscard]] std::vector<std::string> moved_names(std::span<const std::filesystem::path> pictures,
                                                   const std::string& ending);

/// Moves a picture, or a segmentation, by what run --transform wrote. Throws as write_moved(). Returns what
/// to say of it, and leaves no progress on the screen.
[[nodiscard]] std::string move_picture(const std::filesystem::path& file,
                                       const std::filesystem::path& picture,
                                       const std::filesystem::path& transform, bool is_labels,
                                       Progress& progress);

} // namespace hdmbench::commands
