#include "harness/cli/arguments.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"

#include <algorithm>
#include <array>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

const Option<std::vector<fs::path>> images("images", "Pictures, or with --labels segmentations");
const Option<fs::path> transform("--transform", "What run --transform wrote: .h5, .nrrd, .mha or .nii.gz");
const Option<bool> labels("--labels", "Take the nearest pixel, not a mean of several");

/// Returns what an image is called when it has moved: "t1.nrrd" of "t1.nii.gz".
std::string moved_name(const fs::path& image, const std::string& ending) {
  fs::path name = image.filename();
  if (name.extension() == ".gz") {
    name.replace_extension();
  }
  return fmt::format("{}.{}", name.stem().string(), ending);
}

int warp_images(Call& call) {
  std::vector<std::string> files;
  for (const fs::path& image : call[images]) {
    files.push_back(moved_name(image, call[option::format]));
    if (const auto other = std::ranges::find(files, files.back()); other != files.end() - 1) {
      throw InputError(fmt::format("{} and {} would both become {}: call warp for each of them",
                                   call[images][static_cast<std::size_t>(other - files.begin())].string(),
                                   image.string(), files.back()));
    }
  }
  std::vector<fs::path> read = call[images];
  read.push_back(call[transform]);
  require_folder(call[option::output], files, read);
  Progress progress;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const fs::path& image = call[images][i];
    progress.describe(fmt::format("warp {}", image.string()));
    write_moved(call[option::output] / files[i], image, call[transform], call[labels]);
    progress.clear();
    fmt::print("{}: {}, moved\n", (call[option::output] / files[i]).string(), image.string());
  }
  return success;
}

} // namespace

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
