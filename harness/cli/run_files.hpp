#pragma once

#include "harness/scene/scene.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

/// The files that `run` writes.
namespace hdmbench::commands {

/// What goes to the output folder: the field, with this extension, then, of a scene that is inspected, the
/// pictures.
[[nodiscard]] std::vector<std::string> file_names(const Scene& scene, const std::string& extension);

/// Writes these `files`, says so, and puts their names, as they are seen from the result file `results`, into
/// the row of the run. Throws InputError where one cannot be written.
void write_files(const std::filesystem::path& folder, const std::vector<std::string>& files,
                 const std::filesystem::path& results, const Scene& scene, const VectorField& displacement,
                 nlohmann::json& row);

} // namespace hdmbench::commands
