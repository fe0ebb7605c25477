#include "harness/cli/arguments.hpp"

#include "harness/applications/picture.hpp"
#include "harness/scene/images/images.hpp"

#include <cmath>
#include <utility>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

constexpr double same_spacing = 0.01; // of a pixel: rounding in file headers

void require_same(const fs::path& file, Extent extent, double spacing, const Scene& scene) {
  if (extent != scene.extent()) {
    throw InputError(fmt::format("{} is {} pixels, the scene {} is {}; crop or resample one of them",
                                 file.string(), size_text(extent), scene.name, size_text(scene.extent())));
  }
  if (std::abs(spacing - scene.spacing) > same_spacing * scene.spacing) {
    throw InputError(
        fmt::format("{} has pixels of {:.4g} mm, the scene {} of {:.4g} mm; resample one of them",
                    file.string(), spacing, scene.name, scene.spacing));
  }
}

/// PNG and JPEG say nothing about millimetres.
bool has_no_spacing(const fs::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

/// It lies where its file says, or else where the scene does.
Image<ScalarField> read_picture(const fs::path& file, const Scene& scene) {
  Image<ScalarField> image = read_scalar(file);
  if (has_no_spacing(file)) {
    image.spacing = scene.spacing;
    image.placement = scene.placement;
  }
  require_same(file, image.pixels.extent, image.spacing, scene);
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

} // namespace

void PairArguments::add_to(CLI::App& command, Call& call, bool detects) {
  add_option(command, "source", source, "The picture before, as the scene's labels have it")->required();
  add_option(command, "target", target, "The picture after, of the same size and spacing")->required();
  add_option(command, "--scene", scene.scene,
             "Scene by name or TOML file: labels of the source, moduli, energy")
      ->required();
  add_option(command, "--roi", region,
             "Mask of the region of interest, not 0 inside: there the pictures are not believed")
      ->required(detects);
  add_option(command, "--size", scene.size, "Size of the scene: 300 (square) or 257x130");
  scene.add_orientation_to(command);
  scene.schedule.takes_energy = true;
  if (!detects) {
    scene.schedule.add_to(command);
  }
  scene.add_backend_to(command);
  add_output_folder(command, output);
  add_json(command, call);
}

PictureData PairArguments::load() const {
  PictureData data;
  data.scene = scene.load();
  if (data.scene.labels.values.empty() ||
      std::ranges::count(data.scene.labels.values, data.scene.labels.values.front()) ==
          std::ssize(data.scene.labels.values)) {
    throw InputError(
        fmt::format("the scene {} has no labels, or one label everywhere: give it [image] labels "
                    "and a [[tissue]] with a modulus for each",
                    data.scene.name));
  }
  Image<ScalarField> before = read_picture(source, data.scene);
  data.source = std::move(before.pixels);
  data.placement = before.placement;
  data.target = read_picture(target, data.scene).pixels;
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
  if (!region.empty()) {
    data.region = read_picture(region, data.scene).pixels;
    std::size_t inside = 0;
    for (std::size_t site = 0; site < data.region.values.size(); ++site) {
      const float value = data.region.values[site];
      const auto width = static_cast<std::size_t>(data.region.extent.width);
      if (!std::isfinite(value)) {
        throw InputError(
            fmt::format("{}: the mask at x = {}, y = {} is {}; give 0 outside the region, 1 inside",
                        region.string(), site % width, site / width, value));
      }
      inside += value != 0.0F ? 1U : 0U;
    }
    if (inside == 0 || inside == data.region.values.size()) {
      throw InputError(fmt::format("{}: the region of interest is {}", region.string(),
                                   inside == 0 ? "empty, every pixel is 0"
                                               : "the whole image; something around it must be known"));
    }
  }
  return data;
}

void PairArguments::require_output(std::span<const std::string> files) const {
  std::vector<fs::path> inputs = files_of_scene(scene.scene);
  inputs.insert(inputs.end(), {source, target, region});
  require_folder(output, files, inputs);
}

fs::path Pictures::file(const std::string& name, const std::string& caption) {
  written_.push_back({{"caption", caption}, {"file", beside(results_, folder_, name + ".png")}});
  return folder_ / (name + ".png");
}

void Pictures::gray(const std::string& name, const std::string& caption, const ScalarField& picture) {
  write_png(file(name, caption), picture);
}

void Pictures::signed_values(const std::string& name, const std::string& caption, const ScalarField& values,
                             double largest, const ScalarField& ground) {
  write_signed_png(file(name, caption), values.extent, values.values, largest, ground);
}

} // namespace hdmbench::commands
