#include "harness/cli/run_files.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace hdmbench::commands {

namespace {

constexpr std::array picture_names{"before", "after", "grid", "magnitude", "jacobian", "slices"};

/// Returns the pictures of a scene, of an image those without slices.
std::span<const char* const> pictures_of(const Scene& scene) {
  return std::span(picture_names).first(!is_inspected(scene.extent()) ? 0 : scene.extent().depth > 1 ? 6 : 5);
}

/// A slice across x or y with its last row first: z leads up in the pictures, as heads stand.
ScalarField upright(const ScalarField& slice, const Plane& plane) {
  if (plane.axis == 2) {
    return slice;
  }
  ScalarField turned(slice.extent);
  for (int row = 0; row < slice.extent.height; ++row) {
    std::copy_n(slice.values.data() + slice.extent.index(0, row), slice.extent.width,
                turned.values.data() + slice.extent.index(0, slice.extent.height - 1 - row));
  }
  return turned;
}

/// Writes the pictures; of a volume the planes to show stand beside each other. `files`: as file_names() has
/// them. The row of a volume is told how the slices lie in their picture.
void write_pictures(const std::filesystem::path& folder, std::span<const std::string> files,
                    const Scene& scene, const VectorField& displacement, json& row) {
  const std::vector<Plane> planes = planes_to_show(displacement);
  const auto drawn = [&](const auto& draw) {
    std::vector<ScalarField> slices;
    std::ranges::transform(planes, std::back_inserter(slices),
                           [&](const Plane& plane) { return upright(draw(plane), plane); });
    return side_by_side(slices);
  };
  const auto slices_of = [&](const ScalarField& field) {
    return drawn([&](const Plane& plane) { return slice_of(field, plane); });
  };
  write_png(folder / files[1], slices_of(scene.picture));
  write_png(folder / files[2],
            drawn([&](const Plane& plane) { return warp(scene.picture, displacement, plane); }));
  // The lines of a grid stay in their plane: what leads out of it shows in the magnitude.
  write_png(folder / files[3], drawn([&](const Plane& plane) {
              const VectorField in_plane = slice_of(displacement, plane);
              return warp(grid_picture(in_plane.extent, grid_spacing(scene.extent())), in_plane);
            }));
  const ScalarField magnitude = magnitude_of(displacement);
  write_magnitude_png(folder / files[4], slices_of(magnitude),
                      std::max(double{std::ranges::max(magnitude.values)}, 1e-6));
  // Full blue is a fold, full red a doubled area, or volume.
  const ScalarField change = slices_of(area_change_map(displacement));
  write_signed_png(folder / files[5], change.extent, change.values, 1.0);
  if (scene.extent().depth > 1) {
    const ContactSheet sheet = contact_sheet(scene.picture, displacement);
    write_png(folder / files[6], sheet.picture);
    row["slices"] = with_size({{"at", {planes[2].at, planes[1].at, planes[0].at}}}, sheet.volume);
  }
}

} // namespace

std::vector<std::string> file_names(const Scene& scene, const std::string& extension) {
  std::vector<std::string> names{fmt::format("{}.{}", scene.name, extension)};
  for (const char* const picture : pictures_of(scene)) {
    names.push_back(fmt::format("{}-{}.png", scene.name, picture));
  }
  return names;
}

void write_files(const std::filesystem::path& folder, const std::vector<std::string>& files,
                 const std::filesystem::path& results, const Scene& scene, const VectorField& displacement,
                 json& row) {
  if (!have_images()) {
    fmt::print("  No files are written: this build has no image support (-DHDMBENCH_IMAGES=ON).\n");
    return;
  }
  write_displacement(folder / files[0], displacement, scene.spacing, scene.placement, scene.oblong);
  row["field"] = beside(results, folder, files[0]);
  fmt::print("  {}: the displacement in millimetres\n", (folder / files[0]).string());
  if (is_inspected(scene.extent())) {
    write_pictures(folder, files, scene, displacement, row);
    fmt::print("  beside it {}\n", fmt::join(files.begin() + 1, files.end(), ", "));
  }
  std::size_t next = 1;
  for (const char* const picture : pictures_of(scene)) {
    row["pictures"][picture] = beside(results, folder, files[next++]);
  }
}

} // namespace hdmbench::commands
