#include "harness/applications/registration.hpp"

#include "harness/applications/picture.hpp"
#include "harness/scene/images/pixels.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <itkBSplineSmoothingOnUpdateDisplacementFieldTransform.h>
#include <itkBSplineSmoothingOnUpdateDisplacementFieldTransformParametersAdaptor.h>
#include <itkGradientDescentOptimizerv4.h>
#include <itkImageMaskSpatialObject.h>
#include <itkImageRegistrationMethodv4.h>
#include <itkMattesMutualInformationImageToImageMetricv4.h>
#include <itkRegistrationParameterScalesFromPhysicalShift.h>
#include <itkShrinkImageFilter.h>

#include <cmath>

namespace hdmbench {

namespace {

using Gray = itk::Image<double, 2>;
using Field = itk::Image<itk::Vector<double, 2>, 2>;
using Metric = itk::MattesMutualInformationImageToImageMetricv4<Gray, Gray>;

constexpr int smallest_level_side = 24;        // pixels
constexpr unsigned threads = 1;                // ITK's sums depend on them
constexpr unsigned most_levels = 4;            // of the pictures; fewer where they are small
constexpr unsigned most_iterations = 60;       // per level
constexpr double control_point_spacing = 10.0; // B-splines, pixels of every level

/// Pixels have sides of 1 and begin at 0.
template <typename Value>
typename itk::Image<Value, 2>::Pointer image_of(const ScalarField& field) {
  using Image = itk::Image<Value, 2>;
  const auto image = Image::New();
  image->SetRegions(typename Image::SizeType{static_cast<itk::SizeValueType>(field.extent.width),
                                             static_cast<itk::SizeValueType>(field.extent.height)});
  image->Allocate();
  std::ranges::transform(field.values, image->GetBufferPointer(),
                         [](float value) { return static_cast<Value>(value); });
  return image;
}

VectorField field_of(const Field& image, Extent extent) {
  VectorField field(extent);
  const auto* const pixels = image.GetBufferPointer();
  for (unsigned axis = 0; axis < Field::ImageDimension; ++axis) {
    std::transform(pixels, pixels + extent.sites(), field[axis].begin(),
                   [&](const auto& way) { return static_cast<float>(way[axis]); });
  }
  return field;
}

unsigned levels_of(Extent extent) {
  unsigned levels = 1;
  while (levels < most_levels && (std::min(extent.width, extent.height) >> levels) >= smallest_level_side) {
    ++levels;
  }
  return levels;
}

Metric::Pointer metric_of(const Gray& fixed, const ScalarField& unseen) {
  const auto metric = Metric::New();
  metric->SetNumberOfHistogramBins(32);
  metric->SetUseFixedImageGradientFilter(false);
  metric->SetUseMovingImageGradientFilter(false);
  metric->SetVirtualDomainFromImage(&fixed);
  metric->SetMaximumNumberOfWorkUnits(threads);
  if (!unseen.values.empty()) {
    ScalarField seen(unseen.extent);
    std::ranges::transform(unseen.values, seen.values.begin(),
                           [](float value) { return value == 0.0F ? 1.0F : 0.0F; });
    using Mask = itk::ImageMaskSpatialObject<2>;
    const auto mask = Mask::New();
    mask->SetImage(image_of<unsigned char>(seen));
    mask->Update();
    metric->SetFixedImageMask(mask);
  }
  return metric;
}

/// The updates of the displacement are made smooth by cubic B-splines, whose control points have the same
/// distance in pixels of every level.
VectorField by_b_splines(const ScalarField& source, const ScalarField& target, const ScalarField& unseen) {
  using Splines = itk::BSplineSmoothingOnUpdateDisplacementFieldTransform<double, 2>;
  using Adaptor = itk::BSplineSmoothingOnUpdateDisplacementFieldTransformParametersAdaptor<Splines>;
  using Registration = itk::ImageRegistrationMethodv4<Gray, Gray, Splines>;
  const auto fixed = image_of<double>(source);
  const auto still = Field::New();
  still->CopyInformation(fixed);
  still->SetRegions(fixed->GetLargestPossibleRegion());
  still->Allocate();
  still->FillBuffer(itk::Vector<double, 2>(0.0));
  const auto transform = Splines::New();
  transform->SetDisplacementField(still);

  const auto metric = metric_of(*fixed, unseen);
  const auto scales = itk::RegistrationParameterScalesFromPhysicalShift<Metric>::New();
  scales->SetMetric(metric);
  const auto optimizer = itk::GradientDescentOptimizerv4::New();
  optimizer->SetScalesEstimator(scales);
  optimizer->SetMaximumStepSizeInPhysicalUnits(0.7);
  optimizer->SetDoEstimateLearningRateOnce(false);
  optimizer->SetDoEstimateLearningRateAtEachIteration(true);
  optimizer->SetMinimumConvergenceValue(1e-5);
  optimizer->SetConvergenceWindowSize(10);
  optimizer->SetNumberOfIterations(most_iterations);
  optimizer->SetNumberOfWorkUnits(threads);

  const unsigned levels = levels_of(source.extent);
  Registration::ShrinkFactorsArrayType shrink(levels);
  Registration::SmoothingSigmasArrayType blur(levels);
  Registration::TransformParametersAdaptorsContainerType adaptors;
  for (unsigned level = 0; level < levels; ++level) {
    shrink[level] = 1U << (levels - 1 - level);
    blur[level] = 0.5 * static_cast<double>(shrink[level]);
    const auto shrunk = itk::ShrinkImageFilter<Gray, Gray>::New();
    shrunk->SetInput(fixed);
    shrunk->SetShrinkFactors(static_cast<unsigned>(shrink[level]));
    shrunk->Update();
    const auto adaptor = Adaptor::New();
    adaptor->SetRequiredSize(shrunk->GetOutput()->GetBufferedRegion().GetSize());
    adaptor->SetRequiredOrigin(shrunk->GetOutput()->GetOrigin());
    adaptor->SetRequiredSpacing(shrunk->GetOutput()->GetSpacing());
    adaptor->SetRequiredDirection(shrunk->GetOutput()->GetDirection());
    adaptor->SetTransform(transform);
    Splines::ArrayType mesh; // of the updates; their sum stays as it is
    for (unsigned axis = 0; axis < Field::ImageDimension; ++axis) {
      const double cells =
          source.extent.sides()[axis] / (static_cast<double>(shrink[level]) * control_point_spacing);
      mesh[axis] = static_cast<unsigned>(std::max(4.0, std::round(cells)));
    }
    adaptor->SetMeshSizeForTheUpdateField(mesh);
    adaptors.push_back(adaptor.GetPointer());
  }
  const auto registration = Registration::New();
  registration->SetFixedImage(fixed);
  registration->SetMovingImage(image_of<double>(target));
  registration->SetMetric(metric);
  registration->SetOptimizer(optimizer);
  registration->SetInitialTransform(transform);
  registration->InPlaceOn();
  registration->SetNumberOfLevels(levels);
  registration->SetShrinkFactorsPerLevel(shrink);
  registration->SetSmoothingSigmasPerLevel(blur);
  registration->SetTransformParametersAdaptorsPerLevel(adaptors);
  registration->SetNumberOfWorkUnits(threads);
  registration->Update();
  return field_of(*transform->GetDisplacementField(), source.extent);
}

} // namespace

ConventionalRegistration register_conventionally(const ScalarField& source, const ScalarField& target,
                                                 const ScalarField& unseen, Progress& progress) {
  require_pair(source, target);
  if (source.extent.axes() == 3) {
    throw InputError(
        "registration by B-splines takes images only: for volumes give --iterate (iterate=True)");
  }
  const auto start = std::chrono::steady_clock::now();
  ConventionalRegistration result;
  try {
    result.displacement = by_b_splines(source, target, unseen);
  } catch (const itk::ExceptionObject& error) {
    throw InputError(fmt::format("registration by B-splines: {}", images::own_words(error)));
  }
  progress.advance(1.0);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace hdmbench
