#include "harness/applications/conventional_registration.hpp"

#include "harness/applications/itk_images.hpp"
#include "harness/scene/images/pixels.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <itkBSplineSmoothingOnUpdateDisplacementFieldTransform.h>
#include <itkBSplineSmoothingOnUpdateDisplacementFieldTransformParametersAdaptor.h>
#include <itkDiffeomorphicDemonsRegistrationFilter.h>
#include <itkGaussianSmoothingOnUpdateDisplacementFieldTransform.h>
#include <itkGaussianSmoothingOnUpdateDisplacementFieldTransformParametersAdaptor.h>
#include <itkGradientDescentOptimizerv4.h>
#include <itkHistogramMatchingImageFilter.h>
#include <itkImageMaskSpatialObject.h>
#include <itkImageRegistrationMethodv4.h>
#include <itkMattesMutualInformationImageToImageMetricv4.h>
#include <itkMultiResolutionPDEDeformableRegistration.h>
#include <itkRegistrationParameterScalesFromPhysicalShift.h>
#include <itkShrinkImageFilter.h>

#include <chrono>
#include <cmath>
#include <vector>

namespace hdmbench {

namespace {

using Gray = itk::Image<double, 2>;
using Field = itk::Image<itk::Vector<double, 2>, 2>;
using Metric = itk::MattesMutualInformationImageToImageMetricv4<Gray, Gray>;

constexpr int smallest_level_side = 24; // pixels
constexpr unsigned threads = 1;         // ITK's sums depend on them

struct Pictures {
  const ScalarField& source;
  const ScalarField& target;
  const ScalarField& unseen;
  int levels = 1;
};

int levels_of(Extent extent, int most) {
  int levels = 1;
  while (levels < most && (std::min(extent.width, extent.height) >> levels) >= smallest_level_side) {
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
    mask->SetImage(images::image_of<unsigned char>(seen));
    mask->Update();
    metric->SetFixedImageMask(mask);
  }
  return metric;
}

/// `Transform` is a displacement field whose updates are made smooth; configure(transform) before the first
/// level, adaptor(level) one that does it for that level, 0 the coarsest.
template <typename Transform, typename Configure, typename Adaptor>
VectorField by_mutual_information(const Pictures& pictures, int iterations, const Configure& configure,
                                  const Adaptor& adaptor_of) {
  const auto fixed = images::image_of<double>(pictures.source);
  const auto moving = images::image_of<double>(pictures.target);
  const auto still = Field::New();
  still->CopyInformation(fixed);
  still->SetRegions(fixed->GetLargestPossibleRegion());
  still->Allocate();
  still->FillBuffer(itk::Vector<double, 2>(0.0));
  const auto transform = Transform::New();
  transform->SetDisplacementField(still);
  configure(*transform);

  const auto metric = metric_of(*fixed, pictures.unseen);
  using Scales = itk::RegistrationParameterScalesFromPhysicalShift<Metric>;
  const auto scales = Scales::New();
  scales->SetMetric(metric);
  const auto optimizer = itk::GradientDescentOptimizerv4::New();
  optimizer->SetScalesEstimator(scales);
  optimizer->SetMaximumStepSizeInPhysicalUnits(0.7);
  optimizer->SetDoEstimateLearningRateOnce(false);
  optimizer->SetDoEstimateLearningRateAtEachIteration(true);
  optimizer->SetMinimumConvergenceValue(1e-5);
  optimizer->SetConvergenceWindowSize(10);
  optimizer->SetNumberOfIterations(static_cast<itk::SizeValueType>(iterations));
  optimizer->SetNumberOfWorkUnits(threads);

  using Registration = itk::ImageRegistrationMethodv4<Gray, Gray, Transform>;
  const auto levels = static_cast<unsigned>(pictures.levels);
  typename Registration::ShrinkFactorsArrayType shrink(levels);
  typename Registration::SmoothingSigmasArrayType blur(levels);
  typename Registration::TransformParametersAdaptorsContainerType adaptors;
  for (unsigned level = 0; level < levels; ++level) {
    shrink[level] = 1U << (levels - 1 - level);
    blur[level] = 0.5 * static_cast<double>(shrink[level]);
    const auto shrunk = itk::ShrinkImageFilter<Gray, Gray>::New();
    shrunk->SetInput(fixed);
    shrunk->SetShrinkFactors(static_cast<unsigned>(shrink[level]));
    shrunk->Update();
    const auto adaptor = adaptor_of(level);
    adaptor->SetRequiredSize(shrunk->GetOutput()->GetBufferedRegion().GetSize());
    adaptor->SetRequiredOrigin(shrunk->GetOutput()->GetOrigin());
    adaptor->SetRequiredSpacing(shrunk->GetOutput()->GetSpacing());
    adaptor->SetRequiredDirection(shrunk->GetOutput()->GetDirection());
    adaptor->SetTransform(transform);
    adaptors.push_back(adaptor.GetPointer());
  }
  const auto registration = Registration::New();
  registration->SetFixedImage(fixed);
  registration->SetMovingImage(moving);
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
  return images::field_of(*transform->GetDisplacementField(), pictures.source.extent);
}

VectorField by_b_splines(const Pictures& pictures, const ConventionalOptions& options) {
  using Transform = itk::BSplineSmoothingOnUpdateDisplacementFieldTransform<double, 2>;
  using Adaptor = itk::BSplineSmoothingOnUpdateDisplacementFieldTransformParametersAdaptor<Transform>;
  constexpr unsigned order = 3;
  const auto control_points = [&](unsigned level) {
    const double shrink = 1U << (static_cast<unsigned>(pictures.levels) - 1 - level);
    const auto along = [&](int side) {
      return order + static_cast<unsigned>(std::max(4.0, std::round(side / (shrink * options.grid_spacing))));
    };
    Transform::ArrayType points;
    points[0] = along(pictures.source.extent.width);
    points[1] = along(pictures.source.extent.height);
    return points;
  };
  Transform::ArrayType none; // the sum of the updates stays as it is
  none.Fill(0);
  return by_mutual_information<Transform>(
      pictures, options.iterations,
      [&](Transform& transform) {
        transform.SetNumberOfControlPointsForTheUpdateField(control_points(0));
        transform.SetNumberOfControlPointsForTheTotalField(none);
      },
      [&](unsigned level) {
        const auto adaptor = Adaptor::New();
        adaptor->SetNumberOfControlPointsForTheUpdateField(control_points(level));
        adaptor->SetNumberOfControlPointsForTheTotalField(none);
        return adaptor;
      });
}

VectorField by_gaussian(const Pictures& pictures, const ConventionalOptions& options) {
  using Transform = itk::GaussianSmoothingOnUpdateDisplacementFieldTransform<double, 2>;
  using Adaptor = itk::GaussianSmoothingOnUpdateDisplacementFieldTransformParametersAdaptor<Transform>;
  constexpr double of_the_sum = 0.5; // pixels squared
  const double of_updates = options.smoothing * options.smoothing;
  return by_mutual_information<Transform>(
      pictures, options.iterations,
      [&](Transform& transform) {
        transform.SetGaussianSmoothingVarianceForTheUpdateField(of_updates);
        transform.SetGaussianSmoothingVarianceForTheTotalField(of_the_sum);
      },
      [&](unsigned) {
        const auto adaptor = Adaptor::New();
        adaptor->SetGaussianSmoothingVarianceForTheUpdateField(of_updates);
        adaptor->SetGaussianSmoothingVarianceForTheTotalField(of_the_sum);
        return adaptor;
      });
}

VectorField by_demons(const Pictures& pictures, const ConventionalOptions& options) {
  using Picture = itk::Image<float, 2>;
  using Displacement = itk::Image<itk::Vector<float, 2>, 2>;
  const auto fixed = images::image_of<float>(pictures.source);
  const auto matched = itk::HistogramMatchingImageFilter<Picture, Picture>::New();
  matched->SetReferenceImage(fixed);
  matched->SetInput(images::image_of<float>(pictures.target));
  matched->SetNumberOfHistogramLevels(256);
  matched->SetNumberOfMatchPoints(15);
  matched->ThresholdAtMeanIntensityOn();
  matched->Update();
  const auto demons = itk::DiffeomorphicDemonsRegistrationFilter<Picture, Picture, Displacement>::New();
  demons->SetStandardDeviations(options.demons_smoothing);
  demons->SetNumberOfWorkUnits(threads);
  const auto levels =
      itk::MultiResolutionPDEDeformableRegistration<Picture, Picture, Displacement, float>::New();
  levels->SetRegistrationFilter(demons);
  levels->SetFixedImage(fixed);
  levels->SetMovingImage(matched->GetOutput());
  levels->SetNumberOfLevels(static_cast<unsigned>(pictures.levels));
  std::vector<unsigned> iterations(static_cast<std::size_t>(pictures.levels),
                                   static_cast<unsigned>(options.iterations));
  iterations.back() /= 2;
  levels->SetNumberOfIterations(iterations.data());
  levels->Update();
  return images::field_of(*levels->GetOutput(), pictures.source.extent);
}

void require_options(const ConventionalOptions& options) {
  const auto require = [](bool holds, const char* what, double value, const char* range) {
    if (!holds) {
      throw InputError(fmt::format("registration: {} is {}, it must be {}", what, value, range));
    }
  };
  require(options.levels >= 1 && options.levels <= 8, "the number of levels", options.levels, "1 ... 8");
  require(options.iterations >= 1, "the number of iterations", options.iterations, "at least 1");
  require(options.grid_spacing >= 4.0 && std::isfinite(options.grid_spacing), "the grid spacing",
          options.grid_spacing, "at least 4 pixels");
  for (const double smoothing : {options.smoothing, options.demons_smoothing}) {
    require(smoothing > 0.0 && smoothing <= 100.0, "the smoothing", smoothing,
            "above 0 and at most 100 pixels");
  }
}

} // namespace

ConventionalRegistration register_conventionally(const ScalarField& source, const ScalarField& target,
                                                 const ScalarField& unseen,
                                                 const ConventionalOptions& options, Progress& progress) {
  require_options(options);
  require_pair(source, target);
  const auto start = std::chrono::steady_clock::now();
  const Pictures pictures{source, target, unseen, levels_of(source.extent, options.levels)};
  ConventionalRegistration result;
  try {
    switch (options.method) {
    case Conventional::b_splines:
      result.displacement = by_b_splines(pictures, options);
      break;
    case Conventional::gaussian:
      result.displacement = by_gaussian(pictures, options);
      break;
    case Conventional::demons:
      result.displacement = by_demons(pictures, options);
      break;
    }
  } catch (const itk::ExceptionObject& error) {
    throw InputError(fmt::format("registration by {}: {}",
                                 conventional_names[static_cast<std::size_t>(options.method)],
                                 images::own_words(error)));
  }
  progress.advance(1.0);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace hdmbench
