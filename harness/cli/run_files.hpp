#pragma once

#include "harness/scene/scene.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// What `run` writes into its output folder.
namespace hdmbench::commands {

/// Returns the names of the field, with this extension, and then, of a scene that is inspected, of the
/// pictures.
[[nodiscard]] std::vector<std::string> file_names(const Scene& scene, const std::string& extension);

/// Writes these `files`, says so, and puts their names, as they are seen from the result file `results`, into
/// the row of the run. Throws InputError where one cannot be written.
void write_files(const std::filesystem::path& folder, const std::vector<std::string>& files,
                 const std::filesystem::path& results, const Scene& scene, const VectorField& displacement,
                 nlohmann::json& row);

} // namespace hdmbench::commands
