#pragma once

#include "harness/scene/scene.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace hdmbench::commands {

/// The files that write_strain_images writes.
[[nodiscard]] std::vector<std::string> strain_image_names(const Scene& scene);

/// Writes the strains of the displacement, its von Mises stress and the change of area of the scene's sheet
/// into `folder`, each as SCENE-WHAT.nrrd (the numbers) and .png (the area's is written as `jacobian` by
/// every run). Prints where they are largest. Returns the files' names. Throws InputError where one cannot be
/// written.
[[nodiscard]] std::vector<std::string>
write_strain_images(const Scene& scene, const VectorField& displacement, const std::filesystem::path& folder);

} // namespace hdmbench::commands
