#pragma once

#include "harness/scene/given_scene.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/placement.hpp"
#include "harness/scene/precision.hpp"
#include "harness/scene/scene.hpp"
#include "harness/scene/toml_reader.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// What the pixels of a scene file are made of, and the conditions on them (harness/scene/scenes/README.md).
/// Everything here throws InputError with file, line and what to do.
namespace hdmbench {

/// The fibres of a tissue.
struct Fibres {
  double modulus = 0.0;                         ///< MPa, above 0
  std::optional<Placement::Vector> direction{}; ///< in the patient's space, of any length; none: an image's
  bool tension_only = true;
};

/// What a tissue does about large strains.
struct TissueLaw {
  const Law* text = nullptr; ///< null: it is linear
  float parameter = -1.0F;   ///< as Level::law_parameter has it
};

/// What the pixels are made of, before conditions.
struct Content {
  std::map<int, double> densities{}; ///< of labels that have one, kg/m^3
  std::map<int, TissueLaw> laws{};   ///< of labels that have one of their own
  LabelField labels;
  ScalarField modulus;
  ScalarField picture;
  double spacing = 1.0;
  Placement placement{};
  FileGrid grid{.stated = Stated::sides}; ///< of an image, as of Image; else only `stated`
  std::optional<FileGrid> oblong{};       ///< as of Image
  std::optional<double> stated_spacing{}; ///< of the scene file, for its other images
  bool knows_millimetres = false;         ///< something says what the spacing is
  bool segmented = false;               ///< labels says which tissue, not the same everywhere for want of one
  std::vector<std::string> idle{};      ///< as of Scene
  std::optional<Precision> precision{}; ///< of [image], which acts beside all other conditions
  VectorField force{};                  ///< of [image], as Level has it; empty: there is none
  VectorField fibre{};            ///< of [image], along its axes, of length 1 or 0; empty: there is none
  std::map<int, Fibres> fibres{}; ///< of labels that have such
  VectorField normals{}; ///< of walls, of [image], along its axes, of length 1 or 0; empty: there is none
};

/// A scene file that is shipped or on the disk, or what is in memory in place of one.
struct SceneText {
  std::string name;
  std::string file_name;        ///< for messages
  std::filesystem::path folder; ///< of the files that it names
  std::string text;
  const GivenScene* given = nullptr; ///< where its images may be; null: in files

