#include "harness/scene/scene_content.hpp"

#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <scene_texts.hpp>
#include <tissue_texts.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <utility>

namespace hdmbench {

namespace {

using Pair = std::array<double, 2>;

/// Gray values black ... white stretched to 0 ... 255; without `range` from the darkest to the brightest one,
/// so that any modality can be looked at.
void stretch(ScalarField& picture, std::optional<Pair> range = std::nullopt) {
  const auto [darkest, brightest] = std::ranges::minmax_element(picture.values);
  const float black = range ? static_cast<float>((*range)[0]) : *darkest;
  const float white = range ? static_cast<float>((*range)[1]) : *brightest;
  const float scale = white > black ? 255.0F / (white - black) : 0.0F;
  for (float& value : picture.values) {
    value = (value - black) * scale;
  }
}

/// Of moduli without labels.
void show_moduli(const ScalarField& modulus, Content& content) {
  content.labels = {modulus.extent, std::vector<int>(modulus.extent.sites(), 1)};
  if (is_inspected(modulus.extent)) {
    content.picture = modulus;
    stretch(content.picture);
  }
}

/// Fails where the image that `key` names leaves pixels free of a scene of that size, although 0 is no value.
void require_filled(const TomlReader& image, std::string_view key, bool is_padded, Extent size) {
  if (is_padded) {
    image.fail(key, fmt::format("does not fill {} pixels, which have another aspect, and beside the image 0 "
                                "means nothing; give a size with the image's own aspect",
                                size.text()));
  }
}

/// What a [[shape]] is painted with, and where.
struct Shape {
  /// The flat ones, then those of volumes.
  enum class Kind { everything, rectangle, ellipse, box, ellipsoid };

  Kind kind = Kind::everything;
  int label = 0;
  std::vector<double> centre{};
  std::vector<double> size{};

  /// Distance from the centre along an axis for each of its `count` sites, 1 on the outline.
  [[nodiscard]] std::vector<double> distances(std::size_t axis, int count) const {
    std::vector<double> result(static_cast<std::size_t>(count));
    for (int i = 0; i < count && axis < centre.size(); ++i) {
      const double fraction = count > 1 ? static_cast<double>(i) / (count - 1) : 0.5;
      result[static_cast<std::size_t>(i)] = 2.0 * std::abs(fraction - centre[axis]) / size[axis];
    }
    return result;
  }

  /// At these distances along the axes.
  [[nodiscard]] bool contains(double u, double v, double w) const {
    // A hair more than 1, so that an outline through pixel centres is not decided by rounding.
    constexpr double outline = 1.0 + 1e-9;
    return kind == Kind::rectangle || kind == Kind::box ? std::max({u, v, w}) <= outline
                                                        : u * u + v * v + w * w <= outline;
  }
};

Shape read_shape(TomlReader& table, std::size_t axes) {
  constexpr std::array<std::string_view, 5> kinds{"everything", "rectangle", "ellipse", "box", "ellipsoid"};
  Shape shape{.label = table.get<int>("label")};
  table.read("kind", kinds, shape.kind);
  if (shape.kind != Shape::Kind::everything) {
    if ((shape.kind >= Shape::Kind::box) != (axes == 3)) {
      table.fail("kind",
                 axes == 3 ? "is flat, and the scene is a volume: take \"box\" or \"ellipsoid\""
                           : "has three axes, and the scene is an image: take \"rectangle\" or \"ellipse\"");
    }
    shape.centre = table.numbers("centre", axes, axes);
    shape.size = table.numbers("size", axes, axes);
  }
  table.finish();
  return shape;
}

/// Random numbers that are the same on every machine.
class Source {
public:
  explicit Source(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}

  /// In [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  float one_of(const std::vector<float>& values) {
    return values[static_cast<std::size_t>(uniform() * static_cast<double>(values.size()))];
  }

private:
  std::mt19937_64 engine_;
};

/// Values to draw from; empty where the key is absent.
std::vector<float> read_list(TomlReader& table, std::string_view key) {
  std::vector<float> values;
  table.read(key, values);
  if (values.empty() && table.has(key)) {
    table.fail(key, "must have a value to draw");
  }
  return values;
}

} // namespace

