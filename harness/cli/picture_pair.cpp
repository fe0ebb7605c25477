#include "harness/cli/picture_pair.hpp"

#include "harness/applications/picture.hpp"

#include <cmath>

namespace hdmbench::commands {

namespace fs = std::filesystem;

namespace {

/// It lies where its file says, or else where the scene does. Throws InputError where these are two places,
/// or where it is not that of `other`, if there is one.
Image<ScalarField> read_picture(const fs::path& file, const Scene& scene,
                                const Image<ScalarField>* other = nullptr) {
  Image<ScalarField> image = read_scalar(file);
  const auto grid_of = [](Extent extent, double spacing, const Placement& placement, Stated stated) {
    return FileGrid{extent, {spacing, spacing, spacing}, placement, stated};
  };
  const Extent extent = image.pixels.extent;
  if (extent != scene.extent()) {
    throw InputError(fmt::format("{} is {} pixels, the scene {} is {}; crop or resample one of them",
                                 file.string(), extent.text(), scene.name, scene.extent().text()));
  }
  const FileGrid own = grid_of(extent, image.spacing, image.placement, image.grid.stated);
  std::string difference =
      difference_between(own, grid_of(extent, scene.spacing, scene.placement, scene.stated),
                         fmt::format("the scene {}", scene.name));
  if (difference.empty() && other != nullptr) {
    difference = difference_between(
        own, grid_of(extent, other->spacing, other->placement, other->grid.stated), "the source");
  }
  if (!difference.empty()) {
    throw InputError(fmt::format("{} {}", file.string(), difference));
  }
  if (image.grid.stated == Stated::nothing) {
    image.spacing = scene.spacing;
    image.placement = scene.placement;
  }
  return image;
}

/// Bright parts of both somewhere at the same place.
void require_overlap(const ScalarField& source, const ScalarField& target) {
  const auto bright_of = [](const ScalarField& picture) {
    const auto [low, high] = std::ranges::minmax(picture.values);
    return low + 0.2F * (high - low);
  };
  const float bright_source = bright_of(source);
  const float bright_target = bright_of(target);
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    if (source.values[site] > bright_source && target.values[site] > bright_target) {
      return;
    }
  }
  throw InputError("registration: the two pictures do not overlap, nothing bright is at one place in both; "
                   "align them first");
}

const Option<fs::path> source_file("source", "The picture before, as the scene's labels have it",
                                   Content::image);
const Option<fs::path> target_file("target", "The picture after, of the same size and spacing",
                                   Content::image);
const Option<std::string>
    scene_name("--scene", "Scene by name or TOML file: labels of the source, moduli, energy", Content::toml);
const Option<fs::path>
    region_file("--roi", "Mask of the region of interest, not 0 inside: there the pictures are not believed",
                Content::labels);

} // namespace

Options pair_options(const Options& schedule) {
  return {source_file,
          target_file,
          scene_name,
          region_file,
          Options(option::size, "Size of the scene: 300 (square) or 257x130"),
          option::orientation,
          option::slice,
          schedule,
          backend_options(),
          option::output,
          option::json};
}

PictureData load_pictures(const Call& call) {
  PictureData data;
  data.scene = scene_of(call, scene_name);
  if (data.scene.labels.values.empty() ||
      std::ranges::count(data.scene.labels.values, data.scene.labels.values.front()) ==
          std::ssize(data.scene.labels.values)) {
    throw InputError(
        fmt::format("the scene {} has no labels, or one label everywhere: give it [image] labels "
                    "and a [[tissue]] with a modulus for each",
                    data.scene.name));
  }
  Image<ScalarField> before = read_picture(call[source_file], data.scene);
  data.target = read_picture(call[target_file], data.scene, &before).pixels;
  data.source = before.pixels;
  data.placement = before.placement;
  require_pair(data.source, data.target);
  require_overlap(data.source, data.target);
  const auto [low_source, high_source] = std::ranges::minmax(data.source.values);
  const auto [low_target, high_target] = std::ranges::minmax(data.target.values);
  const float low = std::min(low_source, low_target);
  const float scale = 255.0F / (std::max(high_source, high_target) - low);
  for (ScalarField* const picture : {&data.source, &data.target}) {
    for (float& gray : picture->values) {
      gray = (gray - low) * scale;
    }
  }
  if (!call[region_file].empty()) {
    data.region = read_picture(call[region_file], data.scene, &before).pixels;
    std::size_t inside = 0;
    for (std::size_t site = 0; site < data.region.values.size(); ++site) {
      const float value = data.region.values[site];
      if (!std::isfinite(value)) {
        throw InputError(fmt::format("{}: the mask at {} is {}; give 0 outside the region, 1 inside",
                                     call[region_file].string(), data.region.extent.place(site), value));
      }
      inside += value != 0.0F ? 1U : 0U;
    }
    if (inside == 0 || inside == data.region.values.size()) {
      throw InputError(fmt::format("{}: the region of interest is {}", call[region_file].string(),
                                   inside == 0 ? "empty, every pixel is 0"
                                               : "the whole image; something around it must be known"));
    }
  }
  return data;
}

void require_output(const Call& call, std::span<const std::string> files) {
  std::vector<fs::path> inputs = files_of_scene(call[scene_name]);
  inputs.insert(inputs.end(), {call[source_file], call[target_file], call[region_file]});
  require_folder(call[option::output], files, inputs);
}

fs::path picture_file(json& row, const Call& call, const std::string& name, const char* caption) {
  const std::string file = name + ".png";
  row["pictures"].push_back(
      {{"caption", caption}, {"file", beside(call[option::json], call[option::output], file)}});
  return call[option::output] / file;
}

} // namespace hdmbench::commands
