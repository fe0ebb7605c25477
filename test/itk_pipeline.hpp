#pragma once

#include "backends/registry.hpp"
#include "harness/solve/solve.hpp"

#include <gtest/gtest.h>
#include <itkHDMRegularizationFilter.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

/// What the filter's tests stand on: a small problem, once for solve() and once as ITK images that lie anyhow
/// in physical space.
namespace hdmbench::test {

using Filter = itk::HDMRegularizationFilter<>;
using Field = Filter::DisplacementFieldType;
using Labels = Filter::LabelImageType;
using Direction = Field::DirectionType;

inline constexpr int iterations = 40;

/// How the pixels lie in physical space.
struct Geometry {
  double spacing = 1.0;
  double angle = 0.0; ///< of the rows, radians
  bool flipped = false;
  itk::IndexValueType first_index = 0; ///< of the first pixel, both axes

  [[nodiscard]] Direction direction() const {
    Direction result;
    result(0, 0) = std::cos(angle);
    result(1, 0) = std::sin(angle);
    result(0, 1) = flipped ? std::sin(angle) : -std::sin(angle);
    result(1, 1) = flipped ? -std::cos(angle) : std::cos(angle);
    return result;
  }

  template <typename Picture>
  typename Picture::Pointer allocate(Extent extent) const {
    const auto picture = Picture::New();
    const typename Picture::IndexType index{first_index, first_index};
    const typename Picture::SizeType size{static_cast<itk::SizeValueType>(extent.width),
                                          static_cast<itk::SizeValueType>(extent.height)};
    picture->SetRegions({index, size});
    typename Picture::SpacingType spacings;
    spacings.Fill(spacing);
    picture->SetSpacing(spacings);
    picture->SetDirection(direction());
    typename Picture::PointType origin;
    origin[0] = -7.0;
    origin[1] = 30.0;
    picture->SetOrigin(origin);
    picture->Allocate(true);
    return picture;
  }
};

/// A stiff disc in soft matter, pulled at the left border and in places inside.
struct Problem {
  explicit Problem(Extent extent) : labels(extent.sites(), 0) {
    std::mt19937 random(3);
    const auto uniform = [&random] { return static_cast<float>(random() % 1001) * 0.001F; };
    Level& full = scene.full;
    full.extent = extent;
    full.target = VectorField(extent);
    full.confidence = VectorField(extent);
    full.modulus = ScalarField(extent, 10.0F);
    full.penalty = 1000.0F;
    VectorField& start = scene.start.emplace(extent);
    scene.schedule.iterations = iterations;
    for (int y = 0; y < extent.height; ++y) {
      for (int x = 0; x < extent.width; ++x) {
        const std::size_t site = extent.index(x, y);
        if (std::hypot(x - 0.5 * extent.width, y - 0.4 * extent.height) < 0.3 * extent.height) {
          labels[site] = 1;
          full.modulus.values[site] = 30.0F;
        }
        start.x[site] = uniform() - 0.5F;
        start.y[site] = uniform() - 0.5F;
        if (x == 0 || random() % 20 == 0) {
          full.target.x[site] = 8.0F * uniform();
          full.target.y[site] = -5.0F * uniform();
          full.confidence.x[site] = 1.0F;
          full.confidence.y[site] = x == 0 ? 0.0F : uniform();
        }
      }
    }
    set_inverse_modulus(full);
  }

  [[nodiscard]] Solution solved(const std::string& backend = "scalar") const {
    const auto backends = make_backends();
    const auto session = find_backend(backends, backend).open({});
    Progress silent(false);
    return solve(scene, *session, silent);
  }

  Scene scene;
  std::vector<int> labels;
};

inline Field::Pointer to_itk(const VectorField& pixels, const Geometry& geometry) {
  const auto field = geometry.allocate<Field>(pixels.extent);
  const Direction direction = geometry.direction();
  for (std::size_t site = 0; site < pixels.extent.sites(); ++site) {
    for (unsigned axis = 0; axis < 2; ++axis) {
      field->GetBufferPointer()[site][axis] =
          static_cast<float>(geometry.spacing * (direction(axis, 0) * double{pixels.x[site]} +
                                                 direction(axis, 1) * double{pixels.y[site]}));
    }
  }
  return field;
}

/// Along rows and columns, in pixels.
inline VectorField to_pixels(const Field& field, const Geometry& geometry) {
  const auto size = field.GetLargestPossibleRegion().GetSize();
  VectorField pixels({static_cast<int>(size[0]), static_cast<int>(size[1])});
  const Direction inverse(geometry.direction().GetInverse());
  for (std::size_t site = 0; site < pixels.extent.sites(); ++site) {
    const auto index = inverse * itk::Vector<double, 2>(field.GetBufferPointer()[site]) / geometry.spacing;
    pixels.x[site] = static_cast<float>(index[0]);
    pixels.y[site] = static_cast<float>(index[1]);
  }
  return pixels;
}

/// The problem as images, and a filter that has them as its inputs.
struct Pipeline {
  explicit Pipeline(Extent extent = {41, 30}, Geometry geometry_ = {})
      : geometry(geometry_), problem(extent), displacement(to_itk(problem.scene.start_field(), geometry)),
        labels(geometry.allocate<Labels>(extent)), observation(to_itk(problem.scene.full.target, geometry)),
        confidence(geometry.allocate<Filter::ConfidenceImageType>(extent)), filter(Filter::New()) {
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      labels->GetBufferPointer()[site] = static_cast<unsigned char>(problem.labels[site]);
      confidence->GetBufferPointer()[site][0] = problem.scene.full.confidence.x[site];
      confidence->GetBufferPointer()[site][1] = problem.scene.full.confidence.y[site];
    }
    filter->SetInput(displacement);
    filter->SetLabels(labels);
    filter->SetModulus(0, 10.0);
    filter->SetModulus(1, 30.0);
    filter->SetObservationImage(observation);
    filter->SetConfidenceImage(confidence);
    filter->SetNumberOfIterations(iterations);
  }

  [[nodiscard]] VectorField result() const {
    filter->Update();
    return to_pixels(*filter->GetOutput(), geometry);
  }

  /// What the exception says that Update must throw.
  [[nodiscard]] std::string refusal() const {
    try {
      filter->Update();
    } catch (const itk::ExceptionObject& error) {
      return error.GetDescription();
    }
    ADD_FAILURE() << "no itk::ExceptionObject";
    return {};
  }

  Geometry geometry;
  Problem problem;
  Field::Pointer displacement;
  Labels::Pointer labels;
  Field::Pointer observation;
  Filter::ConfidenceImageType::Pointer confidence;
  Filter::Pointer filter;
};

} // namespace hdmbench::test
