#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/interruption.hpp"
#include "kernels/data/level.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <utility>

namespace hdmbench {

namespace {

using images::unreadable;

constexpr double right_angle = 0.01;    // most cosine between axes: rounding in headers, and little shear
constexpr double most_pixels = 1 << 30; // as of a file
constexpr double most_growth = 200.0;   // of the pixels that become squares or cubes
constexpr double smallest_side = 1e-6;  // of a pixel, millimetres; beyond these a field is not finite
constexpr double largest_side = 1e6;
constexpr double farthest_origin = 1e9; // millimetres

/// Each side of a pixel over the shortest one.
using Aspect = std::array<double, 3>;
constexpr Aspect square{1.0, 1.0, 1.0};

/// Integers up to here survive the reading as float.
constexpr float largest_label = 16777215.0F;

/// Throws InputError where a side of a volume has one voxel, or the directions are no rotation, mirrored or
/// not.
void require_volume(const std::filesystem::path& file, Extent extent, const images::Geometry& geometry) {
  if (std::min({extent.width, extent.height, extent.depth}) < 2) {
    throw unreadable(
        file, fmt::format("a volume of {} voxels is not possible, each side must be at least 2; one slice "
                          "along the third axis is an image",
                          extent.text()));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j) {
      const auto& axes = geometry.axes;
      const double product = std::inner_product(axes[i].begin(), axes[i].end(), axes[j].begin(), 0.0);
      if (!(std::abs(product - (i == j ? 1.0 : 0.0)) <= right_angle)) {
        throw unreadable(file,
                         fmt::format("the directions of its axes are no rotation: the product of axes {} "
                                     "and {} is {:.3g}; resample it",
                                     i + 1, j + 1, product));
      }
    }
  }
}

/// Throws InputError where a pixel's side or its place is none that a body's image has.
void require_possible_place(const std::filesystem::path& file, const images::Geometry& geometry) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (const double side = geometry.spacing[axis]; !(side >= smallest_side && side <= largest_side)) {
      throw unreadable(file, fmt::format("its pixels have a side of {:g} mm, {:g} ... {:g} are possible",
                                         side, smallest_side, largest_side));
    }
    if (const double at = geometry.origin[axis]; !(std::abs(at) <= farthest_origin)) {
      throw unreadable(file, fmt::format("its first pixel lies at {:g} mm, at most {:g} are possible", at,
                                         farthest_origin));
    }
  }
}

/// What the components of a pixel are.
enum class Components {
  scalar,
  vector, ///< 2 or 3
  normal, ///< the same, or 1: a distance that they are the gradient of
  matrix  ///< symmetric, row by row from the diagonal on: 3 or 6
};

/// Throws InputError where a pixel of the file cannot be such.
void require_components(const std::filesystem::path& file, std::size_t found, Components what,
                        bool is_volume) {
  struct Possible {
    std::set<std::size_t> of_image;
    std::set<std::size_t> of_volume;
  };
  const std::map<Components, Possible> possible{{Components::scalar, {{1}, {1}}},
                                                {Components::vector, {{2, 3}, {3}}},
                                                {Components::normal, {{1, 2, 3}, {1, 3}}},
                                                {Components::matrix, {{3, 6}, {6}}}};
  const std::set<std::size_t>& expected =
      is_volume ? possible.at(what).of_volume : possible.at(what).of_image;
  if (!expected.contains(found)) {
    throw unreadable(file, fmt::format("it has {} components per {}, {} {} expected", found,
                                       is_volume ? "voxel" : "pixel", fmt::join(expected, " or "),
                                       expected == std::set<std::size_t>{1} ? "is" : "are"));
  }
}

/// What a file says, as it lies there.
struct Stored {
  Image<std::vector<ScalarField>> image; ///< its spacing is the shortest side of a pixel
  Aspect aspect = square;
};

