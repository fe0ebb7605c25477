#pragma once

#include "harness/cli/arguments.hpp"

#include <filesystem>
#include <span>
#include <string>

/// What `register` and `detect` take: two pictures of one person, and the scene that they show.
namespace hdmbench::commands {

/// Two pictures and what is known of them.
struct PictureData {
  Scene scene;
  ScalarField source; ///< gray values of both 0 ... 255, on one scale
  ScalarField target;
  ScalarField region;    ///< not 0: of interest; empty where none was asked for
  Placement placement{}; ///< of the source; the scene's where the file cannot say
};

/// The options of both commands. With `schedule` where there is more than one way to solve.
[[nodiscard]] Options pair_options(const Options& schedule);
/// Reads what the options name. Throws InputError where the two pictures, the scene and the region do not
/// belong together: other sizes or spacings, no overlap, one gray value, no labels, an empty region.
[[nodiscard]] PictureData load_pictures(const Call& call);

/// Makes the output folder and sees that `files` can be written to it and are none of the inputs, before long
/// work. Throws InputError.
void require_output(const Call& call, std::span<const std::string> files);
/// The file of a picture in the output folder, which the row of `register` or `detect` then names, as the
/// result file sees it.
[[nodiscard]] std::filesystem::path picture_file(json& row, const Call& call, const std::string& name,
                                                 const char* caption);

} // namespace hdmbench::commands
