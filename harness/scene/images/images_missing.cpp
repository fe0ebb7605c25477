#include "harness/scene/images/images.hpp"
#include "harness/scene/images/npz.hpp"
#include "harness/scene/images/pixels.hpp"

// The image files of what has no ITK: a build with -DHDMBENCH_IMAGES=OFF, and the installed library.

namespace hdmbench {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& file) {
  throw MissingFile(file.string() +
                    ": no image files are read here; a program reads them that was configured "
                    "with -DHDMBENCH_IMAGES=ON (libinsighttoolkit5-dev), and the installed "
                    "library takes pixels in memory, make_scene()");
}

} // namespace

bool have_images() {
  return false;
}

void read_images_apart(int, const char* const*) {}

images::Pixels images::read_pixels(const std::filesystem::path& file) {
  refuse(file);
}

void images::write_pixels(const std::filesystem::path& file, const Geometry&, const Values&, const Keys&) {
  refuse(file);
}

void images::write_transform(const std::filesystem::path& file, const Geometry&, const std::vector<float>&) {
  refuse(file);
}

void images::resample(const Pixels&, bool, Pixels&) {}

void write_npz(const std::filesystem::path& file, std::span<const NamedArray>) {
  refuse(file);
}

BrainSlice read_brain(const std::filesystem::path& file, std::optional<int>, int, double, Extent,
                      Orientation) {
  refuse(file);
}

BrainSlice read_head(const std::filesystem::path& brain, const std::filesystem::path&, int, double,
                     std::optional<Extent>) {
  refuse(brain);
}

} // namespace hdmbench
