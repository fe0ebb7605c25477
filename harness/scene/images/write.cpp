#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"

#include "kernels/data/level.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

namespace hdmbench {

namespace {

using images::unwritable;

constexpr const char* forward_mapping = "forward: tissue at x moves to x + d(x)";

images::Geometry geometry_of(const std::filesystem::path& file, Extent extent, std::size_t components,
                             double spacing, const Placement& placement) {
  if (!(spacing > 0.0) || !std::isfinite(spacing)) {
    throw unwritable(file, fmt::format("a pixel of {} mm", spacing));
  }
  return {.size = extent.sides(),
          .spacing = {spacing * placement.aspect[0], spacing * placement.aspect[1],
                      placement.thickness > 0.0 ? placement.thickness : spacing * placement.aspect[2]},
          .origin = placement.origin,
          .axes = placement.axes,
          .components = components};
}

using Colour = std::array<double, 3>; ///< red, green, blue, 0 ... 255

Colour mixed(const Colour& a, const Colour& b, double share) {
  return {std::lerp(a[0], b[0], share), std::lerp(a[1], b[1], share), std::lerp(a[2], b[2], share)};
}

/// From black by violet, red and orange to light yellow: the brightness rises all the way, so that the order
/// shows in grey and to the colour-blind as well. Equal distances in `fraction`, 0 ... 1.
Colour colour_of(double fraction) {
  constexpr std::array<Colour, 7> ramp{{{0, 0, 0},
                                        {40, 11, 84},
                                        {110, 25, 110},
                                        {180, 45, 85},
                                        {230, 95, 40},
                                        {250, 165, 25},
                                        {255, 250, 175}}};
  const double position = std::clamp(fraction, 0.0, 1.0) * (ramp.size() - 1);
  const std::size_t from = std::min(static_cast<std::size_t>(position), ramp.size() - 2);
  return mixed(ramp[from], ramp[from + 1], position - static_cast<double>(from));
}

/// Not a number becomes 0.
unsigned char to_byte(double gray) {
  return static_cast<unsigned char>(std::lround(gray > 0.0 ? std::min(gray, 255.0) : 0.0));
}

/// `colour` gives the colour of a site by its index.
template <typename SiteColour>
void write_colours(const std::filesystem::path& file, Extent extent, const SiteColour& colour) {
  std::vector<unsigned char> bytes(3 * extent.sites());
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    std::ranges::transform(colour(site), &bytes[3 * site], to_byte);
  }
  images::write_pixels(file, geometry_of(file, extent, 3, 1.0, {}), bytes);
}

} // namespace

images::Pixels physical_displacement(const std::filesystem::path& file, const VectorField& displacement,
                                     double spacing, const Placement& placement,
                                     const std::optional<FileGrid>& grid) {
  const Extent sites = displacement.extent;
  validate(displacement, sites, "the displacement to write");
  images::Geometry geometry = geometry_of(file, sites, 3, spacing, placement);
  PixelPositions at; // the grid's pixels, in sites
  if (grid) {
    geometry = geometry_of(file, grid->extent, 3, grid->sides[0], grid->placement);
    std::copy_n(grid->sides.begin(), sites.axes(), geometry.spacing.begin());
    at = positions_of(*grid, spacing, placement);
  }
  std::vector<float> values;
  values.reserve(geometry.values());
  for_each_site(grid ? grid->extent : sites, [&](int x, int y, int z) {
    Placement::Vector way{}; // millimetres along rows, columns and slices
    for (std::size_t axis = 0; axis < sites.axes(); ++axis) {
      way[axis] = spacing *
                  (grid ? images::linear_at(displacement[axis], sites, at.of(0, x), at.of(1, y), at.of(2, z))
                        : displacement[axis][sites.index(x, y, z)]);
    }
    for (const double component : placement.vector(way[0], way[1], way[2])) {
      values.push_back(images::with_zero_positive(component));
    }
  });
  return {geometry, std::move(values)};
}

void write_displacement(const std::filesystem::path& file, const VectorField& displacement, double spacing,
                        const Placement& placement, const std::optional<FileGrid>& grid, Mapping mapping) {
  auto [geometry, values] = physical_displacement(file, displacement, spacing, placement, grid);
  if (images::is_transform(file)) {
    images::write_transform(file, geometry, values);
    return;
  }
  // Who opens the file must be told. Slicer knows the third key, and takes NIfTI and .h5 for the second way.
  const bool is_forward = mapping == Mapping::forward;
  images::write_pixels(
      file, geometry, std::move(values),
      {{"hdmbench mapping", is_forward ? forward_mapping : "backward: what is at y came from y + d(y)"},
       {"hdmbench unit", "millimetre"},
       {"displacement field type", is_forward ? "modeling" : "resampling"}});
}

