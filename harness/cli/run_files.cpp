#include "harness/cli/run_files.hpp"

#include "backends/pieces/cut.hpp"
#include "backends/shared/stopwatch.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

namespace hdmbench::commands {

namespace {

/// Returns what the pictures of a scene are called.
std::vector<std::string> picture_names(const Scene& scene, Pictures drawn) {
  if (drawn == Pictures::none || !is_inspected(scene.extent())) {
    return {};
  }
  std::vector<std::string> names{"before", "after", "grid", "magnitude", "jacobian"};
  if (scene.extent().depth > 1) {
    names.emplace_back("slices");
  }
  if (drawn == Pictures::with_deviation) {
    names.emplace_back("deviation");
  }
  return names;
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

/// A slice of rectangles as squares of their shorter side. `pixel`: Level::sides.
ScalarField in_squares(ScalarField slice, const Plane& plane, const std::array<double, 3>& pixel) {
  const double across = pixel[plane.axis == 0 ? 1 : 0];
  const double down = pixel[plane.axis == 2 ? 1 : 2];
  if (across == 1.0 && down == 1.0) {
    return slice;
  }
  const auto count = [](int sites, double side) {
    return static_cast<int>(std::lround((sites - 1) * side)) + 1;
  };
  ScalarField result({count(slice.extent.width, across), count(slice.extent.height, down)});
  for_each_site(result.extent, [&](int column, int row) {
    result.values[result.extent.index(column, row)] =
        images::linear_at(slice.values, slice.extent, column / across, row / down);
  });
  return result;
}

/// Writes the pictures; of a volume the planes to show stand beside each other. `files`: as file_names() has
/// them; `steps`: the displacement in steps from site to site; `deviation`: its standard deviation, null
/// where the last file is not a picture of it. Returns how the slices of a volume lie in their picture.
json write_pictures(const std::filesystem::path& folder, std::span<const std::string> files,
                    const Scene& scene, const VectorField& displacement, const VectorField& steps,
                    const VectorField* deviation) {
  const ScalarField tissue = tissue_of(scene);
  const ScalarField magnitude = magnitude_of(displacement, tissue);
  const std::vector<Plane> planes = planes_to_show(magnitude);
  const auto drawn = [&](const auto& draw) { return drawn_beside(planes, scene.full.sides, draw); };
  const auto slices_of = [&](const ScalarField& field) {
    return drawn([&](const Plane& plane) { return slice_of(field, plane); });
  };
  write_png(folder / files[1], slices_of(scene.picture));
  write_png(folder / files[2], drawn([&](const Plane& plane) { return warp(scene.picture, steps, plane); }));
  write_png(folder / files[3], drawn([&](const Plane& plane) { return warped_grid(steps, plane); }));
  const auto write_lengths = [&](const std::string& file, const ScalarField& lengths) {
    write_magnitude_png(folder / file, slices_of(lengths),
                        std::max(double{std::ranges::max(lengths.values)}, 1e-6));
  };
  write_lengths(files[4], magnitude);
  if (deviation != nullptr) {
    write_lengths(files.back(), magnitude_of(*deviation, tissue));
  }
  // Full blue is a fold, full red a doubled area, or volume.
  const ScalarField change = drawn([&](const Plane& plane) { return content_change(steps, plane, tissue); });
  write_signed_png(folder / files[5], change.extent, change.values, 1.0);
  if (scene.extent().depth > 1) {
    const ContactSheet sheet = contact_sheet(scene.picture, steps);
    write_png(folder / files[6], sheet.picture);
    return with_size({{"at", {planes[2].at, planes[1].at, planes[0].at}}}, sheet.volume);
  }
  return {};
}

} // namespace

std::vector<std::string> file_names(const Scene& scene, const std::string& extension, Pictures drawn) {
  std::vector<std::string> names{fmt::format("{}.{}", scene.name, extension)};
  for (const std::string& picture : picture_names(scene, drawn)) {
    names.push_back(fmt::format("{}-{}.png", scene.name, picture));
  }
  return names;
}

ScalarField drawn_beside(std::span<const Plane> planes, const std::array<double, 3>& pixel,
                         const std::function<ScalarField(const Plane&)>& draw) {
  std::vector<ScalarField> slices;
  std::ranges::transform(planes, std::back_inserter(slices), [&](const Plane& plane) {
    return upright(in_squares(draw(plane), plane, pixel), plane);
  });
  return side_by_side(slices);
}

ScalarField warped_grid(const VectorField& steps, const Plane& plane) {
  const VectorField in_plane = slice_of(steps, plane);
  return warp(grid_picture(in_plane.extent, grid_spacing(steps.extent)), in_plane);
}

ScalarField content_change(const VectorField& steps, const Plane& plane, const ScalarField& tissue) {
  Box slab = all_of(steps.extent); // the plane with its neighbours
  slab.first[plane.axis] = std::max(0, plane.at - 1);
  slab.end[plane.axis] = std::min(slab.end[plane.axis], plane.at + 2);
  return slice_of(
      area_change_map(part_of(steps, slab), tissue.values.empty() ? ScalarField{} : part_of(tissue, slab)),
      {plane.axis, plane.at - slab.first[plane.axis]});
}

void require_own_name(const std::filesystem::path& file, std::string_view option,
                      const std::filesystem::path& folder, const std::vector<std::string>& names) {
  const auto whole = [](const std::filesystem::path& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path));
  };
  for (const std::string& name : names) {
    if (whole(file) == whole(folder / name)) {
      throw InputError(
          fmt::format("{} is what run writes anyway; give {} another name", file.string(), option));
    }
  }
}

