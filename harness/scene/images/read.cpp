#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace hdmbench {

namespace {

using images::unreadable;

constexpr double square_tolerance = 0.01; // of a pixel's side: rounding in headers, not another shape

/// Integers up to here survive the reading as float.
constexpr float largest_label = 16777215.0F;

/// Throws InputError where a volume's voxels are no cubes, a side has one voxel, or the directions are no
/// rotation, mirrored or not.
void require_volume(const std::filesystem::path& file, Extent extent, const images::Geometry& geometry) {
  if (std::min({extent.width, extent.height, extent.depth}) < 2) {
    throw unreadable(
        file, fmt::format("a volume of {} voxels is not possible, each side must be at least 2; one slice "
                          "along the third axis is an image",
                          extent.text()));
  }
  const auto& [x, y, z] = geometry.spacing;
  if (!(std::abs(x - y) <= square_tolerance * x && std::abs(x - z) <= square_tolerance * x)) {
    throw unreadable(file,
                     fmt::format("its voxels are {} mm x {} mm x {} mm, they must be cubes; resample it, "
                                 "or choose one of its slices 0 ... {}",
                                 x, y, z, extent.depth - 1));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j) {
      const auto& axes = geometry.axes;
      const double product = std::inner_product(axes[i].begin(), axes[i].end(), axes[j].begin(), 0.0);
      if (!(std::abs(product - (i == j ? 1.0 : 0.0)) <= square_tolerance)) {
        throw unreadable(file,
                         fmt::format("the directions of its axes are no rotation: the product of axes {} "
                                     "and {} is {:.3g}; resample it",
                                     i + 1, j + 1, product));
      }
    }
  }
}

/// One slice of a file, or the volume, one field per component: one, or of a vector two or three.
Image<std::vector<ScalarField>> read_pixels(const std::filesystem::path& file, const ReadOptions& options,
                                            bool is_vector) {
  const std::optional<int> slice = options.slice;
  const images::Pixels pixels = images::read_pixels(file);
  const auto& [size, spacing, origin, axes, components] = pixels.geometry;
  if (is_vector ? components != 2 && components != 3 : components != 1) {
    throw unreadable(file, fmt::format("it has {} components per pixel, {} expected", components,
                                       is_vector ? "2 or 3 are" : "1 is"));
  }
  const int slices = size[2];
  const Extent extent{size[0], size[1], slice || !options.takes_volumes ? 1 : slices};
  if (!slice && slices > extent.depth) {
    throw unreadable(file, fmt::format("it is 3-D, choose one of its slices 0 ... {}", slices - 1));
  }
  if (slice && (*slice < 0 || *slice >= slices)) {
    throw unreadable(file,
                     fmt::format("there is no slice {}, it has the slices 0 ... {}", *slice, slices - 1));
  }
  if (!(std::abs(spacing[0] - spacing[1]) <= square_tolerance * spacing[0])) {
    throw unreadable(file, fmt::format("its pixels are {} mm x {} mm, they must be square; resample it",
                                       spacing[0], spacing[1]));
  }
  if (const double cosine = std::inner_product(axes[0].begin(), axes[0].end(), axes[1].begin(), 0.0);
      !(std::abs(cosine) <= square_tolerance)) {
    throw unreadable(file,
                     fmt::format("its rows and columns are not perpendicular, the cosine between them is "
                                 "{:.3g}; resample it",
                                 cosine));
  }
  if (extent.depth > 1) {
    require_volume(file, extent, pixels.geometry);
    if (is_vector && components != 3) {
      throw unreadable(file, "it has 2 components per voxel, 3 are expected");
    }
  }
  Placement placement{.origin = origin, .axes = axes};
  if (extent.depth == 1 &&
      (slices > 1 || spacing[2] != spacing[0])) { // else a pixel without a depth of its own
    placement.thickness = spacing[2];
  }
  placement = placement.moved(0.0, 0.0, slice.value_or(0) * spacing[2]);
  const float* value =
      pixels.values.data() + static_cast<std::size_t>(slice.value_or(0)) * extent.sites() * components;
  Image<std::vector<ScalarField>> result{std::vector(components, ScalarField(extent)),
                                         options.spacing.value_or(spacing[0]), placement};
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    for (ScalarField& component : result.pixels) {
      component.values[site] = *value++;
    }
  }
  return result;
}

using Sampler = float (*)(const ScalarField&, double, double, double);

