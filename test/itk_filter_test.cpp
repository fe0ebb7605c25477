#include "backends/registry.hpp"
#include "harness/check/compare.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/level.hpp"
#include "test/files.hpp"
#include "test/itk_pipeline.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <itkDisplacementFieldTransform.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {
namespace {

using namespace test;
using testing::HasSubstr;

class ItkFilter : public testing::Test, protected Pipeline {};

#define EXPECT_SAME_BITS(expected, found) EXPECT_EQ(compare(expected, found).sites, 0)

TEST(TheItkFilter, GivesInTenLinesWhatSolveGives) {
  const auto [geometry, problem, displacement, labels, observation, confidence, unused] = Pipeline();
  // harness/itk/README.md shows these lines.
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

TEST(TheItkFilter, IsInTheReadmeAsItIsHere) {
  const auto read = [](const char* name) {
    std::ifstream file(std::string(HDMBENCH_SOURCE) + name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string readme = read("/harness/itk/README.md");
  std::istringstream source(read("/test/itk_filter_test.cpp"));
  std::string line;
  while (std::getline(source, line) && line != "  // harness/itk/README.md shows these lines.") {
  }
  int lines = 0;
  while (std::getline(source, line) && !line.empty()) {
    EXPECT_THAT(readme, HasSubstr(fmt::format("\n{}\n", line.substr(2))));
    ++lines;
  }
  EXPECT_EQ(lines, 10);
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
    const auto time = filter->GetMTime();
    filter->Update();
    change();
    EXPECT_GT(filter->GetMTime(), time);
  }
  EXPECT_SAME_BITS(expected.displacement, result()); // recomputed after the last change
  EXPECT_LT(filter->GetElapsedIterations(), 3 * 90);
  EXPECT_EQ(filter->GetLevels().front().extent, expected.levels.front().extent);
  std::ostringstream printed;
  filter->Print(printed);
  for (const char* line : {"0: 10 MPa 1: 30 MPa", "NumberOfIterations: 90", "Epsilon: 0.01", "StartLevel: 2",
                           "DuringIterationUpdate: On", "Penalty: 3", "StepSet: fine", "Backend: scalar"}) {
    EXPECT_THAT(printed.str(), HasSubstr(line));
  }
}

TEST_F(ItkFilter, MinimisesTheElasticEnergy) {
  Scene scene = problem.scene;
  scene.poisson = 0.2;
  use_method(scene, find_method(elastic_conjugate_gradients), 9);
  const auto backends = make_backends();
  Progress quiet(false);
  const Solution expected = Solver(find_backend(backends, "openmp"), {}).solve(scene, quiet);
  filter->SetNumberOfIterations(9);
  filter->SetEnergy(EnergyModel::elastic);
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

TEST_F(ItkFilter, NothingIsComputedTwice) {
  filter->Update();
  const auto time = filter->GetOutput()->GetMTime();
  filter->SetModulus(1, 30.0);
  filter->SetBackend("openmp");
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetMTime(), time);
  filter->SetModulus(1, 31.0);
  filter->Update();
  EXPECT_GT(filter->GetOutput()->GetMTime(), time);
}

TEST_F(ItkFilter, AModulusImageTakesThePlaceOfLabels) {
  const auto moduli = geometry.allocate<Filter::ModulusImageType>(problem.scene.extent());
  std::ranges::copy(problem.scene.full.modulus.values, moduli->GetBufferPointer());
  filter->SetModulusImage(moduli);
  EXPECT_THAT(refusal(), HasSubstr("Both are set"));
  filter->SetLabels(nullptr);
  EXPECT_SAME_BITS(problem.solved().displacement, result());
  filter->SetModulusImage(nullptr);
  EXPECT_THAT(refusal(), HasSubstr("Neither is set"));
}

TEST_F(ItkFilter, WithoutObservationTheFieldIsSmoothed) {
  filter->SetObservationImage(nullptr);
  EXPECT_THAT(refusal(), HasSubstr("both or none"));
  filter->SetConfidenceImage(nullptr);
  filter->SetStartLevel(0);
  Scene& scene = problem.scene;
  scene.full.confidence = VectorField(scene.extent());
  scene.full.target = VectorField(scene.extent());
  scene.schedule.start_level = 0;
  EXPECT_SAME_BITS(problem.solved().displacement, result());
}

TEST_F(ItkFilter, TheWholeImageIsComputedWhateverIsAskedFor) {
  filter->UpdateOutputInformation();
  filter->GetOutput()->SetRequestedRegion(Field::RegionType({5, 5}, {2, 2}));
  filter->Update();
  EXPECT_SAME_BITS(problem.solved().displacement, to_pixels(*filter->GetOutput(), geometry));
}

TEST_F(ItkFilter, ProgressRisesToOne) {
  std::vector<float> seen;
  filter->AddObserver(itk::ProgressEvent(),
                      [&](const itk::EventObject&) { seen.push_back(filter->GetProgress()); });
  filter->Update();
  EXPECT_GE(seen.size(), filter->GetLevels().size());
  EXPECT_TRUE(std::ranges::is_sorted(seen));
  EXPECT_EQ(seen.back(), 1.0F);
  EXPECT_LT(seen.front(), 0.01F);
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

TEST_F(ItkFilter, UpdateDuringIterationIsForScalar) {
  filter->SetDuringIterationUpdate(true);
  EXPECT_THAT(refusal(), HasSubstr("SetBackend(\"scalar\")"));
}

TEST_F(ItkFilter, RefusesWithAReason) {
  filter->SetBackend("abacus");
  EXPECT_THAT(refusal(), HasSubstr("there is no backend \"abacus\"; the backends are scalar, openmp"));
  filter->SetBackend("openmp");
  filter->SetDevice("no such device");
  EXPECT_THAT(refusal(), HasSubstr("openmp has no device \"no such device\""));
  filter->SetDevice("");
  filter->SetStepSet("0,one");
  EXPECT_THAT(refusal(), HasSubstr("\"one\" is not a number"));
  filter->SetStepSet("default");
  filter->SetNumberOfIterations(-1);
  EXPECT_THAT(refusal(), HasSubstr("NumberOfIterations is -1"));
  filter->SetNumberOfIterations(iterations);
  filter->SetPenalty(-2.0);
  EXPECT_THAT(refusal(), HasSubstr("penalty"));
  filter->SetPenalty(1000.0);
  filter->SetModulus(1, 0.0);
  EXPECT_THAT(refusal(), HasSubstr("the modulus (MPa)"));
  filter->ClearModuli();
  filter->SetModulus(0, 10.0);
  EXPECT_THAT(refusal(), HasSubstr("the label 1 of the pixel x = "));
  EXPECT_THAT(refusal(), HasSubstr("SetModulus(1, ...)"));
  filter->SetModulus(1, 30.0);
  EXPECT_SAME_BITS(problem.solved().displacement, result());
}

TEST_F(ItkFilter, RefusesValuesThatCannotBe) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refusal_with = [&](Field& image, std::size_t site, unsigned component, float value) {
    float& place = image.GetBufferPointer()[site][component];
    const float before = std::exchange(place, value);
    image.Modified();
    const std::string words = refusal();
    place = before;
    return words;
  };
  EXPECT_THAT(refusal_with(*displacement, 41 * 3 + 7, 0, nan),
              HasSubstr("the displacement to be regularised at x = 7, y = 3 is nan"));
  EXPECT_THAT(refusal_with(*observation, 41 * 2 + 1, 1, nan),
              HasSubstr("the target displacement at x = 1, y = 2 is nan"));
  EXPECT_THAT(refusal_with(*confidence, 5, 1, 1.5F), HasSubstr("the confidence in y at x = 5, y = 0 is 1.5"));
}

TEST_F(ItkFilter, RefusesImagesThatDoNotMatch) {
  const auto small = geometry.allocate<Labels>({41, 29});
  filter->SetLabels(small);
  EXPECT_THAT(refusal(), HasSubstr("the input Labels has [41, 29] pixels"));
  const auto elsewhere = Geometry{.spacing = 2.0}.allocate<Labels>({41, 30});
  filter->SetLabels(elsewhere);
  EXPECT_THAT(refusal(), HasSubstr("same physical space"));
}

TEST_F(ItkFilter, RefusesPixelsThatAreNotSquare) {
  const auto lay = [&](auto&& change) {
    for (itk::ImageBase<2>* const image :
         std::initializer_list<itk::ImageBase<2>*>{displacement.GetPointer(), labels.GetPointer(),
                                                   observation.GetPointer(), confidence.GetPointer()}) {
      change(*image);
    }
  };
  lay([](itk::ImageBase<2>& image) { image.SetSpacing(std::array{1.0, 1.1}.data()); });
  EXPECT_THAT(refusal(), HasSubstr("the pixels are 1 x 1.1, they must be square"));
  Direction sheared;
  sheared.SetIdentity();
  sheared(0, 1) = 0.2;
  lay([&](itk::ImageBase<2>& image) {
    image.SetSpacing(std::array{1.0, 1.0}.data());
    image.SetDirection(sheared);
  });
  EXPECT_THAT(refusal(), HasSubstr("not orthonormal"));
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
  const TemporaryFolder folder;
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

TEST(ItkFilterSizes, AnySizeGoes) {
  for (const Extent extent : {Extent{1, 1}, Extent{1, 9}, Extent{9, 1}, Extent{64, 64}, Extent{65, 3}}) {
    SCOPED_TRACE(testing::Message() << extent.width << " x " << extent.height);
    const Pipeline pipeline(extent);
    EXPECT_SAME_BITS(pipeline.problem.solved().displacement, pipeline.result());
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
