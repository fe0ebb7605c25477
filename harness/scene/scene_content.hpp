#pragma once

#include "harness/scene/placement.hpp"
#include "harness/scene/scene.hpp"
#include "harness/scene/toml_reader.hpp"
#include "kernels/data/level.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

/// What the pixels of a scene file are made of, and the conditions on them (harness/scene/scenes/README.md).
/// Everything here throws InputError with file, line and what to do.
namespace hdmbench {

/// What the pixels are made of, before conditions.
struct Content {
  LabelField labels;
  ScalarField modulus;
  ScalarField picture;
  double spacing = 1.0;
  Placement placement{};
  bool segmented = false; ///< labels says which tissue, not the same everywhere for want of one
};

/// Image files are found relative to the scene file.
class Files {
public:
  explicit Files(std::filesystem::path folder) : folder_(std::move(folder)) {}
  [[nodiscard]] std::filesystem::path operator()(const std::string& name) const { return folder_ / name; }

private:
  std::filesystem::path folder_;
};

/// Millimetres per pixel where the scene says it: above 0.
[[nodiscard]] std::optional<double> read_spacing(TomlReader& scene);

/// A scene file that is shipped or on the disk.
struct SceneText {
  std::string name;
  std::string file_name;        ///< for messages
  std::filesystem::path folder; ///< of the files that it names
  std::string text;
};
/// `scene` as load_scene takes it. Throws MissingFile, and InputError where the file cannot be read.
[[nodiscard]] SceneText text_of(const std::string& scene);

/// Fails where the image that `key` names leaves pixels free of a scene of that size, although 0 is no value.
void require_filled(const TomlReader& image, std::string_view key, bool is_padded, Extent size);

/// Fails where `key` has a displacement of so many pixels that it must be a mistake: beyond what an image can
/// have, of a size whose square leaves a 32-bit float soon. One that is not finite is found later.
void require_possible_displacement(const TomlReader& table, std::string_view key, double displacement);

/// Fails where an image that `key` names has another extent than the scene.
void require_extent(TomlReader& table, std::string_view key, Extent found, Extent wanted);

/// Gray values stretched to 0 ... 255 from the darkest to the brightest one, so that any modality can be
/// looked at.
void stretch(ScalarField& picture);

/// [image]: labels or moduli, and a picture. `size` as in ReadOptions; the scene's `spacing` is that of the
/// pixels before.
[[nodiscard]] Content read_image_content(TomlReader& image, TomlReader& scene, const Files& file,
                                         std::optional<Extent> size);

/// [brain]: a slice of a 3-D brain, classified.
[[nodiscard]] Content read_brain_content(TomlReader& brain, TomlReader& scene, const Files& file, Extent size,
                                         const SceneOptions& options);

/// [[shape]]: painted in order.
[[nodiscard]] Content read_shapes_content(TomlReader& scene, Extent size);

/// Paints the [[shape]] tables in order, later ones over earlier ones. Positions and sizes are fractions of
/// the image: 0 is its first column or row of pixel centres, 1 its last, so a shape keeps its place at every
/// size. Throws InputError where a table is wrong or a pixel stays unpainted.
[[nodiscard]] LabelField paint_shapes(TomlReader& scene, Extent extent);

/// Fills level.modulus, target, confidence and `start` from a [random] table: seed, modulus = [low, high] in
/// MPa, displacement (largest, px), grid (displacements are multiples of it, 0: any), observed (share of the
/// components with confidence). The same on every machine: a 64-bit Mersenne twister and no library
/// distribution. All fields have the level's extent. Throws InputError.
void fill_randomly(TomlReader& table, Level& level, VectorField& start);

/// Applies the [[condition]] tables of a scene to level.target and level.confidence in order, later ones over
/// earlier ones (harness/scene/scenes/README.md). Displacements are pixels at every size. `labels` tells
/// where "outside" (label 0) is. Only the elastic `energy` knows a condition's deviation. Throws InputError.
void apply_conditions(TomlReader& scene, const LabelField& labels, EnergyModel energy, Level& level);

} // namespace hdmbench
