#include "harness/scene/scene_content.hpp"

#include "harness/scene/file_input.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <scene_texts.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

struct Tissue {
  float modulus = 0.0F;
  float gray = 0.0F;
};

/// `shown`: whether their gray values are what a picture shows.
std::map<int, Tissue> read_tissues(TomlReader& scene, bool shown) {
  std::map<int, Tissue> tissues;
  for (TomlReader& table : scene.tables("tissue")) {
    const int label = table.integer("label");
    const double modulus = table.number("modulus");
    if (!(modulus > 0.0)) {
      table.fail("modulus", fmt::format("is {}, it must be positive (MPa)", modulus));
    }
    const auto stored = static_cast<float>(modulus);
    if (!std::isfinite(stored) || !std::isfinite(1.0F / stored)) {
      table.fail("modulus", fmt::format("is {}, too {} (MPa): a 32-bit float must hold it and its inverse",
                                        modulus, modulus > 1.0 ? "large" : "small"));
    }
    (void)table.text("name", "");
    const Tissue tissue{stored, shown ? static_cast<float>(table.number("gray", 0.0)) : 0.0F};
    table.finish();
    if (!tissues.emplace(label, tissue).second) {
      table.fail("label", fmt::format("{} has a tissue already", label));
    }
  }
  return tissues;
}

void assign_tissues(TomlReader& scene, const std::map<int, Tissue>& tissues, Content& content,
                    bool needs_picture) {
  content.modulus = ScalarField(content.labels.extent);
  needs_picture = needs_picture && is_inspected(content.labels.extent);
  if (needs_picture) {
    content.picture = ScalarField(content.labels.extent);
  }
  auto tissue = tissues.end();
  for (std::size_t i = 0; i < content.labels.values.size(); ++i) {
    if (tissue == tissues.end() || tissue->first != content.labels.values[i]) {
      tissue = tissues.find(content.labels.values[i]);
    }
    if (tissue == tissues.end()) {
      const auto width = static_cast<std::size_t>(content.labels.extent.width);
      scene.fail("tissue", fmt::format("none has the label {} of the pixel x = {}, y = {}",
                                       content.labels.values[i], i % width, i / width));
    }
    content.modulus.values[i] = tissue->second.modulus;
    if (needs_picture) {
      content.picture.values[i] = tissue->second.gray;
    }
  }
}

/// Gray values low ... high stretched to 0 ... 255.
void stretch(ScalarField& picture, float offset, float high) {
  const float scale = high > offset ? 255.0F / (high - offset) : 0.0F;
  for (float& value : picture.values) {
    value = (value - offset) * scale;
  }
}

ScalarField read_picture(TomlReader& image, const Files& file, const ReadOptions& options) {
  ScalarField picture = read_scalar(file(image.text("picture")), options).pixels;
  if (!image.has("picture_range")) {
    stretch(picture);
    return picture;
  }
  const auto range = image.pair("picture_range");
  if (!(range[0] < range[1])) {
    image.fail("picture_range", "must be [black, white] with black < white");
  }
  stretch(picture, static_cast<float>(range[0]), static_cast<float>(range[1]));
  return picture;
}

} // namespace

std::optional<double> read_spacing(TomlReader& scene) {
  const std::optional<double> spacing = scene.optional_number("spacing");
  if (spacing && !(*spacing > 0.0 && std::isfinite(*spacing))) {
    scene.fail("spacing", "must be positive (millimetres per pixel)");
  }
  return spacing;
}

void require_possible_displacement(const TomlReader& table, std::string_view key, double displacement) {
  constexpr double largest = 1e9;
  if (std::isfinite(displacement) && std::abs(displacement) > largest) {
    table.fail(key, fmt::format("has a displacement of {:g} pixels; at most {:g} are possible", displacement,
                                largest));
  }
}

SceneText text_of(const std::string& scene) {
  const auto* const shipped = std::ranges::find(scene_texts::all, scene, &scene_texts::Text::name);
  if (shipped != scene_texts::all.end()) {
    return {scene, scene + ".toml", {}, std::string(shipped->text)};
  }
  const std::filesystem::path path(scene);
  if (!std::filesystem::exists(path)) {
    throw MissingFile(fmt::format("there is no scene and no file \"{}\"; the shipped scenes are {}", scene,
                                  fmt::join(shipped_scenes(), ", ")));
  }
  return {path.stem().string(), scene, path.parent_path(), read_file(path)};
}

