#pragma once

#include "harness/scene/scene.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace hdmbench {

/// Everything a scene is computed from as images that ITK, 3D Slicer and ParaView open, in `folder`:
/// picture.nrrd, modulus.nrrd (MPa), target.nrrd (pixels) and confidence.nrrd, labels.nrrd where the scene
/// has a segmentation and start.nrrd where it does not begin at 0; picture.png, target.png and confidence.png
/// to look at, in an image that is inspected (harness/scene/scene.hpp), as picture.nrrd; and, last,
/// scene.toml that refers to them and is the same problem to the bit (thesis A.3, A.6). Returns the names of
/// the files. Throws InputError where the folder does not exist or cannot be written, or in a build without
/// images.
std::vector<std::string> export_scene(const Scene& scene, const std::filesystem::path& folder);

} // namespace hdmbench
