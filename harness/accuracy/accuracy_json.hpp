#pragma once

#include "harness/accuracy/accuracy.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace hdmbench {

/// Rows of `accuracy --json` for one scene. Figures of the truth to four significant digits; fields that do
/// not apply are absent. Where `pictures` is not empty the difference images are written into that folder and
/// named relative to `json_folder`. Throws InputError where a file cannot be written.
[[nodiscard]] nlohmann::json to_json(const Scene& scene, const SceneAccuracy& accuracy,
                                     const std::filesystem::path& pictures,
                                     const std::filesystem::path& json_folder);

} // namespace hdmbench
