#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/interruption.hpp"

#include <itkBinaryFillholeImageFilter.h>
#include <itkBinaryShapeKeepNObjectsImageFilter.h>
#include <itkHistogram.h>
#include <itkOrientImageFilter.h>
#include <itkOtsuMultipleThresholdsCalculator.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

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

/// Columns, rows and slices follow each other as `orientation` has them.
Volume::Pointer read_volume(const std::filesystem::path& file, Orientation orientation) {
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
  using Order = itk::SpatialOrientation::ValidCoordinateOrientationFlags; // from right, front, below, ...
  constexpr std::array orders{Order::ITK_COORDINATE_ORIENTATION_RAI, Order::ITK_COORDINATE_ORIENTATION_RSA,
                              Order::ITK_COORDINATE_ORIENTATION_ASR};
  const auto orient = itk::OrientImageFilter<Volume, Volume>::New();
  orient->SetInput(volume);
  orient->UseImageDirectionOn();
  orient->SetDesiredCoordinateOrientation(orders.at(static_cast<std::size_t>(orientation)));
  orient->Update();
  return orient->GetOutput();
}

/// Without `wanted`, the slice with the most pixels above 0.
Native read_slice(const std::filesystem::path& file, Orientation orientation, std::optional<int> wanted) {
  const auto volume = read_volume(file, orientation);
  const auto region = volume->GetLargestPossibleRegion();
  const Extent extent{static_cast<int>(region.GetSize()[0]), static_cast<int>(region.GetSize()[1])};
  const auto slices = static_cast<int>(region.GetSize()[2]);
  const auto values_of = [&](int slice) {
    return std::span(volume->GetBufferPointer() + static_cast<std::size_t>(slice) * extent.sites(),
                     extent.sites());
  };
  const auto is_tissue = [](float value) { return value > 0.0F; };
  int slice = wanted.value_or(0);
  if (!wanted) {
    std::vector<std::ptrdiff_t> counts;
    for (int at = 0; at < slices; ++at) {
      counts.push_back(std::ranges::count_if(values_of(at), is_tissue));
    }
    slice = static_cast<int>(std::ranges::max_element(counts) - counts.begin());
  }
  const auto name = orientation_names[static_cast<std::size_t>(orientation)];
  if (slice < 0 || slice >= slices) {
    constexpr std::array first{"below", "the front", "the patient's right"};
    throw unusable(file, fmt::format("there is no {} slice {}, it has the slices 0 ... {} from {}", name,
                                     slice, slices - 1, first[static_cast<std::size_t>(orientation)]));
  }
  Native native{.intensity = ScalarField(extent),
                .spacing_x = volume->GetSpacing()[0],
                .spacing_y = volume->GetSpacing()[1],
                .placement = {.thickness = volume->GetSpacing()[2]}};
  std::ranges::copy(values_of(slice), native.intensity.values.begin());
  if (!std::ranges::all_of(native.intensity.values, [](float value) { return std::isfinite(value); })) {
    throw unusable(file, fmt::format("{} slice {} has values that are not finite", name, slice));
  }
  if (std::ranges::none_of(native.intensity.values, is_tissue)) {
    throw unusable(file, fmt::format("{} slice {} has no pixel > 0", name, slice));
  }
  Volume::IndexType at = region.GetIndex();
  at[2] += slice;
  const auto origin = volume->TransformIndexToPhysicalPoint<double>(at);
  for (unsigned row = 0; row < 3; ++row) {
    native.placement.origin[row] = origin[row];
    for (unsigned axis = 0; axis < 3; ++axis) {
      native.placement.axes[axis][row] = volume->GetDirection()(row, axis);
    }
  }
  return native;
}