/// Returns the pixels of the slice, or of the volume, that is asked for. Throws InputError where the file has
/// none such, or no rows and columns at right angles.
Extent extent_to_read(const std::filesystem::path& file, const images::Geometry& geometry,
                      const ReadOptions& options, Components what) {
  const std::optional<int> slice = options.slice;
  const auto& [size, spacing, origin, axes, components, stated] = geometry;
  require_possible_place(file, geometry);
  require_components(file, components, what, false);
  const int slices = size[2];
  const Extent extent{size[0], size[1], slice || !options.takes_volumes ? 1 : slices};
  if (!slice && slices > extent.depth) {
    throw unreadable(file, fmt::format("it is 3-D, choose one of its slices 0 ... {}", slices - 1));
  }
  if (slice && (*slice < 0 || *slice >= slices)) {
    throw unreadable(file,
                     fmt::format("there is no slice {}, it has the slices 0 ... {}", *slice, slices - 1));
  }
  if (const double cosine = std::inner_product(axes[0].begin(), axes[0].end(), axes[1].begin(), 0.0);
      !(std::abs(cosine) <= right_angle)) {
    throw unreadable(file,
                     fmt::format("its rows and columns are not perpendicular, the cosine between them is "
                                 "{:.3g}; resample it",
                                 cosine));
  }
  if (extent.depth > 1) {
    require_volume(file, extent, geometry);
    require_components(file, components, what, true);
  }
  return extent;
}

/// One slice of a file, or the volume, one field per component.
Stored read_pixels(const std::filesystem::path& file, const ReadOptions& options, Components what) {
  const std::optional<int> slice = options.slice;
  const images::Pixels of_file = options.in_memory == nullptr ? images::read_pixels(file) : images::Pixels{};
  const images::Pixels& pixels = options.in_memory == nullptr ? of_file : *options.in_memory;
  images::require_reasonable_number(file, pixels.geometry);
  may_end_here();
  const auto& [size, spacing, origin, axes, components, stated] = pixels.geometry;
  const Extent extent = extent_to_read(file, pixels.geometry, options, what);
  Placement placement{.origin = origin, .axes = axes};
  if (extent.depth == 1 &&
      (size[2] > 1 || spacing[2] != spacing[0])) { // else a pixel without a depth of its own
    placement.thickness = spacing[2];
  }
  placement = placement.moved(0.0, 0.0, slice.value_or(0) * spacing[2]);
  FileGrid grid{extent, spacing, placement, stated};
  if (options.spacing) {
    grid.sides.fill(*options.spacing);
  }
  const float* value =
      pixels.values.data() + static_cast<std::size_t>(slice.value_or(0)) * extent.sites() * components;
  Stored stored{{std::vector(components, ScalarField(extent)), grid.sides[0], placement, false, grid}};
  const auto sides = std::span(grid.sides).first(extent.axes());
  if (std::ranges::count(sides, sides[0]) != std::ssize(sides)) {
    stored.image.oblong = grid;
  }
  constexpr double of_rounding = 1e-3; // of headers; sides that differ by more are boxes
  const auto [least, most] = std::ranges::minmax(sides);
  if (options.takes_boxes && !options.size && !has_equal_sides(grid, of_rounding) &&
      most <= most_oblong * least) {
    stored.image.spacing = least;
    stored.image.oblong.reset();
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      stored.image.placement.aspect[axis] = grid.sides[axis] / stored.image.spacing;
    }
    stored.image.grid.placement = stored.image.placement;
  } else if ((!has_equal_sides(grid) || (options.size && stored.image.oblong)) && !options.as_stored) {
    stored.image.spacing = std::ranges::min(sides);
    std::ranges::transform(sides, stored.aspect.begin(),
                           [&](double side) { return side / stored.image.spacing; });
  }
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    for (ScalarField& component : stored.image.pixels) {
      component.values[site] = *value++;
    }
  }
  return stored;
}

using Sampler = float (*)(const std::vector<float>&, Extent, double, double, double);

/// The pixel whose area a finite position lies in, or the nearest one of the border.
float nearest_at(const std::vector<float>& values, Extent extent, double x, double y, double z) {
  const auto nearest = [](double position, int count) {
    return static_cast<int>(std::clamp(std::floor(position + 0.5), 0.0, count - 1.0));
  };
  return values[extent.index(nearest(x, extent.width), nearest(y, extent.height), nearest(z, extent.depth))];
}