/// The pixel whose area a finite position lies in, or the nearest one of the border.
float nearest_at(const ScalarField& field, double x, double y, double z) {
  const auto nearest = [](double position, int count) {
    return static_cast<int>(std::clamp(std::floor(position + 0.5), 0.0, count - 1.0));
  };
  const Extent extent = field.extent;
  return field
      .values[extent.index(nearest(x, extent.width), nearest(y, extent.height), nearest(z, extent.depth))];
}

/// Resamples every component to `size`, if it is given. Throws InputError where it has another number of
/// axes.
void fit(const std::filesystem::path& file, Image<std::vector<ScalarField>>& image,
         std::optional<Extent> size, Sampler sample_at) {
  const Extent from = image.pixels.front().extent;
  if (!size || *size == from) {
    return;
  }
  if (size->axes() != from.axes()) {
    throw unreadable(file,
                     fmt::format("{}, and cannot be resampled to {}",
                                 from.axes() == 3 ? "it is a volume" : "it has one slice", size->text()));
  }
  const double step = std::max({double(from.width) / size->width, double(from.height) / size->height,
                                from.axes() == 3 ? double(from.depth) / size->depth : 0.0});
  const auto position = [step](int pixel, int count, int of) {
    return (pixel + 0.5 - 0.5 * count) * step + 0.5 * of - 0.5;
  };
  for (ScalarField& component : image.pixels) {
    ScalarField resampled(*size);
    for_each_site(*size, [&](int column, int row, int slice) {
      const double x = position(column, size->width, from.width);
      const double y = position(row, size->height, from.height);
      const double z = from.axes() == 3 ? position(slice, size->depth, from.depth) : 0.0;
      if (x >= -0.5 && x <= from.width - 0.5 && y >= -0.5 && y <= from.height - 0.5 && z >= -0.5 &&
          z <= from.depth - 0.5) {
        resampled.values[size->index(column, row, slice)] = sample_at(component, x, y, z);
      } else {
        image.padded = true;
      }
    });
    component = std::move(resampled);
  }
  image.placement =
      image.placement.moved(image.spacing * position(0, size->width, from.width),
                            image.spacing * position(0, size->height, from.height),
                            from.axes() == 3 ? image.spacing * position(0, size->depth, from.depth) : 0.0);
  image.spacing *= step;
}

} // namespace

void images::fit_nearest(const std::filesystem::path& file, Image<std::vector<ScalarField>>& image,
                         std::optional<Extent> size) {
  fit(file, image, size, nearest_at);
}

Image<LabelField> read_labels(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_pixels(file, options, false);
  const ScalarField& stored = image.pixels.front();
  const auto wrong = std::ranges::find_if_not(stored.values, [](float value) {
    return std::abs(value) <= largest_label && value == std::floor(value);
  });
  if (wrong != stored.values.end()) {
    const auto site = wrong - stored.values.begin();
    throw unreadable(file,
                     fmt::format("the pixel at {} is {}, labels are integers of magnitude up to {}",
                                 stored.extent.place(static_cast<std::size_t>(site)), *wrong, largest_label));
  }
  images::fit_nearest(file, image, options.size);
  const ScalarField& fitted = image.pixels.front();
  LabelField labels{fitted.extent, std::vector<int>(fitted.values.size())};
  std::ranges::transform(fitted.values, labels.values.begin(),
                         [](float value) { return static_cast<int>(value); });
  return {std::move(labels), image.spacing, image.placement, image.padded};
}

Image<ScalarField> read_scalar(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_pixels(file, options, false);
  fit(file, image, options.size, images::linear_at);
  return {std::move(image.pixels.front()), image.spacing, image.placement, image.padded};
}

Image<VectorField> read_vector(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_pixels(file, options, true);
  fit(file, image, options.size, images::linear_at);
  VectorField field;
  field.extent = image.pixels[0].extent;
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    field[axis] = std::move(image.pixels[axis].values);
  }
  return {std::move(field), image.spacing, image.placement, image.padded};
}

Image<VectorField> read_displacement(const std::filesystem::path& file, bool takes_volumes) {
  const auto image = read_pixels(file, {.takes_volumes = takes_volumes}, true);
  Image<VectorField> result{VectorField(image.pixels[0].extent), image.spacing, image.placement};
  const auto& axes = image.placement.axes;
  for (std::size_t site = 0; site < result.pixels[0].size(); ++site) {
    for (std::size_t axis = 0; axis < result.pixels.extent.axes(); ++axis) {
      double along = 0.0;
      for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        along += axes[axis][i] * double{image.pixels[i].values[site]};
      }
      result.pixels[axis][site] = static_cast<float>(along / image.spacing);
    }
  }
  return result;
}

} // namespace hdmbench