  /// Returns the file that `key` of [image] names. `options` get its pixels where they are in memory.
  [[nodiscard]] std::filesystem::path image(TomlReader& table, std::string_view key,
                                            ReadOptions& options) const;
};
/// `scene` as load_scene takes it. Throws MissingFile, and InputError where the file cannot be read.
[[nodiscard]] SceneText text_of(const std::string& scene);

/// Returns the text of a file of tissues; of the shipped ones, "synthseg" and "brain", where there is no file
/// of that name. Throws InputError.
[[nodiscard]] std::string tissues_text(const std::filesystem::path& tissues);
/// Whether that is a shipped one, which has tissues that no pixel needs to have.
[[nodiscard]] bool is_shipped_tissues(const std::filesystem::path& tissues);

/// Returns the scene of a label image and of a file with what else a scene has: the [[tissue]] tables, and
/// whatever is not to be as it is without: energy = "elastic", and the border held where it is. Throws
/// InputError, and toml::parse_error.
[[nodiscard]] toml::table scene_of_labels(const std::filesystem::path& labels,
                                          const std::filesystem::path& tissues);

/// Fails where the pixels of the image that `key` names are not those of the scene's file.
void require_same_grid(const TomlReader& table, std::string_view key, const FileGrid& grid,
                       const FileGrid& of_scene);

/// Fails where `key` has a displacement of so many pixels that it must be a mistake: beyond what an image can
/// have, of a size whose square leaves a 32-bit float soon. One that is not finite is found later.
void require_possible_displacement(const TomlReader& table, std::string_view key, double displacement);

/// Puts into a scene of labels what it is to have where it says nothing else: energy = "elastic", and the
/// border held where it is.
void add_usual_keys(toml::table& root);

/// [image]: labels or moduli, and a picture of the scene `file`. `size` and `takes_boxes` as in ReadOptions;
/// the scene's `spacing` is that of the pixels before.
[[nodiscard]] Content read_image_content(TomlReader& image, TomlReader& scene, const SceneText& file,
                                         std::optional<Extent> size, bool takes_boxes);

/// [brain]: a slice of a 3-D brain, classified, or a whole head; only that needs no size.
[[nodiscard]] Content read_brain_content(TomlReader& brain, TomlReader& scene,
                                         const std::filesystem::path& folder, std::optional<Extent> size,
                                         const SceneOptions& options);

/// Paints the [[shape]] tables in order, later ones over earlier ones. Positions and sizes are fractions of
/// the image: 0 is its first column or row of pixel centres, 1 its last, so a shape keeps its place at every
/// size.
[[nodiscard]] Content read_shapes_content(TomlReader& scene, Extent size);

/// [random]: moduli, target and confidence of `level`, and `start`, all of its extent. The same on every
/// machine: a 64-bit Mersenne twister and no library distribution.
[[nodiscard]] Content read_random_content(TomlReader& table, Level& level, VectorField& start);

/// Images of target displacement (pixels, or millimetres) and how certain it is, before the built-in
/// conditions, and of the displacement to begin with, on the pixels of the file that `content` was made of;
/// from there they are carried to the sites. What acts later, a precision and forces, becomes the content's.
void read_vector_images(TomlReader& image, const SceneText& file, std::optional<Extent> size,
                        Content& content, Scene& scene);

/// Which state of a body: that of its image, or the one that is asked for.
enum class When { before, now };

/// What is to be known of conditions that were applied.
struct AppliedConditions {
  std::vector<std::string> idle{};                ///< what has no effect, as of Scene::idle
  std::optional<TurnOfNormals> turn_of_normals{}; ///< as of Scene
};

/// Applies the [[condition]] tables of a scene to level.target and level.confidence in order, later ones over
/// earlier ones. Displacements are pixels at every size, or millimetres, of which content.spacing make a
/// pixel. Where the file's pixels are oblong, the conditions are on these, and carried to the sites. Its
/// labels tell where "outside" (label 0) is. Only conditions that may be springs know a deviation
/// (RegisteredEnergy::is_of_cells). Before, only those that hold were there.
AppliedConditions apply_conditions(TomlReader& scene, const Content& content, bool may_be_springs,
                                   Level& level, When when = When::now);

/// Adds up the content's forces and the [[load]] tables in level.force: a gravity (m/s^2 in the patient's
/// space, LPS) pulls at what the densities of tissues are, a pressure (MPa) pushes the sites of one label
/// away from those of another beside them. Sites on the border of the image stand for a half of a pixel.
/// `energy` is the one that will be minimised; moduli are MPa, and gravity needs to know millimetres. Loads
/// with before = true are those of before alone. Returns, as of Scene::idle, what has no effect.
[[nodiscard]] std::vector<std::string> apply_loads(TomlReader& scene, const Content& content,
                                                   const RegisteredEnergy& energy, Level& level,
                                                   When when = When::now);

/// Takes the labels of [[resect]] out of the level (modulus 0). Returns the body with them, as its image has
/// it: what holds it, and the loads of before; none where nothing is taken out. `energy` is the one that will
/// be minimised, `law` as of apply_laws().
[[nodiscard]] std::optional<Level> take_out(TomlReader& scene, const Content& content,
                                            const RegisteredEnergy& energy, const std::string& law,
                                            Level& level);

/// A [[tissue]] table.
struct Tissue {
  float modulus = 0.0F;
  float gray = 0.0F;
  std::optional<double> density{}; ///< kg/m^3
  std::optional<TissueLaw> law{};  ///< none: the scene's own
  std::optional<Fibres> fibres{};
};

/// Reads fibre_modulus, fibre and fibre_tension_only of a [[tissue]]; none without the first.
[[nodiscard]] std::optional<Fibres> read_fibres(TomlReader& tissue);

/// Reads the [[tissue]] tables. `shown`: whether their gray values are what a picture shows.
[[nodiscard]] std::map<int, Tissue> read_tissues(TomlReader& scene, bool shown);

/// What begins the line of Scene::idle about a tissue that no pixel has.
inline constexpr std::string_view idle_tissue = "the [[tissue]] of label";
/// Gives every label of the content its tissue, and a picture of their gray values where it needs one. Fails
/// where a label has none.
void assign_tissues(TomlReader& scene, const std::map<int, Tissue>& tissues, Content& content,
                    bool needs_picture);

/// Gives void (modulus 0) so small a modulus that it holds nothing (void_share) and moves on smoothly from
/// what is around it. Specks that nothing holds (loose_specks) become void, too: returns, as of Scene::idle,
/// what became so. `energy` is the one that will be minimised. Fails where that is none of cells, or all is
/// void.
[[nodiscard]] std::vector<std::string> fill_void(TomlReader& scene, const RegisteredEnergy& energy,
                                                 Level& level);

/// Sets level.law and its parameter from the laws of labels and, for all others, of the scene, or `law` in
/// its place where that is not empty; leaves it empty where all are linear. Fails where laws of two texts
/// meet. `energy` is the one that will be minimised.
void apply_laws(TomlReader& scene, const Content& content, const RegisteredEnergy& energy,
                const std::string& law, Level& level);

/// Sets level.fibre from the fibres of labels; leaves it empty where there are none. After apply_laws():
/// fails where a tissue with fibres is linear, or nothing says where they lead. Returns, as of Scene::idle,
/// what has no effect.
[[nodiscard]] std::vector<std::string> apply_fibres(TomlReader& scene, const Content& content, Level& level);

/// Adds the [[points]] of a scene, whose files are looked for in `folder`, those of options.points (none, a
/// file of pairs, or one of before and one of after) and options.pairs to scene.points, and lets all but
/// options.idle_point act after the conditions: what is certain prescribes the sites around it so that the
/// field between them has it; a deviation is a spring on them, beside those that are there.
void apply_points(TomlReader& scene, const std::filesystem::path& folder, const SceneOptions& options,
                  const Content& content, Scene& to);

} // namespace hdmbench
