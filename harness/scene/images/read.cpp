#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/sites.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>
#include <utility>

namespace hdmbench {

namespace {

constexpr double square_tolerance = 0.01; // of a pixel's side: rounding in headers, not another shape

/// Integers up to here survive the reading as float.
constexpr float largest_label = 16777215.0F;

InputError unreadable(const std::filesystem::path& file, std::string_view why) {
  return InputError(fmt::format("cannot read the image {}: {}", file.string(), why));
}

/// One slice of a file, one field per component: one, or of a vector two or three.
Image<std::vector<ScalarField>> read_slice(const std::filesystem::path& file, const ReadOptions& options,
                                           bool is_vector) {
  const std::optional<int> slice = options.slice;
  const images::Pixels pixels = images::read_pixels(file);
  const auto& [size, spacing, origin, axes, components] = pixels.geometry;
  if (is_vector ? components != 2 && components != 3 : components != 1) {
    throw unreadable(file, fmt::format("it has {} components per pixel, {} expected", components,
                                       is_vector ? "2 or 3 are" : "1 is"));
  }
  const int slices = size[2];
  if (!slice && slices > 1) {
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
  Placement placement{.origin = origin, .axes = axes};
  if (slices > 1 || spacing[2] != spacing[0]) { // else a pixel without a depth of its own
    placement.thickness = spacing[2];
  }
  placement = placement.moved(0.0, 0.0, slice.value_or(0) * spacing[2]);
  const Extent extent{size[0], size[1]};
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

using Sampler = float (*)(const ScalarField&, double, double);

/// The pixel whose area a finite position lies in, or the nearest one of the border.
float nearest_at(const ScalarField& field, double x, double y) {
  const double column = std::clamp(std::floor(x + 0.5), 0.0, field.extent.width - 1.0);
  const double row = std::clamp(std::floor(y + 0.5), 0.0, field.extent.height - 1.0);
  return field.values[field.extent.index(static_cast<int>(column), static_cast<int>(row))];
}

/// Resamples every component to `size`, if it is given.
void fit(Image<std::vector<ScalarField>>& image, std::optional<Extent> size, Sampler sample_at) {
  const Extent from = image.pixels.front().extent;
  if (!size || *size == from) {
    return;
  }
  const double step = std::max(double(from.width) / size->width, double(from.height) / size->height);
  const auto position = [step](int pixel, int count, int of) {
    return (pixel + 0.5 - 0.5 * count) * step + 0.5 * of - 0.5;
  };
  for (ScalarField& component : image.pixels) {
    ScalarField resampled(*size);
    for_each_site(*size, [&](int column, int row) {
      const double x = position(column, size->width, from.width);
      const double y = position(row, size->height, from.height);
      if (x >= -0.5 && x <= from.width - 0.5 && y >= -0.5 && y <= from.height - 0.5) {
        resampled.values[size->index(column, row)] = sample_at(component, x, y);
      } else {
        image.padded = true;
      }
    });
    component = std::move(resampled);
  }
  image.placement = image.placement.moved(image.spacing * position(0, size->width, from.width),
                                          image.spacing * position(0, size->height, from.height));
  image.spacing *= step;
}

} // namespace

Image<LabelField> read_labels(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_slice(file, options, false);
  const ScalarField& stored = image.pixels.front();
  const auto wrong = std::ranges::find_if_not(stored.values, [](float value) {
    return std::abs(value) <= largest_label && value == std::floor(value);
  });
  if (wrong != stored.values.end()) {
    const auto site = wrong - stored.values.begin();
    throw unreadable(
        file, fmt::format("the pixel at x = {}, y = {} is {}, labels are integers of magnitude up to {}",
                          site % stored.extent.width, site / stored.extent.width, *wrong, largest_label));
  }
  fit(image, options.size, nearest_at);
  const ScalarField& fitted = image.pixels.front();
  LabelField labels{fitted.extent, std::vector<int>(fitted.values.size())};
  std::ranges::transform(fitted.values, labels.values.begin(),
                         [](float value) { return static_cast<int>(value); });
  return {std::move(labels), image.spacing, image.placement, image.padded};
}

Image<ScalarField> read_scalar(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_slice(file, options, false);
  fit(image, options.size, images::linear_at);
  return {std::move(image.pixels.front()), image.spacing, image.placement, image.padded};
}

Image<VectorField> read_vector(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_slice(file, options, true);
  fit(image, options.size, images::linear_at);
  VectorField field;
  field.extent = image.pixels[0].extent;
  field[0] = std::move(image.pixels[0].values);
  field[1] = std::move(image.pixels[1].values);
  return {std::move(field), image.spacing, image.placement, image.padded};
}

Image<VectorField> read_displacement(const std::filesystem::path& file) {
  const auto image = read_slice(file, {}, true);
  Image<VectorField> result{VectorField(image.pixels[0].extent), image.spacing, image.placement};
  const auto& axes = image.placement.axes;
  for (std::size_t site = 0; site < result.pixels[0].size(); ++site) {
    double x = 0.0;
    double y = 0.0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const double component = image.pixels[i].values[site];
      x += axes[0][i] * component;
      y += axes[1][i] * component;
    }
    result.pixels[0][site] = static_cast<float>(x / image.spacing);
    result.pixels[1][site] = static_cast<float>(y / image.spacing);
  }
  return result;
}

} // namespace hdmbench