std::vector<std::filesystem::path> files_of_scene(const std::string& scene) {
  std::vector<std::filesystem::path> files{scene};
  try {
    const SceneText file = text_of(scene);
    const toml::table root = toml::parse(file.text);
    for (const std::string_view table : {"image", "brain"}) {
      if (const toml::table* const names = root[table].as_table()) {
        for (const auto& [key, value] : *names) {
          if (const auto* const name = value.as_string()) {
            files.push_back(file.folder / name->get());
          }
        }
      }
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

void require_filled(const TomlReader& image, std::string_view key, bool is_padded, Extent size) {
  if (is_padded) {
    image.fail(key,
               fmt::format("does not fill {} x {} pixels, which have another aspect, and beside the image 0 "
                           "means nothing; give a size with the image's own aspect",
                           size.width, size.height));
  }
}

void require_extent(TomlReader& table, std::string_view key, Extent found, Extent wanted) {
  if (found != wanted) {
    table.fail(key, fmt::format("is {} x {}, the scene is {} x {}", found.width, found.height, wanted.width,
                                wanted.height));
  }
}

void stretch(ScalarField& picture) {
  const auto [low, high] = std::ranges::minmax_element(picture.values);
  stretch(picture, *low, *high);
}

Content read_image_content(TomlReader& image, TomlReader& scene, const Files& file,
                           std::optional<Extent> size) {
  Content content;
  ReadOptions options{.size = size, .spacing = read_spacing(scene)};
  if (image.has("slice")) {
    options.slice = image.integer("slice");
  }
  if (image.has("labels") == image.has("modulus")) {
    image.fail("labels", "or modulus: give exactly one of the two images");
  }
  if (image.has("labels")) {
    auto labels = read_labels(file(image.text("labels")), options);
    const bool shown = !image.has("picture");
    const auto tissues = read_tissues(scene, shown);
    require_filled(image, "labels", labels.padded && !tissues.contains(0), labels.pixels.extent);
    content.labels = std::move(labels.pixels);
    content.spacing = labels.spacing;
    content.placement = labels.placement;
    content.segmented = true;
    assign_tissues(scene, tissues, content, shown);
  } else {
    auto modulus = read_scalar(file(image.text("modulus")), options);
    require_filled(image, "modulus", modulus.padded, modulus.pixels.extent);
    content.modulus = std::move(modulus.pixels);
    content.spacing = modulus.spacing;
    content.placement = modulus.placement;
    content.labels = {content.modulus.extent, std::vector<int>(content.modulus.extent.sites(), 1)};
    if (is_inspected(content.modulus.extent)) {
      content.picture = content.modulus;
      stretch(content.picture);
    }
  }
  if (image.has("picture")) {
    content.picture = read_picture(image, file, options);
    require_extent(image, "picture", content.picture.extent, content.modulus.extent);
    if (!is_inspected(content.picture.extent)) {
      content.picture = {};
    }
  }
  return content;
}

Content read_brain_content(TomlReader& brain, TomlReader& scene, const Files& file, Extent size,
                           const SceneOptions& options) {
  const auto tissues = read_tissues(scene, false);
  const std::string name = brain.text("file");
  auto orientation = static_cast<Orientation>(brain.choice("orientation", orientation_names, 0));
  std::optional<int> slice = brain.integer("slice");
  if (!options.orientation.empty()) {
    const auto* const found = std::ranges::find(orientation_names, options.orientation);
    if (found == orientation_names.end()) {
      throw InputError(fmt::format("there is no orientation \"{}\", there are {}", options.orientation,
                                   fmt::join(orientation_names, ", ")));
    }
    orientation = static_cast<Orientation>(found - orientation_names.begin());
    slice = options.slice;
  }
  const int classes = brain.integer("classes");
  const double margin = brain.number("margin");
  if (classes < 1 || classes > 8) {
    brain.fail("classes", "must be 1 ... 8");
  }
  if (!(margin >= 0.0 && margin < 0.5)) {
    brain.fail("margin", "must be at least 0 and below 0.5");
  }
  brain.finish();
  BrainSlice found = read_brain(file(name), slice, classes, margin, size, orientation);
  Content content{.labels = std::move(found.tissue),
                  .modulus = {},
                  .picture = std::move(found.picture),
                  .spacing = found.spacing,
                  .placement = found.placement,
                  .segmented = true};
  assign_tissues(scene, tissues, content, false);
  return content;
}

Content read_shapes_content(TomlReader& scene, Extent size) {
  Content content{.labels = paint_shapes(scene, size), .modulus = {}, .picture = {}, .segmented = true};
  assign_tissues(scene, read_tissues(scene, true), content, true);
  return content;
}

} // namespace hdmbench