/// The largest part of what is > `threshold`, connected by sides, its holes filled: 1 inside, 0 outside. All
/// 0 if there is none. `axes`: those of the field.
template <unsigned axes>
ScalarField largest_part(const ScalarField& field, float threshold) {
  using Mask = itk::Image<unsigned char, axes>;
  const auto mask = Mask::New();
  typename Mask::SizeType size;
  for (unsigned axis = 0; axis < axes; ++axis) {
    size[axis] = static_cast<itk::SizeValueType>(field.extent.sides()[axis]);
  }
  mask->SetRegions(size);
  mask->Allocate();
  std::ranges::transform(field.values, mask->GetBufferPointer(),
                         [threshold](float value) -> unsigned char { return value > threshold ? 1 : 0; });
  const auto largest = itk::BinaryShapeKeepNObjectsImageFilter<Mask>::New();
  largest->SetInput(mask);
  largest->SetForegroundValue(1);
  largest->SetNumberOfObjects(1);
  largest->SetAttribute("NumberOfPixels");
  const auto filled = itk::BinaryFillholeImageFilter<Mask>::New();
  filled->SetInput(largest->GetOutput());
  filled->SetForegroundValue(1);
  filled->Update();
  ScalarField result(field.extent);
  std::copy_n(filled->GetOutput()->GetBufferPointer(), result.values.size(), result.values.begin());
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

/// From 1, by rising brightness.
int class_of(float gray, const std::vector<double>& thresholds) {
  return 1 + static_cast<int>(
                 std::ranges::count_if(thresholds, [gray](double threshold) { return gray > threshold; }));
}

/// The brain with what lies between its folds, where those are nearer to each other than so many voxels.
std::vector<bool> with_sulci(const ScalarField& in_brain, double widest) {
  std::vector<bool> inside(in_brain.values.size());
  std::transform(in_brain.values.begin(), in_brain.values.end(), inside.begin(),
                 [](float value) { return value > 0.0F; });
  return close_gaps(inside, in_brain.extent, 0.5 * widest, {1.0, 1.0, 1.0});
}

} // namespace

BrainSlice read_head(const std::filesystem::path& brain, const std::filesystem::path& head, int classes,
                     double sulci, std::optional<Extent> size) {
  try {
    const auto read = [](const std::filesystem::path& file) {
      Image<ScalarField> image = read_scalar(file, {.takes_volumes = true});
      ScalarField part;
      if (image.pixels.extent.axes() == 3) {
        part = largest_part<3>(image.pixels, 0.0F);
      }
      return std::pair(std::move(image), std::move(part));
    };
    auto other = std::async(std::launch::async, read, head);
    const auto [inner, in_brain] = read(brain);
    may_end_here();
    const auto [outer, in_head] = other.get();
    may_end_here();
    if (const std::string difference = difference_between(inner.grid, outer.grid, head.string());
        !difference.empty()) {
      throw unusable(brain, fmt::format("it {}", difference));
    }
    if (inner.pixels.extent.axes() != 3) {
      throw unusable(brain, "it is no volume");
    }
    const std::vector<double> thresholds = otsu_thresholds(inner.pixels, in_brain, classes);
    Image<std::vector<ScalarField>> both{{outer.pixels, outer.pixels}, outer.spacing, outer.placement};
    const std::vector<bool> within = with_sulci(in_brain, sulci / inner.spacing);
    for (std::size_t site = 0; site < in_brain.values.size(); ++site) {
      both.pixels[0].values[site] =
          in_brain.values[site] > 0.0F ? static_cast<float>(class_of(inner.pixels.values[site], thresholds))
          : within[site]               ? 1.0F
                         : (in_head.values[site] > 0.0F ? static_cast<float>(classes + 1) : 0.0F);
    }
    images::fit_nearest(head, both, size);
    const Extent extent = both.pixels[0].extent;
    BrainSlice found{.picture = std::move(both.pixels[1]),
                     .tissue = {extent, std::vector<int>(extent.sites())},
                     .spacing = both.spacing,
                     .placement = both.placement,
                     .oblong = outer.oblong};
    std::ranges::transform(both.pixels[0].values, found.tissue.values.begin(),
                           [](float label) { return static_cast<int>(label); });
    return found;
  } catch (const itk::ExceptionObject& error) {
    throw unusable(head, images::own_words(error));
  }
}

BrainSlice read_brain(const std::filesystem::path& file, std::optional<int> slice, int classes, double margin,
                      Extent size, Orientation orientation) {
  try {
    const Native native = read_slice(file, orientation, slice);
    const ScalarField native_mask = largest_part<2>(native.intensity, 0.0F);
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
      for_each_site(size, [&](int column, int row) {
        result.values[size.index(column, row)] =
            images::linear_at(field.values, field.extent, native_x(column), native_y(row));
      });
      return result;
    };
    const ScalarField mask = largest_part<2>(sample(native_mask), 0.5F);
    brain.picture = sample(native.intensity);
    brain.tissue = {size, std::vector<int>(size.sites())};
    for (std::size_t site = 0; site < size.sites(); ++site) {
      float& gray = brain.picture.values[site];
      if (mask.values[site] > 0.0F) {
        brain.tissue.values[site] = class_of(gray, thresholds);
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