/// Resamples every component to squares or cubes: to `size` of them, if it is given, else where `aspect` is
/// not 1 to as many of the shortest side as fit into the image. Throws InputError where `size` has another
/// number of axes, or there are too many.
void fit(const std::filesystem::path& file, Image<std::vector<ScalarField>>& image,
         std::optional<Extent> size, Sampler sample_at, const Aspect& aspect = square) {
  const Extent from = image.pixels.front().extent;
  if (size.value_or(from) == from && aspect == square) {
    return;
  }
  if (size && size->axes() != from.axes()) {
    throw unreadable(file,
                     fmt::format("{}, and cannot be resampled to {}",
                                 from.axes() == 3 ? "it is a volume" : "it has one slice", size->text()));
  }
  const std::array<int, 3> counts = from.sides();
  std::array<double, 3> lengths{}; // shortest sides
  std::ranges::transform(counts, aspect, lengths.begin(), std::multiplies());
  double step = 1.0; // from one pixel to the next, shortest sides
  if (size) {
    step = 0.0;
    for (std::size_t axis = 0; axis < from.axes(); ++axis) {
      step = std::max(step, lengths[axis] / size->sides()[axis]);
    }
  } else {
    const double most = std::min(most_pixels, most_growth * static_cast<double>(from.sites()));
    if (const double number = lengths[0] * lengths[1] * lengths[2]; number > most) {
      throw unreadable(file, fmt::format("its pixels are {}, and {:.3g} of the shortest side would fill it, "
                                         "{} are possible; give a size",
                                         sides_text(image.grid), number, most));
    }
    const auto whole = [](double length) { return static_cast<int>(length + 1e-6); }; // 3 * 0.1 / 0.3 is 1
    size = Extent{whole(lengths[0]), whole(lengths[1]), whole(lengths[2])};
  }
  const std::array<int, 3> sides = size->sides();
  const auto position = [&](std::size_t axis, int pixel) {
    return (pixel + 0.5 - 0.5 * sides[axis]) * step / aspect[axis] + 0.5 * counts[axis] - 0.5;
  };
  for (ScalarField& component : image.pixels) {
    ScalarField resampled(*size);
    for_each_site(*size, [&](int column, int row, int slice) {
      const double x = position(0, column);
      const double y = position(1, row);
      const double z = from.axes() == 3 ? position(2, slice) : 0.0;
      if (x >= -0.5 && x <= from.width - 0.5 && y >= -0.5 && y <= from.height - 0.5 && z >= -0.5 &&
          z <= from.depth - 0.5) {
        resampled.values[size->index(column, row, slice)] = sample_at(component.values, from, x, y, z);
      } else {
        image.padded = true;
      }
    });
    component = std::move(resampled);
  }
  image.placement = image.placement.moved(
      image.spacing * aspect[0] * position(0, 0), image.spacing * aspect[1] * position(1, 0),
      from.axes() == 3 ? image.spacing * aspect[2] * position(2, 0) : 0.0);
  image.spacing *= step;
}

/// The file's image or volume, resampled to what `options` ask for.
Image<std::vector<ScalarField>> read_fitted(const std::filesystem::path& file, const ReadOptions& options,
                                            Components what) {
  Stored stored = read_pixels(file, options, what);
  fit(file, stored.image, options.size, images::linear_at, stored.aspect);
  return std::move(stored.image);
}

/// The image with other pixels.
template <typename Pixels>
Image<Pixels> with_pixels(const Image<std::vector<ScalarField>>& image, Pixels pixels) {
  return {std::move(pixels), image.spacing, image.placement, image.padded, image.grid, image.oblong};
}

} // namespace

void images::fit_nearest(const std::filesystem::path& file, Image<std::vector<ScalarField>>& image,
                         std::optional<Extent> size) {
  fit(file, image, size, nearest_at);
}

Image<LabelField> read_labels(const std::filesystem::path& file, const ReadOptions& options) {
  auto [image, aspect] = read_pixels(file, options, Components::scalar);
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
  fit(file, image, options.size, nearest_at, aspect);
  const ScalarField& fitted = image.pixels.front();
  LabelField labels{fitted.extent, std::vector<int>(fitted.values.size())};
  std::ranges::transform(fitted.values, labels.values.begin(),
                         [](float value) { return static_cast<int>(value); });
  return with_pixels(image, std::move(labels));
}

Image<ScalarField> read_scalar(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_fitted(file, options, Components::scalar);
  return with_pixels(image, std::move(image.pixels.front()));
}

namespace {

/// Turns physical vectors into pixels of this side, millimetres, along the image's axes.
Image<VectorField> along_axes(const Image<std::vector<ScalarField>>& image, double side) {
  Image<VectorField> result = with_pixels(image, VectorField(image.pixels[0].extent));
  const auto& axes = image.placement.axes;
  for (std::size_t site = 0; site < result.pixels[0].size(); ++site) {
    for (std::size_t axis = 0; axis < result.pixels.extent.axes(); ++axis) {
      double along = 0.0;
      for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        along += axes[axis][i] * double{image.pixels[i].values[site]};
      }
      result.pixels[axis][site] = static_cast<float>(along / side);
    }
  }
  return result;
}

