#include "harness/cli/picture_pair.hpp"

#include "harness/applications/picture.hpp"
#include "harness/applications/registration.hpp"

namespace hdmbench::commands {

namespace fs = std::filesystem;

namespace {

/// It lies where its file says, or else where the scene does. Throws InputError where these are two places,
/// or where it is not that of `other`, if there is one.
Image<ScalarField> read_picture(const fs::path& file, const Scene& scene,
                                const Image<ScalarField>* other = nullptr) {
  Image<ScalarField> image = read_scalar(file, {.takes_volumes = scene.extent().axes() == 3});
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
  require_labels(data.scene);
  Image<ScalarField> before = read_picture(call[source_file], data.scene);
  data.target = read_picture(call[target_file], data.scene, &before).pixels;
  data.source = before.pixels;
  data.placement = before.placement;
  prepare_pair(data.source, data.target);
  if (!call[region_file].empty()) {
    data.region = read_picture(call[region_file], data.scene, &before).pixels;
    require_region(data.region, call[region_file].string());
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