void require_same_grid(const TomlReader& table, std::string_view key, const FileGrid& grid,
                       const FileGrid& of_scene) {
  if (const std::string difference = difference_between(grid, of_scene, "the scene"); !difference.empty()) {
    table.fail(key, difference);
  }
}

void require_possible_displacement(const TomlReader& table, std::string_view key, double displacement) {
  constexpr double largest = 1e9;
  if (std::isfinite(displacement) && std::abs(displacement) > largest) {
    table.fail(key, fmt::format("has a displacement of {:g} pixels; at most {:g} are possible", displacement,
                                largest));
  }
}

std::filesystem::path SceneText::image(TomlReader& table, std::string_view key, ReadOptions& options) const {
  options.in_memory = nullptr;
  if (given != nullptr) {
    if (const auto found = given->images.find(key); found != given->images.end()) {
      options.in_memory = &found->second;
    }
  }
  return folder / table.get<std::string>(key);
}

SceneText text_of(const std::string& scene) {
  const auto* const shipped = std::ranges::find(scene_texts::all, scene, &scene_texts::Text::name);
  if (shipped != scene_texts::all.end()) {
    return {scene, scene + ".toml", {}, std::string(shipped->text)};
  }
  const std::filesystem::path path(scene);
  if (!std::filesystem::exists(path)) {
    throw MissingFile(fmt::format("there is no scene and no file \"{}\"; the shipped scenes are {}, {}",
                                  scene, fmt::join(shipped_scenes(), ", "),
                                  fmt::join(shipped_volumes, ", ")));
  }
  constexpr std::array images{".nii", ".gz",  ".nrrd", ".nhdr", ".mha", ".mhd", ".hdr",
                              ".img", ".png", ".jpg",  ".jpeg", ".tif", ".tiff"};
  if (std::ranges::find(images, path.extension()) != images.end()) {
    throw InputError(
        fmt::format("{}: this is an image by its name; a scene is a TOML file, which names it: "
                    "[image] labels = \"{}\", and a [[tissue]] for each label; or give run a file of "
                    "these beside it: --tissues FILE",
                    scene, path.filename().string()));
  }
  return {path.stem().string(), scene, path.parent_path(), read_file(path)};
}

bool is_shipped_tissues(const std::filesystem::path& tissues) {
  return !std::filesystem::exists(tissues) &&
         contains(tissue_texts::all, tissues.string(), &tissue_texts::Text::name);
}

std::string tissues_text(const std::filesystem::path& tissues) {
  if (is_shipped_tissues(tissues)) {
    return std::string(
        std::ranges::find(tissue_texts::all, tissues.string(), &tissue_texts::Text::name)->text);
  }
  if (!std::filesystem::exists(tissues)) {
    throw MissingFile(fmt::format(
        "there is no file of tissues {}; those that are shipped are brain and synthseg", tissues.string()));
  }
  return read_file(tissues);
}

toml::table scene_of_labels(const std::filesystem::path& labels, const std::filesystem::path& tissues) {
  if (labels.extension().empty() || labels.extension() == ".toml") {
    throw InputError(fmt::format(
        "--tissues is for a scene that is an image of labels; {} has tissues of its own", labels.string()));
  }
  toml::table root = parse_toml(tissues_text(tissues), tissues.string());
  if (root.contains("image")) {
    throw InputError(
        fmt::format("{}: is a scene of its own, with an [image]; --tissues takes what a scene has beside "
                    "its labels",
                    tissues.string()));
  }
  root.erase("recipe"); // of hdmbench dataset
  root.insert("image", toml::table{{"labels", std::filesystem::absolute(labels).string()}});
  add_usual_keys(root);
  return root;
}

void add_usual_keys(toml::table& root) {
  root.insert("energy", "elastic");
  if (!root.contains("condition")) {
    root.insert("condition", toml::array{toml::table{{"where", "border"}, {"outward", 0.0}}});
  }
}

