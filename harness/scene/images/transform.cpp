// Displacements as ITK's transforms: files of them, and images that they move.

#include "harness/scene/files.hpp"
#include "harness/scene/images/pixels.hpp"

#include <itkDisplacementFieldTransform.h>
#include <itkHDF5TransformIO.h>
#include <itkImage.h>
#include <itkLinearInterpolateImageFunction.h>
#include <itkNearestNeighborInterpolateImageFunction.h>
#include <itkResampleImageFilter.h>
#include <itkTransformFactory.h>

namespace hdmbench::images {

namespace {

using Transform = itk::DisplacementFieldTransform<double, 3>;
using Field = Transform::DisplacementFieldType;
using Scalars = itk::Image<float, 3>;

template <typename Image>
typename Image::Pointer image_at(const Geometry& geometry) {
  const auto image = Image::New();
  typename Image::SizeType size;
  typename Image::PointType origin;
  typename Image::SpacingType spacing;
  typename Image::DirectionType direction;
  for (unsigned axis = 0; axis < 3; ++axis) {
    size[axis] = static_cast<itk::SizeValueType>(geometry.size[axis]);
    origin[axis] = geometry.origin[axis];
    spacing[axis] = geometry.spacing[axis];
    for (unsigned row = 0; row < 3; ++row) {
      direction(row, axis) = geometry.axes[axis][row];
    }
  }
  image->SetRegions(size);
  image->SetOrigin(origin);
  image->SetSpacing(spacing);
  image->SetDirection(direction);
  image->Allocate();
  return image;
}

Transform::Pointer transform_of(const Geometry& geometry, const std::vector<float>& values) {
  const auto field = image_at<Field>(geometry);
  Field::PixelType* vector = field->GetBufferPointer();
  for (std::size_t at = 0; at < values.size(); at += 3, ++vector) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      (*vector)[axis] = values[at + axis];
    }
  }
  auto transform = Transform::New();
  transform->SetDisplacementField(field);
  return transform;
}

} // namespace

Pixels read_transform(const std::filesystem::path& file) {
  itk::TransformFactory<Transform>::RegisterTransform();
  const auto format = itk::HDF5TransformIOTemplate<double>::New();
  format->SetFileName(file.string());
  format->Read();
  auto& found = format->GetReadTransformList();
  const auto* const transform =
      found.size() == 1 ? dynamic_cast<const Transform*>(found.front().GetPointer()) : nullptr;
  if (transform == nullptr || transform->GetDisplacementField() == nullptr) {
    throw unreadable(file, "it is not one displacement field in three dimensions");
  }
  const Field& field = *transform->GetDisplacementField();
  Pixels pixels;
  Geometry& geometry = pixels.geometry;
  geometry.components = 3;
  for (unsigned axis = 0; axis < 3; ++axis) {
    geometry.size[axis] = static_cast<int>(field.GetLargestPossibleRegion().GetSize()[axis]);
    geometry.spacing[axis] = field.GetSpacing()[axis];
    geometry.origin[axis] = field.GetOrigin()[axis];
    for (unsigned row = 0; row < 3; ++row) {
      geometry.axes[axis][row] = field.GetDirection()(row, axis);
    }
  }
  require_reasonable_number(file, geometry);
  const Field::PixelType* vector = field.GetBufferPointer();
  for (std::size_t at = 0; at < geometry.values(); at += 3, ++vector) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      pixels.values.push_back(static_cast<float>((*vector)[axis]));
    }
  }
  return pixels;
}

void write_transform(const std::filesystem::path& file, const Geometry& geometry,
                     const std::vector<float>& values) {
  write_atomically(file, [&](const std::filesystem::path& partial) {
    try {
      const auto format = itk::HDF5TransformIOTemplate<double>::New();
      format->SetFileName(partial.string());
      itk::HDF5TransformIOTemplate<double>::ConstTransformListType list;
      list.push_back(transform_of(geometry, values).GetPointer());
      format->SetTransformList(list);
      format->Write();
    } catch (const itk::ExceptionObject& error) {
      throw unwritable(file, own_words(error));
    }
  });
}

void resample(const Pixels& displacement, bool to_nearest, Pixels& image) {
  const auto picture = image_at<Scalars>(image.geometry);
  std::ranges::copy(image.values, picture->GetBufferPointer());
  const auto filter = itk::ResampleImageFilter<Scalars, Scalars>::New();
  filter->SetInput(picture);
  filter->SetReferenceImage(picture);
  filter->UseReferenceImageOn();
  filter->SetTransform(transform_of(displacement.geometry, displacement.values));
  if (to_nearest) {
    filter->SetInterpolator(itk::NearestNeighborInterpolateImageFunction<Scalars, double>::New());
  }
  filter->Update();
  const float* const moved = filter->GetOutput()->GetBufferPointer();
  image.values.assign(moved, moved + image.values.size());
}

} // namespace hdmbench::images
