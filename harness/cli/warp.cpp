#include "harness/cli/warp.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"

#include <algorithm>
#include <array>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

const Option<std::vector<fs::path>> images("images", "Pictures, or with --labels segmentations",
                                           Content::image);
const Option<fs::path> transform("--transform", "What run --transform wrote: .h5, .nrrd, .mha or .nii.gz",
                                 Content::transform);
const Option<bool> labels("--labels", "Take the nearest pixel, not a mean of several");

int warp_images(Call& call) {
  const std::vector<std::string> files = moved_names(call[images], call[option::format]);
  std::vector<fs::path> read = call[images];
  read.push_back(call[transform]);
  require_folder(call[option::output], files, read);
  Progress progress;
  for (std::size_t i = 0; i < files.size(); ++i) {
    fmt::print("{}\n", move_picture(call[option::output] / files[i], call[images][i], call[transform],
                                    call[labels], progress));
  }
  return success;
}

} // namespace

std::vector<std::string> moved_names(std::span<const fs::path> pictures, const std::string& ending) {
  std::vector<std::string> names;
  for (const fs::path& picture : pictures) {
    require_regular_file(picture);
    fs::path name = picture.filename();
    if (name.extension() == ".gz") {
      name.replace_extension();
    }
    names.push_back(fmt::format("{}.{}", name.stem().string(), ending));
    if (const auto other = std::ranges::find(names, names.back()); other != names.end() - 1) {
      throw InputError(fmt::format("{} and {} would both become {}: call warp for each of them",
                                   pictures[static_cast<std::size_t>(other - names.begin())].string(),
                                   picture.string(), names.back()));
    }
  }
  return names;
}

std::string move_picture(const fs::path& file, const fs::path& picture, const fs::path& transform,
                         bool is_labels, Progress& progress) {
  progress.describe(fmt::format("warp {}", picture.string()));
  write_moved(file, picture, transform, is_labels);
  progress.clear();
  return fmt::format("{}: {}, moved", file.string(), picture.string());
}

void add_warp(CLI::App& program, Call& call) {
  add_command(
      program, call, "warp", warp_images,
      "Move pictures as run has moved the tissue.\n"
      "Move pictures by a displacement that leads back, as run --transform writes it, each on its own\n"
      "pixels and in the patient's space, as antsApplyTransforms does; 0 where nothing comes from.",
      {images, transform, labels, option::format, option::output},
      {"images is required", "--transform is required"});
}

} // namespace hdmbench::commands
