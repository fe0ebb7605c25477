#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/sites.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <itkHistogram.h>
#include <itkOrientImageFilter.h>
#include <itkOtsuMultipleThresholdsCalculator.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

constexpr int most_classes = 4; // multi-Otsu tries every combination of thresholds

InputError unusable(const std::filesystem::path& file, std::string_view why) {
  return InputError(fmt::format("cannot take a brain from the image {}: {}", file.string(), why));
}

/// A slice as the file samples it.
struct Native {
  ScalarField intensity;
  double spacing_x = 1.0; ///< millimetres
  double spacing_y = 1.0;
  Placement placement;
};

using Volume = itk::Image<float, 3>;

/// Right to left, anterior to posterior, inferior to superior.
Volume::Pointer read_volume(const std::filesystem::path& file) {
  const auto [geometry, values] = images::read_pixels(file);
  if (geometry.components != 1) {
    throw unusable(file, fmt::format("it has {} components per pixel, 1 is expected", geometry.components));
  }
  const auto volume = Volume::New();
  Volume::SizeType size;
  Volume::DirectionType direction;
  for (unsigned axis = 0; axis < 3; ++axis) {
    size[axis] = static_cast<itk::SizeValueType>(geometry.size[axis]);
    for (unsigned row = 0; row < 3; ++row) {
      direction(row, axis) = geometry.axes[axis][row];
    }
  }
  volume->SetRegions(size);
  volume->SetSpacing(geometry.spacing.data());
  volume->SetOrigin(geometry.origin.data());
  volume->SetDirection(direction);
  volume->Allocate();
  std::ranges::copy(values, volume->GetBufferPointer());
  const auto orient = itk::OrientImageFilter<Volume, Volume>::New();
  orient->SetInput(volume);
  orient->UseImageDirectionOn();
  orient->SetDesiredCoordinateOrientationToAxial();
  orient->Update();
  return orient->GetOutput();
}

/// Axes of a volume as read_volume gives it: of columns, of rows (the third of them from above) and of
/// slices.
std::array<unsigned, 3> axes_of(Orientation orientation) {
  switch (orientation) {
  case Orientation::coronal:
    return {0, 2, 1};
  case Orientation::sagittal:
    return {1, 2, 0};
  default:
    return {0, 1, 2};
  }
}

Placement placement_of(const Volume& volume, Orientation orientation, int slice) {
  const auto axes = axes_of(orientation);
  Volume::IndexType at = volume.GetLargestPossibleRegion().GetIndex();
  at[axes[2]] += slice;
  const bool from_above = axes[1] == 2;
  if (from_above) {
    at[2] += static_cast<itk::IndexValueType>(volume.GetLargestPossibleRegion().GetSize()[2]) - 1;
  }
  const auto origin = volume.TransformIndexToPhysicalPoint<double>(at);
  Placement placement{.thickness = volume.GetSpacing()[axes[2]]};
  for (unsigned row = 0; row < 3; ++row) {
    placement.origin[row] = origin[row];
    for (unsigned axis = 0; axis < 3; ++axis) {
      const double component = volume.GetDirection()(row, axes[axis]);
      placement.axes[axis][row] = axis == 1 && from_above ? -component : component;
    }
  }
  return placement;
}

Native slice_of(const Volume& volume, Orientation orientation, int slice) {
  const auto size = volume.GetLargestPossibleRegion().GetSize();
  const auto [across, down, through] = axes_of(orientation);
  Native native;
  native.intensity = ScalarField({static_cast<int>(size[across]), static_cast<int>(size[down])});
  native.spacing_x = volume.GetSpacing()[across];
  native.spacing_y = volume.GetSpacing()[down];
  native.placement = placement_of(volume, orientation, slice);
  const Extent extent = native.intensity.extent;
  for_each_site(extent, [&](int x, int y) {
    Volume::IndexType at = volume.GetLargestPossibleRegion().GetIndex();
    at[across] += x;
    at[down] += down == 2 ? extent.height - 1 - y : y;
    at[through] += slice;
    native.intensity.values[extent.index(x, y)] = volume.GetPixel(at);
  });
  return native;
}

/// The slice with the most pixels above 0.
int fullest_slice(const Volume& volume, Orientation orientation, int slices) {
  std::vector<std::ptrdiff_t> counts;
  for (int slice = 0; slice < slices; ++slice) {
    counts.push_back(std::ranges::count_if(slice_of(volume, orientation, slice).intensity.values,
                                           [](float value) { return value > 0.0F; }));
  }
  return static_cast<int>(std::ranges::max_element(counts) - counts.begin());
}