std::vector<std::filesystem::path> files_of_scene(const std::string& scene) {
  std::vector<std::filesystem::path> files{scene};
  try {
    const SceneText file = text_of(scene);
    const toml::table root = parse_toml(file.text, file.file_name);
    const auto add_files = [&](const toml::node_view<const toml::node>& table) {
      if (const toml::table* const names = table.as_table()) {
        for (const auto& [key, value] : *names) {
          if (const auto* const name = value.as_string()) {
            files.push_back(file.folder / name->get());
          }
        }
      }
    };
    for (const std::string_view table : {"image", "brain"}) {
      add_files(root[table]);
    }
    for (std::size_t i = 0; root["points"][i]; ++i) {
      add_files(root["points"][i]);
    }
  } catch (const toml::parse_error&) {
  } catch (const InputError&) { // who loads the scene says what is wrong with it
  }
  std::erase_if(files, [](const std::filesystem::path& file) {
    std::error_code missing;
    return !std::filesystem::is_regular_file(file, missing);
  });
  return files;
}

Content read_image_content(TomlReader& image, TomlReader& scene, const SceneText& file,
                           std::optional<Extent> size, bool takes_boxes) {
  Content content;
  ReadOptions options{.size = size, .takes_volumes = true, .takes_boxes = takes_boxes};
  scene.read("spacing", options.spacing);
  content.stated_spacing = options.spacing;
  image.read("slice", options.slice);
  const auto take_place = [&](const auto& found) {
    content.spacing = found.spacing;
    content.placement = found.placement;
    content.grid = found.grid;
    content.oblong = found.oblong;
  };
  if (image.has("labels") == image.has("modulus")) {
    image.fail("labels", "or modulus: give exactly one of the two images");
  }
  if (image.has("labels")) {
    const std::filesystem::path labels_file = file.image(image, "labels", options);
    auto labels = read_labels(labels_file, options);
    take_place(labels);
    const bool shown = !image.has("picture");
    const auto tissues = read_tissues(scene, shown);
    require_filled(image, "labels", labels.padded && !tissues.contains(0), labels.pixels.extent);
    content.labels = std::move(labels.pixels);
    assign_tissues(scene, tissues, content, shown);
  } else {
    const std::filesystem::path modulus_file = file.image(image, "modulus", options);
    auto modulus = read_scalar(modulus_file, options);
    take_place(modulus);
    require_filled(image, "modulus", modulus.padded, modulus.pixels.extent);
    content.modulus = std::move(modulus.pixels);
    show_moduli(content.modulus, content);
  }
  if (image.has("picture")) {
    const std::filesystem::path picture_file = file.image(image, "picture", options);
    auto picture = read_scalar(picture_file, options);
    require_same_grid(image, "picture", picture.grid, content.grid);
    content.picture = std::move(picture.pixels);
    std::optional<Pair> range;
    image.read("picture_range", range);
    if (range && !((*range)[0] < (*range)[1])) {
      image.fail("picture_range", "must be [black, white] with black < white");
    }
    stretch(content.picture, range);
    if (!is_inspected(content.picture.extent)) {
      content.picture = {};
    }
  }
  return content;
}

