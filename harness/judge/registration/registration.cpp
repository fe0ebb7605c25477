#include "harness/judge/registration/elastic_registration.hpp"

#include "harness/judge/registration/registration_metric.hpp"
#include "harness/scene/images/pixels.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <itkBSplineTransformParametersAdaptor.h>
#include <itkLBFGSBOptimizer.h>
#include <itkSmoothingRecursiveGaussianImageFilter.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string_view>

namespace hdmbench {

namespace {

using images::MeanSquares;
using images::Spline;

constexpr int smallest_side = 16; // pixels

InputError unusable(std::string_view why) {
  return InputError(fmt::format("elastic registration: {}", why));
}

/// The contrast, largest minus smallest gray value.
float require_picture(const ScalarField& picture, Extent extent, const char* which) {
  if (picture.extent != extent || picture.values.size() != extent.sites()) {
    throw unusable(
        fmt::format("the {} picture is {} x {}, the other one {} x {}; crop or resample one of them", which,
                    picture.extent.width, picture.extent.height, extent.width, extent.height));
  }
  if (extent.width < smallest_side || extent.height < smallest_side) {
    throw unusable(fmt::format("the pictures are {} x {}, at least {} x {} pixels are needed", extent.width,
                               extent.height, smallest_side, smallest_side));
  }
  const auto bad = std::ranges::find_if_not(picture.values, [](float gray) { return std::isfinite(gray); });
  if (bad != picture.values.end()) {
    const auto site = bad - picture.values.begin();
    throw unusable(fmt::format("the {} picture at x = {}, y = {} is {}", which, site % extent.width,
                               site / extent.width, *bad));
  }
  const auto [low, high] = std::ranges::minmax(picture.values);
  if (low == high || !std::isfinite(high - low)) {
    throw unusable(fmt::format("the gray values of the {} picture are {} ... {}, there is no contrast to "
                               "register by",
                               which, low, high));
  }
  return high - low;
}

void require_options(const RegistrationOptions& options) {
  const auto require = [](bool holds, const char* what, double value, const char* range) {
    if (!holds) {
      throw unusable(fmt::format("{} is {}, it must be {}", what, value, range));
    }
  };
  require(options.levels >= 1 && options.levels <= 10, "the number of levels", options.levels, "1 ... 10");
  require(options.grid_spacing >= 2.0 && std::isfinite(options.grid_spacing), "the grid spacing",
          options.grid_spacing, "at least 2 pixels");
  require(options.blur >= 0.0 && options.blur <= 100.0, "the blur", options.blur, "0 ... 100 pixels");
  require(options.smoothness >= 0.0 && std::isfinite(options.smoothness), "the smoothness",
          options.smoothness, "finite and not negative");
  require(options.iterations >= 0, "the number of iterations", options.iterations, "0 or more");
}

/// Gray values divided by `contrast`, blurred by a Gaussian of `sigma` pixels.
ScalarField blurred(const ScalarField& picture, double sigma, float contrast) {
  ScalarField result(picture.extent);
  std::ranges::transform(picture.values, result.values.begin(),
                         [contrast](float gray) { return gray / contrast; });
  if (sigma > 0.0) {
    using Gray = itk::Image<float, 2>;
    const auto image = Gray::New();
    image->SetRegions(Gray::SizeType{static_cast<itk::SizeValueType>(picture.extent.width),
                                     static_cast<itk::SizeValueType>(picture.extent.height)});
    image->Allocate();
    std::ranges::copy(result.values, image->GetBufferPointer());
    const auto gaussian = itk::SmoothingRecursiveGaussianImageFilter<Gray, Gray>::New();
    gaussian->SetInput(image);
    gaussian->SetSigma(sigma);
    gaussian->Update();
    std::copy_n(gaussian->GetOutput()->GetBufferPointer(), result.values.size(), result.values.begin());
  }
  return result;
}

/// Cells per axis; twice as many on the next finer level, and at least one.
Spline::MeshSizeType mesh_of(Extent extent, int level, const RegistrationOptions& options) {
  const auto cells = [&](int side) {
    const int doublings =
        std::clamp(static_cast<int>(std::log2(side / options.grid_spacing)), 0, options.levels - 1);
    const double coarsest = std::round(side / (options.grid_spacing * std::exp2(doublings)));
    return static_cast<itk::SizeValueType>(std::max(1.0, coarsest)) << std::max(0, doublings - level);
  };
  return {cells(extent.width), cells(extent.height)};
}

/// No displacement, over the areas of all pixels.
Spline::Pointer identity(Extent extent, const Spline::MeshSizeType& mesh) {
  const auto spline = Spline::New();
  Spline::OriginType origin;
  origin.Fill(-0.5);
  Spline::PhysicalDimensionsType size;
  size[0] = extent.width;
  size[1] = extent.height;
  spline->SetTransformDomainOrigin(origin);
  spline->SetTransformDomainPhysicalDimensions(size);
  spline->SetTransformDomainMeshSize(mesh);
  spline->SetIdentity();
  return spline;
}

/// The same displacement on a finer grid.
void refine(Spline& spline, const Spline::MeshSizeType& mesh) {
  const auto adaptor = itk::BSplineTransformParametersAdaptor<Spline>::New();
  adaptor->SetTransform(&spline);
  adaptor->SetRequiredTransformDomainOrigin(spline.GetTransformDomainOrigin());
  adaptor->SetRequiredTransformDomainPhysicalDimensions(spline.GetTransformDomainPhysicalDimensions());
  adaptor->SetRequiredTransformDomainDirection(spline.GetTransformDomainDirection());
  adaptor->SetRequiredTransformDomainMeshSize(mesh);
  adaptor->AdaptTransformParameters();
}

/// Returns the number of iterations.
int minimise(itk::SingleValuedCostFunction& cost, Spline& spline, int iterations) {
  if (iterations == 0) {
    return 0;
  }
  const auto optimizer = itk::LBFGSBOptimizer::New();
  const auto count = spline.GetNumberOfParameters();
  itk::LBFGSBOptimizer::BoundSelectionType unbounded(count);
  unbounded.Fill(0);
  itk::LBFGSBOptimizer::BoundValueType none(count);
  none.Fill(0.0);
  optimizer->SetCostFunction(&cost);
  optimizer->SetBoundSelection(unbounded);
  optimizer->SetLowerBound(none);
  optimizer->SetUpperBound(none);
  optimizer->SetMaximumNumberOfCorrections(10);
  optimizer->SetMaximumNumberOfIterations(static_cast<unsigned>(iterations - 1)); // it does one more
  optimizer->SetMaximumNumberOfEvaluations(static_cast<unsigned>(2 * iterations));
  optimizer->SetCostFunctionConvergenceFactor(1e8); // times 2e-16: the least relative progress
  optimizer->SetProjectedGradientTolerance(0.0);
  optimizer->SetInitialPosition(spline.GetParameters());
  optimizer->StartOptimization();
  spline.SetParametersByValue(optimizer->GetCurrentPosition());
  return static_cast<int>(optimizer->GetCurrentIteration());
}

} // namespace

RegistrationResult register_elastically(const ScalarField& fixed, const ScalarField& moving,
                                        const RegistrationOptions& options, Progress& progress) {
  require_options(options);
  const Extent extent = fixed.extent;
  const float contrast = require_picture(fixed, extent, "fixed");
  (void)require_picture(moving, extent, "moving");
  const auto start = std::chrono::steady_clock::now();
  RegistrationResult result;
  const auto spline = identity(extent, mesh_of(extent, options.levels - 1, options));
  try {
    for (int level = options.levels - 1; level >= 0; --level) {
      const double sigma = options.blur * std::exp2(level);
      const auto cost = MeanSquares::New();
      cost->prepare(blurred(fixed, sigma, contrast), blurred(moving, sigma, contrast), *spline,
                    options.smoothness);
      result.iterations += minimise(*cost, *spline, options.iterations);
      result.mean_squares = cost->mean_squares(spline->GetParameters()) * contrast * contrast;
      if (level > 0) {
        refine(*spline, mesh_of(extent, level - 1, options));
      } else {
        result.displacement = cost->displacement(spline->GetParameters());
      }
      progress.advance(1.0);
    }
  } catch (const itk::ExceptionObject& error) {
    throw unusable(images::own_words(error));
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace hdmbench