void require_displacement_name(const std::filesystem::path& file, Extent extent) {
  const std::string name = file.filename();
  const bool is_nifti = name.ends_with(".nii.gz");
  if (!is_nifti && !name.ends_with(".nrrd") && !name.ends_with(".mha") && !images::is_transform(file)) {
    throw unwritable(file, "the name of a displacement must end in .nrrd, .mha, .nii.gz or .h5");
  }
  if (is_nifti && extent.axes() == 2) {
    throw unwritable(file, "NIfTI is for volumes: programs read a file of one slice without its place in "
                           "space; take .nrrd, .mha or .h5");
  }
}

namespace {

bool is_short(float value) {
  return value == std::floor(value) && std::abs(value) <= std::numeric_limits<std::int16_t>::max();
}

} // namespace

void move_pixels(const std::filesystem::path& file, const images::Pixels& displacement, bool of_labels,
                 images::Pixels& image) {
  if (image.geometry.components != 1) {
    throw images::unreadable(
        file, fmt::format("it has {} components per pixel, 1 can be moved", image.geometry.components));
  }
  images::resample(displacement, of_labels, image);
}

void write_moved(const std::filesystem::path& file, images::Pixels image, bool of_labels) {
  if (of_labels && std::ranges::all_of(image.values, is_short)) {
    images::write_pixels(file, image.geometry,
                         std::vector<std::int16_t>(image.values.begin(), image.values.end()));
  } else {
    images::write_pixels(file, image.geometry, std::move(image.values));
  }
}

void write_moved(const std::filesystem::path& file, const std::filesystem::path& image,
                 const std::filesystem::path& transform, bool of_labels) {
  const images::Pixels displacement = images::read_pixels(transform);
  if (displacement.geometry.components != 3) {
    throw images::unreadable(transform, "a displacement has 3 components per pixel");
  }
  std::string header(4096, '\0');
  std::ifstream(transform, std::ios::binary).read(header.data(), std::ssize(header));
  if (header.find(forward_mapping) != std::string::npos) {
    images::remark(transform,
                   "is the displacement of the tissue itself: as a transform it moves what was seen after "
                   "back to before; run --transform writes the other way");
  }
  images::Pixels pixels = images::read_pixels(image);
  move_pixels(image, displacement, of_labels, pixels);
  write_moved(file, std::move(pixels), of_labels);
}

void write_scalar(const std::filesystem::path& file, const ScalarField& field, double spacing,
                  const Placement& placement) {
  images::write_pixels(file, geometry_of(file, field.extent, 1, spacing, placement), field.values);
}

void write_vector(const std::filesystem::path& file, const VectorField& field, double spacing,
                  const Placement& placement) {
  std::vector<float> values;
  const std::size_t axes = field.extent.axes();
  for (std::size_t site = 0; site < field.extent.sites(); ++site) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      values.push_back(field[axis][site]);
    }
  }
  images::write_pixels(file, geometry_of(file, field.extent, axes, spacing, placement), std::move(values));
}

void write_labels(const std::filesystem::path& file, const LabelField& labels, double spacing,
                  const Placement& placement) {
  std::vector<std::int16_t> values;
  for (const int label : labels.values) {
    if (!std::in_range<std::int16_t>(label)) {
      throw unwritable(file, fmt::format("the label {} is beyond 16 bits", label));
    }
    values.push_back(static_cast<std::int16_t>(label));
  }
  images::write_pixels(file, geometry_of(file, labels.extent, 1, spacing, placement), values);
}

void write_png(const std::filesystem::path& file, const ScalarField& picture) {
  std::vector<unsigned char> bytes(picture.values.size());
  std::ranges::transform(picture.values, bytes.begin(), to_byte);
  images::write_pixels(file, geometry_of(file, picture.extent, 1, 1.0, {}), bytes);
}

void write_magnitude_png(const std::filesystem::path& file, const ScalarField& magnitude, double largest) {
  write_colours(file, magnitude.extent, [&](std::size_t site) {
    const double length = magnitude.values[site];
    return colour_of(length > 0.0 ? length / largest : 0.0);
  });
}

void write_signed_png(const std::filesystem::path& file, Extent extent, std::span<const float> values,
                      double largest, const ScalarField& picture) {
  if (values.size() != extent.sites() || (!picture.values.empty() && picture.extent != extent) ||
      !std::ranges::all_of(values, [](float v) { return std::isfinite(v); })) {
    throw unwritable(file, "the values are not finite or not one per site");
  }
  const bool is_over_picture = !picture.values.empty();
  write_colours(file, extent, [&](std::size_t site) {
    const double fraction = std::clamp(static_cast<double>(values[site]) / largest, -1.0, 1.0);
    const Colour end = fraction < 0.0 ? Colour{20, 70, 180} : Colour{180, 30, 30};
    const double gray =
        is_over_picture ? std::clamp(static_cast<double>(picture.values[site]), 0.0, 255.0) : 255.0;
    // Some of the picture is seen through the strongest colour.
    return mixed({gray, gray, gray}, end, (is_over_picture ? 0.7 : 1.0) * std::abs(fraction));
  });
}

} // namespace hdmbench