Content read_brain_content(TomlReader& brain, TomlReader& scene, const std::filesystem::path& folder,
                           std::optional<Extent> size, const SceneOptions& options) {
  const auto tissues = read_tissues(scene, false);
  const auto name = brain.get<std::string>("file");
  const auto content_of = [&](BrainSlice found) {
    Content content{.labels = std::move(found.tissue),
                    .modulus = {},
                    .picture = std::move(found.picture),
                    .spacing = found.spacing,
                    .placement = found.placement,
                    .grid = {.stated = Stated::place},
                    .oblong = found.oblong};
    assign_tissues(scene, tissues, content, false);
    return content;
  };
  if (brain.has("head")) {
    const auto head = brain.get<std::string>("head");
    const int classes = brain.get<int>("classes");
    double sulci = 0.0;
    brain.read("sulci", sulci);
    brain.finish();
    Content content = content_of(read_head(folder / name, folder / head, classes, sulci, size));
    stretch(content.picture);
    if (!is_inspected(content.picture.extent)) {
      content.picture = {};
    }
    return content;
  }
  Orientation orientation{};
  brain.read("orientation", orientation_names, orientation);
  std::optional<int> slice = brain.get<int>("slice");
  if (!options.orientation.empty()) {
    const auto* const found = std::ranges::find(orientation_names, options.orientation);
    if (found == orientation_names.end()) {
      throw InputError(fmt::format("there is no orientation \"{}\", there are {}", options.orientation,
                                   fmt::join(orientation_names, ", ")));
    }
    orientation = static_cast<Orientation>(found - orientation_names.begin());
    slice = options.slice;
  }
  const int classes = brain.get<int>("classes");
  const double margin = brain.get<double>("margin");
  brain.finish();
  return content_of(read_brain(folder / name, slice, classes, margin, *size, orientation));
}

Content read_shapes_content(TomlReader& scene, Extent size) {
  constexpr int unpainted = -1;
  Content content{.labels = {size, std::vector<int>(size.sites(), unpainted)}, .modulus = {}, .picture = {}};
  std::vector<int>& labels = content.labels.values;
  for (TomlReader& table : scene.tables("shape")) {
    const Shape shape = read_shape(table, size.axes());
    const std::vector<double> columns = shape.distances(0, size.width);
    const std::vector<double> rows = shape.distances(1, size.height);
    auto label = labels.begin();
    for (const double slice : shape.distances(2, size.depth)) {
      for (const double row : rows) {
        for (const double column : columns) {
          *label = shape.contains(column, row, slice) ? shape.label : *label;
          ++label;
        }
      }
    }
  }
  if (const auto found = std::ranges::find(labels, unpainted); found != labels.end()) {
    scene.fail("shape", fmt::format("tables leave the pixel {} unpainted; begin with kind = \"everything\"",
                                    size.place(static_cast<std::size_t>(found - labels.begin()))));
  }
  assign_tissues(scene, read_tissues(scene, true), content, true);
  return content;
}

Content read_random_content(TomlReader& table, Level& level, VectorField& start) {
  Source source(table.get<int>("seed"));
  if (table.has("modulus") == table.has("moduli")) {
    table.fail("modulus", "or moduli: give a range or a list of values (MPa)");
  }
  const std::vector<float> moduli = read_list(table, "moduli");
  const std::vector<float> confidences = read_list(table, "confidences");
  Pair modulus{1.0, 1.0};
  table.read("modulus", modulus);
  if (modulus[1] < modulus[0]) {
    table.fail("modulus", "must be [low, high] with 0 < low <= high (MPa)");
  }
  const double largest = table.get<double>("displacement");
  const double observed = table.get<double>("observed");
  double grid = 0.0;
  table.read("grid", grid);
  table.finish();

  const auto displacement = [&] {
    const double value = largest * (2.0 * source.uniform() - 1.0);
    return static_cast<float>(grid > 0.0 ? grid * std::round(value / grid) : value);
  };
  // Without a list a third of the observed components are certain, the others anything between.
  const auto confidence = [&] {
    const double draw = source.uniform();
    if (!confidences.empty()) {
      const float certainty = source.one_of(confidences);
      return draw >= observed ? 0.0F : certainty;
    }
    return static_cast<float>(draw >= observed ? 0.0 : draw < observed / 3.0 ? 1.0 : source.uniform());
  };
  for (std::size_t i = 0; i < level.extent.sites(); ++i) { // the order of the draws is the scene's
    level.modulus.values[i] =
        moduli.empty() ? static_cast<float>(modulus[0] + (modulus[1] - modulus[0]) * source.uniform())
                       : source.one_of(moduli);
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      level.target[axis][i] = displacement();
    }
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      level.confidence[axis][i] = confidence();
    }
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      start[axis][i] = displacement();
    }
  }
  Content content;
  show_moduli(level.modulus, content);
  return content;
}

} // namespace hdmbench
