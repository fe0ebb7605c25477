#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

// The image files of a build without ITK (-DHDMBENCH_IMAGES=OFF).

namespace hdmbench {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& file) {
  throw MissingFile(
      fmt::format("{}: this hdmbench was built without image support; install libinsighttoolkit5-dev "
                  "and configure with -DHDMBENCH_IMAGES=ON",
                  file.string()));
}

} // namespace

bool have_images() {
  return false;
}

void read_images_apart(int, const char* const*) {}

images::Pixels images::read_pixels(const std::filesystem::path& file) {
  refuse(file);
}

BrainSlice read_brain(const std::filesystem::path& file, std::optional<int>, int, double, Extent,
                      Orientation) {
  refuse(file);
}

void write_displacement(const std::filesystem::path& file, const VectorField&, double, const Placement&) {
  refuse(file);
}

void write_scalar(const std::filesystem::path& file, const ScalarField&, double, const Placement&) {
  refuse(file);
}

void write_vector(const std::filesystem::path& file, const VectorField&, double, const Placement&) {
  refuse(file);
}

void write_labels(const std::filesystem::path& file, const LabelField&, double, const Placement&) {
  refuse(file);
}

void write_png(const std::filesystem::path& file, const ScalarField&) {
  refuse(file);
}

void write_magnitude_png(const std::filesystem::path& file, const VectorField&, double) {
  refuse(file);
}

void write_signed_png(const std::filesystem::path& file, Extent, std::span<const float>, double,
                      const ScalarField&) {
  refuse(file);
}

} // namespace hdmbench
