#pragma once

#include "harness/scene/images/images.hpp"
#include "harness/scene/scene.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <filesystem>
#include <functional>
#include <future>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// This header has what `run` writes into its output folder.
namespace hdmbench::commands {

/// What pictures a run draws.
enum class Pictures {
  none,
  usual,
  with_deviation ///< and the standard deviation of the displacement
};

/// Returns the names of the field, with this extension, and then, of a scene that is inspected, of the
/// pictures, where there are to be any.
[[nodiscard]] std::vector<std::string> file_names(const Scene& scene, const std::string& extension,
                                                  Pictures drawn);

/// Returns what `draw` makes of each plane, in a row, with squares for pixels and as heads stand: z leads up.
/// `pixel`: Level::sides.
[[nodiscard]] ScalarField drawn_beside(std::span<const Plane> planes, const std::array<double, 3>& pixel,
                                       const std::function<ScalarField(const Plane&)>& draw);
/// The lines of a grid in the plane after the displacement (in steps from site to site). They stay in it:
/// what leads out of it does not show.
[[nodiscard]] ScalarField warped_grid(const VectorField& steps, const Plane& plane);
/// area_change_map() in the plane, of a displacement in steps from site to site; `tissue` as it has it.
[[nodiscard]] ScalarField content_change(const VectorField& steps, const Plane& plane,
                                         const ScalarField& tissue = {});

/// Throws InputError where `file`, of `option`, is one of those that run writes into its folder anyway; "a"
/// and
/// "./a" are one file, there or not.
void require_own_name(const std::filesystem::path& file, std::string_view option,
                      const std::filesystem::path& folder, const std::vector<std::string>& names);

/// Returns the displacement that leads back, to 0.01 pixels, in pixels. Throws as invert().
Inverse inverse_of(const Scene& scene, const VectorField& displacement);
/// Writes it, too. Throws as write_displacement() and invert().
Inverse write_inverse(const std::filesystem::path& file, const Scene& scene, const VectorField& displacement);

/// The files of a run, which threads write while the object lives: one the field, one the pictures, one the
/// transform.
class FilesOfRun {
public:
  /// `files`: what file_names() gave. `transform`: the file of the displacement that leads back; empty: none.
  /// `deviation` of the displacement, pixels; null: file_names() has no picture of it. What is referred to
  /// outlives the object.
  FilesOfRun(std::filesystem::path folder, std::vector<std::string> files, std::filesystem::path transform,
             const Scene& scene, const VectorField& displacement, const VectorField* deviation);
  FilesOfRun(const FilesOfRun&) = delete;
  FilesOfRun& operator=(const FilesOfRun&) = delete;

  /// Waits for the files, says so, and puts their names, as they are seen from the result file `results`, and
  /// the seconds that they took into the row of the run. To be called once. Throws InputError where one could
  /// not be written.
  void finish(const std::filesystem::path& results, nlohmann::json& row);

private:
  void finish_transform(const std::filesystem::path& results, nlohmann::json& row);

  std::filesystem::path folder_;
  std::vector<std::string> files_;
  std::vector<std::string> pictures_of_; ///< what the files after the first are in the row
  std::filesystem::path transform_;
  std::future<double> field_;                               ///< gives its seconds
  std::future<std::pair<double, nlohmann::json>> pictures_; ///< and how the slices of a volume lie
  std::future<std::pair<double, Inverse>> inverse_;         ///< without its field
};

} // namespace hdmbench::commands
