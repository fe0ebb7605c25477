// harness/itk's filter: the bits of solve() whatever the geometry, the types and the parameters, and where
// fields lie.

#include "backends/registry.hpp"
#include "harness/check/compare.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/solve.hpp"
#include "test/files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <itkDisplacementFieldTransform.h>
#include <itkHDMRegularizationFilter.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <utility>

namespace hdmbench {
namespace {

using testing::HasSubstr;

using Filter = itk::HDMRegularizationFilter<>;
using Field = Filter::DisplacementFieldType;
using Labels = Filter::LabelImageType;
using Direction = Field::DirectionType;

constexpr int iterations = 40;

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

Field::Pointer to_itk(const VectorField& pixels, const Geometry& geometry) {
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
VectorField to_pixels(const Field& field, const Geometry& geometry) {
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

class ItkFilter : public testing::Test, protected Pipeline {};

#define EXPECT_SAME_BITS(expected, found) EXPECT_EQ(compare(expected, found).sites, 0)

TEST(TheItkFilter, GivesInTenLinesWhatSolveGives) {
  const auto [geometry, problem, displacement, labels, observation, confidence, unused] = Pipeline();
  const auto filter = itk::HDMRegularizationFilter<>::New();
  filter->SetInput(displacement);
  filter->SetLabels(labels);
  filter->SetModulus(0, 10.0);
  filter->SetModulus(1, 30.0);
  filter->SetObservationImage(observation);
  filter->SetConfidenceImage(confidence);
  filter->SetNumberOfIterations(40);
  filter->Update();
  const auto* const regularised = filter->GetOutput();

  const Solution expected = problem.solved();
  EXPECT_SAME_BITS(expected.displacement, to_pixels(*regularised, geometry));
  EXPECT_GT(compare(expected.displacement, problem.scene.start_field()).sites, 1000);
  EXPECT_EQ(filter->GetLevels().size(), expected.levels.size());
  EXPECT_EQ(filter->GetElapsedIterations(), static_cast<int>(expected.levels.size()) * iterations);
  EXPECT_EQ(filter->GetMeanEnergy(), mean_energy(problem.scene.full, expected.displacement));
  EXPECT_STRNE(filter->GetDeviceUsed(), "");
  EXPECT_EQ(regularised->GetOrigin(), displacement->GetOrigin());
  EXPECT_EQ(regularised->GetSpacing(), displacement->GetSpacing());
  EXPECT_EQ(regularised->GetDirection(), displacement->GetDirection());
}

TEST_F(ItkFilter, EveryParameterReachesTheSolver) {
  Scene& scene = problem.scene;
  scene.schedule = {.iterations = 90,
                    .stop = Stop::energy,
                    .epsilon = 1e-2,
                    .start_level = 2,
                    .alignment = Alignment::center};
  scene.full.update = Update::sequential;
  scene.full.penalty = 3.0F;
  scene.full.steps = StepSet::parse("fine");
  const Solution expected = problem.solved();
  const std::vector<std::function<void()>> changes{[&] { filter->SetNumberOfIterations(90); },
                                                   [&] { filter->SetStopCriterion(Stop::energy); },
                                                   [&] { filter->SetEpsilon(1e-2); },
                                                   [&] { filter->SetStartLevel(2); },
                                                   [&] { filter->SetAlignment(Alignment::center); },
                                                   [&] { filter->SetBackend("scalar"); },
                                                   [&] { filter->DuringIterationUpdateOn(); },
                                                   [&] { filter->SetPenalty(3.0); },
                                                   [&] { filter->SetStepSet("fine"); }};
  for (const auto& change : changes) {
    filter->Update();
    const auto time = filter->GetOutput()->GetMTime();
    filter->SetModulus(1, 30.0); // as it is: nothing is computed twice
    filter->Update();
    EXPECT_EQ(filter->GetOutput()->GetMTime(), time);
    change();
    EXPECT_GT(filter->GetMTime(), time);
  }
  EXPECT_SAME_BITS(expected.displacement, result()); // recomputed after the last change
  EXPECT_LT(filter->GetElapsedIterations(), 3 * 90);
  EXPECT_EQ(filter->GetLevels().front().extent, expected.levels.front().extent);
}

TEST_F(ItkFilter, MinimisesTheElasticEnergy) {
  Scene scene = problem.scene;
  scene.poisson = 0.2;
  use_method(scene, find_method(elastic_conjugate_gradients), 9);
  const auto backends = make_backends();
  Progress quiet(false);
  const Solution expected = Solver(find_backend(backends, "openmp"), {}).solve(scene, quiet);
  filter->SetNumberOfIterations(9);
  filter->SetEnergy("elastic");
  filter->SetPoissonRatio(0.2);
  EXPECT_SAME_BITS(expected.displacement, result());
  filter->SetPoissonRatio(0.3);
  EXPECT_GT(compare(expected.displacement, result()).sites, 0);
  filter->SetPoissonRatio(0.6);
  EXPECT_THROW(filter->Update(), itk::ExceptionObject);
}

TEST_F(ItkFilter, EveryBackendGivesTheSameBits) {
  const VectorField expected = problem.solved().displacement;
  for (const auto& backend : make_backends()) {
    try {
      (void)backend->devices();
    } catch (const DeviceError&) {
      continue; // backends_test says so visibly
    }
    filter->SetBackend(std::string(backend->name()));
    EXPECT_SAME_BITS(expected, result()) << backend->name();
  }
}

TEST_F(ItkFilter, AModulusImageTakesThePlaceOfLabelsAndNothingThatOfObservations) {
  const auto moduli = geometry.allocate<Filter::ModulusImageType>(problem.scene.extent());
  std::ranges::copy(problem.scene.full.modulus.values, moduli->GetBufferPointer());
  filter->SetModulusImage(moduli);
  EXPECT_THAT(refusal(), HasSubstr("Both are set"));
  filter->SetLabels(nullptr);
  EXPECT_SAME_BITS(problem.solved().displacement, result());
  filter->SetObservationImage(nullptr);
  EXPECT_THAT(refusal(), HasSubstr("both or none"));
  filter->SetConfidenceImage(nullptr);
  filter->SetStartLevel(0);
  Scene& scene = problem.scene;
  scene.full.confidence = VectorField(scene.extent());
  scene.full.target = VectorField(scene.extent());
  scene.schedule.start_level = 0;
  filter->UpdateOutputInformation(); // the whole image is computed whatever is asked for
  filter->GetOutput()->SetRequestedRegion(Field::RegionType({5, 5}, {2, 2}));
  EXPECT_SAME_BITS(problem.solved().displacement, result());
  filter->SetModulusImage(nullptr);
  EXPECT_THAT(refusal(), HasSubstr("Neither is set"));
}

TEST(ItkFilterRefusals, HaveAReason) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  using Images = std::initializer_list<itk::ImageBase<2>*>;
  const auto shear = [](Pipeline& p) {
    Direction sheared;
    sheared.SetIdentity();
    sheared(0, 1) = 0.2;
    for (auto* image : Images{p.displacement, p.labels, p.observation, p.confidence}) {
      image->SetDirection(sheared);
    }
  };
  const auto stretch = [](Pipeline& p) {
    for (auto* image : Images{p.displacement, p.labels, p.observation, p.confidence}) {
      image->SetSpacing(std::array{1.0, 1.1}.data());
    }
  };
  const auto lay_labels = [](const Geometry& geometry, Extent extent) {
    return [=](Pipeline& p) { p.filter->SetLabels(geometry.allocate<Labels>(extent)); };
  };
  const auto forget_one = [](Pipeline& p) {
    p.filter->ClearModuli();
    p.filter->SetModulus(0, 10.0);
  };
  const std::pair<const char*, std::function<void(Pipeline&)>> cases[] = {
      {"there is no backend \"abacus\"; the backends are scalar",
       [](auto& p) { p.filter->SetBackend("abacus"); }},
      {"openmp has no device \"none\"", [](auto& p) { p.filter->SetDevice("none"); }},
      {"\"one\" is not a number", [](auto& p) { p.filter->SetStepSet("0,one"); }},
      {"NumberOfIterations is -1", [](auto& p) { p.filter->SetNumberOfIterations(-1); }},
      {"SetBackend(\"scalar\")", [](auto& p) { p.filter->SetDuringIterationUpdate(true); }},
      {"penalty", [](auto& p) { p.filter->SetPenalty(-2.0); }},
      {"the modulus (MPa)", [](auto& p) { p.filter->SetModulus(1, 0.0); }},
      {"the label 1 of the pixel x = ", forget_one},
      {"SetModulus(1, ...)", forget_one},
      {"to be regularised at x = 7, y = 3 is nan",
       [](auto& p) { p.displacement->GetBufferPointer()[41 * 3 + 7][0] = nan; }},
      {"the target displacement at x = 1, y = 2 is nan",
       [](auto& p) { p.observation->GetBufferPointer()[41 * 2 + 1][1] = nan; }},
      {"the confidence in y at x = 5, y = 0 is 1.5",
       [](auto& p) { p.confidence->GetBufferPointer()[5][1] = 1.5F; }},
      {"the input Labels has [41, 29] pixels", lay_labels({}, {41, 29})},
      {"same physical space", lay_labels({.spacing = 2.0}, {41, 30})},
      {"the pixels are 1 x 1.1, they must be square", stretch},
      {"not orthonormal", shear},
  };
  for (const auto& [says, change] : cases) {
    Pipeline pipeline;
    pipeline.filter->SetBackend("openmp");
    change(pipeline);
    EXPECT_THAT(pipeline.refusal(), HasSubstr(says));
  }
}

TEST_F(ItkFilter, AbortsBetweenLevelsAndCanBeRunAgain) {
  bool abort = true;
  int events = 0;
  filter->AddObserver(itk::ProgressEvent(), [&](const itk::EventObject&) {
    ++events;
    filter->SetAbortGenerateData(abort && filter->GetProgress() > 0.01F);
  });
  EXPECT_THROW(filter->Update(), itk::ProcessAborted);
  const int until_aborted = events;
  abort = false;
  EXPECT_SAME_BITS(problem.solved().displacement, result());
  EXPECT_LT(until_aborted, events - until_aborted);
}

TEST(ItkFilterGeometry, PhysicalUnitsAndAxesAreConverted) {
  const double half_turn = std::acos(-1.0);
  for (const Geometry& geometry :
       {Geometry{.spacing = 0.5}, Geometry{.spacing = 4.0, .flipped = true}, Geometry{.angle = half_turn},
        Geometry{.first_index = -3}, Geometry{.spacing = 0.5, .angle = 0.6},
        Geometry{.spacing = 0.7, .angle = -2.0, .flipped = true, .first_index = 5}}) {
    SCOPED_TRACE(testing::Message() << geometry.spacing << " mm, " << geometry.angle
                                    << (geometry.flipped ? ", flipped" : ""));
    const Pipeline pipeline({37, 52}, geometry);
    const FieldDifference difference = compare(pipeline.problem.solved().displacement, pipeline.result());
    const bool exact = geometry.angle == 0.0 || geometry.angle == half_turn;
    EXPECT_LE(difference.largest, exact ? 0.0 : 1e-5); // else the rotation of this test rounds
  }
  for (const Extent extent : {Extent{1, 1}, Extent{1, 9}, Extent{9, 1}, Extent{65, 3}}) {
    const Pipeline pipeline(extent);
    EXPECT_SAME_BITS(pipeline.problem.solved().displacement, pipeline.result()) << extent.width;
  }
}

/// Oblique: 12 degrees about the third axis, then 30 about the first; one axis is flipped.
struct Oblique {
  using Volume = itk::Image<unsigned char, 3>;

  static Volume::Pointer allocate(const itk::Size<3>& size) {
    const auto volume = Volume::New();
    volume->SetRegions(size);
    volume->SetOrigin(std::array{-70.0, 33.0, 8.5}.data());
    volume->SetSpacing(std::array{0.8, 0.8, 2.5}.data());
    const double c = std::cos(std::acos(-1.0) / 15.0);
    const double s = std::sin(std::acos(-1.0) / 15.0);
    const double half = 0.5;
    const double rest = std::sqrt(0.75);
    const std::array<double, 9> rows{c, -s, 0.0, rest * s, rest * c, half, half * s, half * c, -rest};
    Volume::DirectionType direction;
    std::ranges::copy(rows, direction.GetVnlMatrix().data_block());
    volume->SetDirection(direction);
    volume->Allocate(true);
    return volume;
  }
};

/// As ITK warps: what a pixel's displacement does to its point in physical space.
TEST(ItkGeometry, AFieldLiesAndPointsWhereItsImageDoes) {
  const test::TemporaryFolder folder;
  struct Case {
    const char* file;
    itk::ImageIOBase::Pointer format;
    itk::SizeValueType slices;
    std::optional<Extent> size;
    const char* field = "field.nrrd";
  };
  const itk::ImageIOBase::Pointer nrrd = itk::NrrdImageIO::New().GetPointer();
  const itk::ImageIOBase::Pointer meta = itk::MetaImageIO::New().GetPointer();
  const itk::ImageIOBase::Pointer nifti = itk::NiftiImageIO::New().GetPointer();
  for (const Case& one :
       {Case{"a.nrrd", nrrd, 5, {}}, Case{"a.mha", meta, 5, {}, "field.mha"}, Case{"a.nii", nifti, 5, {}},
        Case{"flat.nrrd", nrrd, 1, {}}, Case{"a.nii.gz", nifti, 5, Extent{60, 20}},
        Case{"a.nrrd", nrrd, 5, Extent{10, 10}}}) {
    SCOPED_TRACE(testing::Message() << one.file << (one.size ? ", resampled" : ""));
    const auto image = Oblique::allocate({20, 12, one.slices});
    const auto writer = itk::ImageFileWriter<Oblique::Volume>::New();
    writer->SetFileName(folder.path() / one.file);
    writer->SetImageIO(one.format);
    writer->SetInput(image);
    writer->Update();
    const itk::IndexValueType slice = one.slices > 1 ? 3 : 0;
    const Scene scene = load_scene(
        folder
            .write("scene.toml",
                   fmt::format("[image]\nlabels = \"{}\"\nslice = {}\n[[tissue]]\nlabel = 0\n"
                               "modulus = 1.0\n[[condition]]\nwhere = \"border\"\ndx = 1.5\ndy = -0.75\n",
                               one.file, slice))
            .string(),
        {.size = one.size});
    const std::string file = folder.path() / one.field;
    write_displacement(file, scene.full.target, scene.spacing, scene.placement);

    using FieldTransform = itk::DisplacementFieldTransform<double, 3>;
    const auto reader = itk::ImageFileReader<FieldTransform::DisplacementFieldType>::New();
    reader->SetFileName(file);
    reader->SetImageIO(std::string_view(one.field).ends_with("mha") ? meta : nrrd);
    reader->Update();
    EXPECT_NEAR(reader->GetOutput()->GetSpacing()[2], 2.5, 1e-6) << "the thickness of the slice";
    const auto transform = FieldTransform::New();
    transform->SetDisplacementField(reader->GetOutput());
    const Extent extent = scene.extent();
    const double step = std::max(20.0 / extent.width, 12.0 / extent.height);
    for (const auto& [x, y] : {std::pair{0, 0},
                               {extent.width - 1, 0},
                               {extent.width - 1, extent.height - 1},
                               {3, extent.height - 1}}) {
      itk::ContinuousIndex<double, 3> index; // of the site in the file
      index[0] = (x + 0.5 - 0.5 * extent.width) * step + 9.5;
      index[1] = (y + 0.5 - 0.5 * extent.height) * step + 5.5;
      index[2] = static_cast<double>(slice);
      const auto point = image->TransformContinuousIndexToPhysicalPoint<double>(index);
      const auto own = reader->GetOutput()->TransformIndexToPhysicalPoint<double>({x, y, 0});
      EXPECT_LT(own.EuclideanDistanceTo(point), 1e-4) << x << ", " << y;
      const auto moved =
          image->TransformPhysicalPointToContinuousIndex<double>(transform->TransformPoint(own));
      EXPECT_NEAR(moved[0], index[0] + 1.5 * step, 1e-4) << x << ", " << y;
      EXPECT_NEAR(moved[1], index[1] - 0.75 * step, 1e-4) << x << ", " << y;
      EXPECT_NEAR(moved[2], index[2], 1e-4) << x << ", " << y;
    }
  }
}

TEST(ItkFilterTypes, MayBeOthers) {
  using OtherFilter =
      itk::HDMRegularizationFilter<itk::Image<itk::Vector<double, 2>, 2>, itk::Image<short, 2>>;
  const auto field = Geometry{}.allocate<OtherFilter::DisplacementFieldType>({20, 10});
  const auto labels = Geometry{}.allocate<OtherFilter::LabelImageType>({20, 10});
  labels->FillBuffer(-300);
  OtherFilter::DisplacementType everywhere;
  everywhere[0] = 0.5;
  everywhere[1] = -0.25;
  field->FillBuffer(everywhere);
  const auto filter = OtherFilter::New();
  filter->SetInput(field);
  filter->SetLabels(labels);
  filter->SetModulus(-300, 10.0);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetPixel({19, 9}),
            everywhere); // rigid motion costs nothing
}

} // namespace
} // namespace hdmbench
