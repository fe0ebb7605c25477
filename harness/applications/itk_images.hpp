#pragma once

#include "kernels/data/field.hpp"

#include <itkImage.h>
#include <itkVector.h>

#include <algorithm>

/// Fields as images of ITK, whose pixels have sides of 1 and begin at 0: only where ITK is.
namespace hdmbench::images {

template <typename Value>
[[nodiscard]] typename itk::Image<Value, 2>::Pointer image_of(const ScalarField& field) {
  using Image = itk::Image<Value, 2>;
  const auto image = Image::New();
  image->SetRegions(typename Image::SizeType{static_cast<itk::SizeValueType>(field.extent.width),
                                             static_cast<itk::SizeValueType>(field.extent.height)});
  image->Allocate();
  std::ranges::transform(field.values, image->GetBufferPointer(),
                         [](float value) { return static_cast<Value>(value); });
  return image;
}

template <typename Component>
[[nodiscard]] VectorField field_of(const itk::Image<itk::Vector<Component, 2>, 2>& image, Extent extent) {
  VectorField field(extent);
  const auto* const pixels = image.GetBufferPointer();
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    field.x[site] = static_cast<float>(pixels[site][0]);
    field.y[site] = static_cast<float>(pixels[site][1]);
  }
  return field;
}

} // namespace hdmbench::images