/// Makes vectors of length 1 in the space of what lies there, along the image's axes; 0 stays 0.
Image<VectorField> directions_of(Image<std::vector<ScalarField>> image) {
  for (std::size_t site = 0; site < image.pixels[0].values.size(); ++site) {
    double squared = 0.0;
    for (const ScalarField& component : image.pixels) {
      squared += double{component.values[site]} * double{component.values[site]};
    }
    for (ScalarField& component : image.pixels) {
      float& value = component.values[site];
      value = squared == 0.0 ? 0.0F : static_cast<float>(double{value} / std::sqrt(squared));
    }
  }
  return along_axes(image, 1.0);
}

/// Returns the direction in which a distance grows, along the image's axes, of length 1; 0 where it is level.
Image<VectorField> gradient_of(const Image<std::vector<ScalarField>>& distance) {
  const ScalarField& values = distance.pixels.front();
  const Extent extent = values.extent;
  Image<VectorField> result = with_pixels(distance, VectorField(extent));
  for_each_site(extent, [&](int x, int y, int z) {
    std::array<double, 3> way{};
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      std::array<int, 3> before{x, y, z};
      std::array<int, 3> after = before;
      before[axis] = std::max(before[axis] - 1, 0);
      after[axis] = std::min(after[axis] + 1, extent.sides()[axis] - 1);
      way[axis] = (double{values.values[extent.index(after[0], after[1], after[2])]} -
                   double{values.values[extent.index(before[0], before[1], before[2])]}) /
                  (std::max(after[axis] - before[axis], 1) * distance.grid.sides[axis]);
    }
    const double length = std::hypot(way[0], way[1], way[2]);
    for (std::size_t axis = 0; axis < extent.axes() && length != 0.0; ++axis) {
      result.pixels[axis][extent.index(x, y, z)] = static_cast<float>(way[axis] / length);
    }
  });
  return result;
}

} // namespace

Image<VectorField> read_directions(const std::filesystem::path& file, const ReadOptions& options) {
  return directions_of(read_fitted(file, options, Components::vector));
}

Image<VectorField> read_normals(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_fitted(file, options, Components::normal);
  return image.pixels.size() == 1 ? gradient_of(image) : directions_of(std::move(image));
}

Image<VectorField> read_vector(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_fitted(file, options, Components::vector);
  if (options.physical_side) {
    return along_axes(image, *options.physical_side);
  }
  VectorField field;
  field.extent = image.pixels[0].extent;
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    field[axis] = std::move(image.pixels[axis].values);
  }
  return with_pixels(image, std::move(field));
}

Image<std::vector<ScalarField>> read_matrix(const std::filesystem::path& file, const ReadOptions& options) {
  auto image = read_fitted(file, options, Components::matrix);
  const std::size_t dimensions = image.pixels.size() == 6 ? 3 : 2;
  const std::size_t axes = image.pixels[0].extent.axes();
  if (!options.physical_side && dimensions == axes) {
    return image;
  }
  const std::array<Placement::Vector, 3> to = options.physical_side ? image.placement.axes : Placement{}.axes;
  const double unit = options.physical_side ? *options.physical_side * *options.physical_side : 1.0;
  std::vector<ScalarField> turned(axes * (axes + 1) / 2, ScalarField(image.pixels[0].extent));
  for (std::size_t site = 0; site < turned[0].values.size(); ++site) {
    for (std::size_t a = 0; a < axes; ++a) {
      for (std::size_t b = a; b < axes; ++b) {
        double sum = 0.0;
        for (std::size_t i = 0; i < dimensions; ++i) {
          for (std::size_t j = 0; j < dimensions; ++j) {
            sum += to[a][i] * to[b][j] * double{image.pixels[symmetric_entry(dimensions, i, j)].values[site]};
          }
        }
        turned[symmetric_entry(axes, a, b)].values[site] = static_cast<float>(unit * sum);
      }
    }
  }
  return with_pixels(image, std::move(turned));
}

Image<VectorField> read_displacement(const std::filesystem::path& file, bool takes_volumes) {
  const auto image = read_fitted(file, {.takes_volumes = takes_volumes}, Components::vector);
  return along_axes(image, image.spacing);
}

} // namespace hdmbench