Inverse inverse_of(const Scene& scene, const VectorField& displacement) {
  return invert(displacement, scene.full.sides, tissue_of(scene));
}

Inverse write_inverse(const std::filesystem::path& file, const Scene& scene,
                      const VectorField& displacement) {
  Inverse inverse = inverse_of(scene, displacement);
  write_displacement(file, inverse.displacement, scene.spacing, scene.placement, scene.oblong,
                     Mapping::backward);
  return inverse;
}

FilesOfRun::FilesOfRun(std::filesystem::path folder, std::vector<std::string> files,
                       std::filesystem::path transform, const Scene& scene, const VectorField& displacement,
                       const VectorField* deviation)
    : folder_(std::move(folder)), files_(std::move(files)),
      pictures_of_(picture_names(scene, deviation == nullptr ? Pictures::usual : Pictures::with_deviation)),
      transform_(std::move(transform)) {
  const std::array<double, 3>& pixel = scene.full.sides;
  if (!have_images()) {
    return;
  }
  field_ = std::async(std::launch::async, [&] {
    const Clock clock;
    write_displacement(folder_ / files_[0], displacement, scene.spacing, scene.placement, scene.oblong);
    return clock.seconds();
  });
  if (files_.size() > 1) {
    pictures_ = std::async(std::launch::async, [&, pixel, deviation] {
      const Clock clock;
      const std::optional<VectorField> steps = in_steps(displacement, pixel);
      json slices =
          write_pictures(folder_, files_, scene, displacement, steps ? *steps : displacement, deviation);
      return std::pair(clock.seconds(), std::move(slices));
    });
  }
  if (!transform_.empty()) {
    inverse_ = std::async(std::launch::async, [&] {
      const Clock clock;
      Inverse inverse = write_inverse(transform_, scene, displacement);
      inverse.displacement = {};
      return std::pair(clock.seconds(), std::move(inverse));
    });
  }
}

void FilesOfRun::finish_transform(const std::filesystem::path& results, json& row) {
  const auto [seconds, inverse] = inverse_.get();
  row["phases"]["transform_seconds"] = seconds;
  row["transform"] = {{"file", beside(results, transform_.parent_path(), transform_.filename())},
                      {"unmet", inverse.unmet},
                      {"farthest", inverse.farthest}};
  fmt::print(
      "  {}: leads back, so that resamplers move pictures with it: hdmbench warp IMAGE --transform {}\n",
      transform_.string(), transform_.string());
  if (inverse.unmet > 0) {
    fmt::print("  at {} sites it leads elsewhere, up to {:.2g} pixels at {}: the image folds over there\n",
               inverse.unmet, inverse.farthest, fmt::join(inverse.at, ", "));
  }
}

void FilesOfRun::finish(const std::filesystem::path& results, json& row) {
  if (!have_images()) {
    fmt::print("  No files are written: this build has no image support (-DHDMBENCH_IMAGES=ON).\n");
    return;
  }
  row["phases"]["writing_seconds"] = field_.get();
  row["field"] = beside(results, folder_, files_[0]);
  fmt::print("  {}: the displacement in millimetres\n", (folder_ / files_[0]).string());
  if (pictures_.valid()) {
    auto [seconds, slices] = pictures_.get();
    row["phases"]["pictures_seconds"] = seconds;
    if (!slices.is_null()) {
      row["slices"] = std::move(slices);
    }
    fmt::print("  beside it {}\n", fmt::join(files_.begin() + 1, files_.end(), ", "));
    for (std::size_t i = 1; i < files_.size(); ++i) {
      row["pictures"][pictures_of_[i - 1]] = beside(results, folder_, files_[i]);
    }
  }
  if (inverse_.valid()) {
    finish_transform(results, row);
  }
}

} // namespace hdmbench::commands