Native read_slice(const std::filesystem::path& file, Orientation orientation, std::optional<int> wanted) {
  const auto volume = read_volume(file);
  const auto name = orientation_names[static_cast<std::size_t>(orientation)];
  const auto slices = static_cast<int>(volume->GetLargestPossibleRegion().GetSize()[axes_of(orientation)[2]]);
  const int slice = wanted ? *wanted : fullest_slice(*volume, orientation, slices);
  if (slice < 0 || slice >= slices) {
    constexpr std::array first{"below", "the front", "the patient's right"};
    throw unusable(file, fmt::format("there is no {} slice {}, it has the slices 0 ... {} from {}", name,
                                     slice, slices - 1, first[static_cast<std::size_t>(orientation)]));
  }
  Native native = slice_of(*volume, orientation, slice);
  if (!std::ranges::all_of(native.intensity.values, [](float value) { return std::isfinite(value); })) {
    throw unusable(file, fmt::format("{} slice {} has values that are not finite", name, slice));
  }
  if (std::ranges::none_of(native.intensity.values, [](float value) { return value > 0.0F; })) {
    throw unusable(file, fmt::format("{} slice {} has no pixel > 0", name, slice));
  }
  return native;
}

/// The largest part of what is > `threshold`, connected by sides, its holes filled: 1 inside, 0 outside. All
/// 0 if there is none.
ScalarField largest_part(const ScalarField& field, float threshold) {
  const Extent extent = field.extent;
  std::vector<bool> seen(extent.sites());
  const auto part_from = [&](std::size_t first, const auto& belongs) {
    std::vector<std::size_t> part{first};
    seen[first] = true;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const int x = static_cast<int>(part[next] % static_cast<std::size_t>(extent.width));
      const int y = static_cast<int>(part[next] / static_cast<std::size_t>(extent.width));
      for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
        const bool is_site = x + dx >= 0 && x + dx < extent.width && y + dy >= 0 && y + dy < extent.height;
        const std::size_t site = is_site ? extent.index(x + dx, y + dy) : first;
        if (!seen[site] && belongs(site)) {
          seen[site] = true;
          part.push_back(site);
        }
      }
    }
    return part;
  };
  std::vector<std::size_t> largest;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const auto is_above = [&](std::size_t other) { return field.values[other] > threshold; };
    if (!seen[site] && is_above(site)) {
      std::vector<std::size_t> part = part_from(site, is_above);
      if (part.size() > largest.size()) {
        largest = std::move(part);
      }
    }
  }
  // Outside is what is connected with the border of the image beside it; the rest are holes.
  seen.assign(extent.sites(), false);
  for (const std::size_t site : largest) {
    seen[site] = true;
  }
  ScalarField result(extent, 1.0F);
  for_each_site(extent, [&](int x, int y) {
    const bool at_border = x == 0 || y == 0 || x == extent.width - 1 || y == extent.height - 1;
    if (at_border && !seen[extent.index(x, y)]) {
      for (const std::size_t site : part_from(extent.index(x, y), [](std::size_t) { return true; })) {
        result.values[site] = 0.0F;
      }
    }
  });
  return result;
}

/// Edges of the pixels that are 1, in pixels: left and top at -0.5 for the first.
struct Box {
  double left = std::numeric_limits<double>::max();
  double top = std::numeric_limits<double>::max();
  double right = std::numeric_limits<double>::lowest();
  double bottom = std::numeric_limits<double>::lowest();
};

Box bounding_box(const ScalarField& mask) {
  Box box;
  for_each_site(mask.extent, [&](int column, int row) {
    if (mask.values[mask.extent.index(column, row)] > 0.0F) {
      box.left = std::min(box.left, column - 0.5);
      box.right = std::max(box.right, column + 0.5);
      box.top = std::min(box.top, row - 0.5);
      box.bottom = std::max(box.bottom, row + 0.5);
    }
  });
  return box;
}

/// Thresholds between tissue classes, rising, from the pixels inside the mask.
std::vector<double> otsu_thresholds(const ScalarField& intensity, const ScalarField& mask, int classes) {
  std::vector<float> inside;
  for (std::size_t site = 0; site < mask.values.size(); ++site) {
    if (mask.values[site] > 0.0F) {
      inside.push_back(intensity.values[site]);
    }
  }
  const auto [lowest, highest] = std::ranges::minmax(inside);
  if (classes == 1 || lowest == highest) {
    return {};
  }
  using Histogram = itk::Statistics::Histogram<double>;
  constexpr int bins = 256;
  const auto histogram = Histogram::New();
  histogram->SetMeasurementVectorSize(1);
  Histogram::SizeType size(1);
  size.Fill(bins);
  Histogram::MeasurementVectorType lower(1), upper(1);
  lower.Fill(lowest);
  upper.Fill(highest);
  histogram->Initialize(size, lower, upper);
  histogram->SetClipBinsAtEnds(false);
  for (const float value : inside) {
    Histogram::MeasurementVectorType measurement(1);
    measurement.Fill(value);
    histogram->IncreaseFrequencyOfMeasurement(measurement, 1);
  }
  const auto calculator = itk::OtsuMultipleThresholdsCalculator<Histogram>::New();
  calculator->SetInputHistogram(histogram);
  calculator->SetNumberOfThresholds(static_cast<itk::SizeValueType>(classes - 1));
  calculator->Compute();
  return calculator->GetOutput();
}

} // namespace

BrainSlice read_brain(const std::filesystem::path& file, std::optional<int> slice, int classes, double margin,
                      Extent size, Orientation orientation) {
  if (classes < 1 || classes > most_classes) {
    throw unusable(file, fmt::format("{} tissue classes, there may be 1 to {}", classes, most_classes));
  }
  if (!(margin >= 0.0 && margin < 0.5)) {
    throw unusable(file,
                   fmt::format("a margin of {} of the shorter side, it must be >= 0 and < 0.5", margin));
  }
  if (size.width < 1 || size.height < 1) {
    throw unusable(file, fmt::format("a grid of {} x {} pixels", size.width, size.height));
  }
  try {
    const Native native = read_slice(file, orientation, slice);
    const ScalarField native_mask = largest_part(native.intensity, 0.0F);
    const Box box = bounding_box(native_mask);
    const std::vector<double> thresholds = otsu_thresholds(native.intensity, native_mask, classes);
    const float brightest = std::ranges::max(native.intensity.values);

    const double free = 2.0 * margin * std::min(size.width, size.height);
    BrainSlice brain;
    brain.spacing = std::max((box.right - box.left) * native.spacing_x / (size.width - free),
                             (box.bottom - box.top) * native.spacing_y / (size.height - free));
    const auto native_x = [&](int column) {
      return 0.5 * (box.left + box.right) +
             (column + 0.5 - 0.5 * size.width) * brain.spacing / native.spacing_x;
    };
    const auto native_y = [&](int row) {
      return 0.5 * (box.top + box.bottom) +
             (row + 0.5 - 0.5 * size.height) * brain.spacing / native.spacing_y;
    };
    brain.placement = native.placement.moved(native_x(0) * native.spacing_x, native_y(0) * native.spacing_y);
    const auto sample = [&](const ScalarField& field) {
      ScalarField result(size);
      for (int row = 0; row < size.height; ++row) {
        const double y = native_y(row);
        for (int column = 0; column < size.width; ++column) {
          const double x = native_x(column);
          result.values[size.index(column, row)] = images::linear_at(field, x, y);
        }
      }
      return result;
    };
    const ScalarField mask = largest_part(sample(native_mask), 0.5F);
    brain.picture = sample(native.intensity);
    brain.tissue = {size, std::vector<int>(size.sites())};
    for (std::size_t site = 0; site < size.sites(); ++site) {
      float& gray = brain.picture.values[site];
      if (mask.values[site] > 0.0F) {
        const auto above =
            std::ranges::count_if(thresholds, [gray](double threshold) { return gray > threshold; });
        brain.tissue.values[site] = 1 + static_cast<int>(above);
        gray = std::clamp(gray / brightest, 0.0F, 1.0F) * 255.0F;
      } else {
        gray = 0.0F;
      }
    }
    if (std::ranges::count(brain.tissue.values, 0) == static_cast<std::ptrdiff_t>(size.sites())) {
      throw unusable(file,
                     fmt::format("nothing of the brain is left on {} x {} pixels", size.width, size.height));
    }
    return brain;
  } catch (const itk::ExceptionObject& error) {
    throw unusable(file, images::own_words(error));
  }
}

} // namespace hdmbench
