// harness/itk's filter: the bits of solve() whatever the geometry, the types and the parameters, and where
// fields lie.

#include "harness/scene/method.hpp"
#include "harness/solve/request.hpp"
#include "harness/solve/unloading.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"

#include <itkDisplacementFieldTransform.h>
#include <itkHDMRegularizationFilter.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkOutputWindow.h>

namespace hdmbench {
namespace {

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

Field::Pointer to_itk(const VectorField& pixels, const Geometry& geometry) {
  const auto field = geometry.allocate<Field>(pixels.extent);
  const Direction direction = geometry.direction();
  for (std::size_t site = 0; site < pixels.extent.sites(); ++site) {
    for (unsigned axis = 0; axis < 2; ++axis) {
      field->GetBufferPointer()[site][axis] =
          static_cast<float>(geometry.spacing * (direction(axis, 0) * double{pixels[0][site]} +
                                                 direction(axis, 1) * double{pixels[1][site]}));
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
    pixels[0][site] = static_cast<float>(index[0]);
    pixels[1][site] = static_cast<float>(index[1]);
  }
  return pixels;
}

/// A random problem of two tissues.
Scene two_tissues(Extent extent) {
  Scene scene = test::textured_scene("filtered", extent, test::Texture::smooth, 3, iterations);
  std::ranges::for_each(scene.full.modulus.values,
                        [](float& value) { value = value > 25.0F ? 30.0F : 10.0F; });
  set_inverse_modulus(scene.full);
  scene.full.penalty = 1000.0F;
  return scene;
}

/// A scene's images, and a filter that has them as its inputs.
struct Pipeline {
  explicit Pipeline(Extent extent = {41, 30}, Geometry geometry_ = {})
      : geometry(geometry_), scene(two_tissues(extent)), displacement(to_itk(scene.start_field(), geometry)),
        labels(geometry.allocate<Labels>(extent)), observation(to_itk(scene.full.target, geometry)),
        confidence(geometry.allocate<Filter::ConfidenceImageType>(extent)), filter(Filter::New()) {
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      labels->GetBufferPointer()[site] = scene.full.modulus.values[site] > 25.0F ? 1 : 0;
      confidence->GetBufferPointer()[site][0] = scene.full.confidence[0][site];
      confidence->GetBufferPointer()[site][1] = scene.full.confidence[1][site];
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
    return "accepted";
  }

  Geometry geometry;
  Scene scene;
  Field::Pointer displacement;
  Labels::Pointer labels;
  Field::Pointer observation;
  Filter::ConfidenceImageType::Pointer confidence;
  Filter::Pointer filter;
};

#define EXPECT_SAME_BITS(expected, found) EXPECT_EQ(compare(expected, found).sites, 0)

TEST(ItkFilter, GivesWhatSolveGives) {
  const Pipeline p;
  const Solution expected = test::solved(p.scene);
  EXPECT_SAME_BITS(expected.displacement, p.result());
  EXPECT_GT(compare(expected.displacement, p.scene.start_field()).sites, 1000);
  EXPECT_EQ(p.filter->GetLevels().size(), expected.levels.size());
  EXPECT_EQ(p.filter->GetLevels().front().extent, expected.levels.front().extent);
  EXPECT_EQ(p.filter->GetElapsedIterations(), static_cast<int>(expected.levels.size()) * iterations);
  EXPECT_EQ(p.filter->GetMeanEnergy(), mean_energy(p.scene.full, expected.displacement));
  EXPECT_STRNE(p.filter->GetDeviceUsed(), "");
  EXPECT_EQ(p.filter->GetOutput()->GetOrigin(), p.displacement->GetOrigin());
  EXPECT_EQ(p.filter->GetOutput()->GetSpacing(), p.displacement->GetSpacing());
  EXPECT_EQ(p.filter->GetOutput()->GetDirection(), p.displacement->GetDirection());
}

void use_elastic(Scene& scene) {
  scene.elastic.poisson = 0.2;
  use_method(scene, find_method(elastic_conjugate_gradients), 9);
}

/// Each beside those before it, so that every one computes something else than the one before.
TEST(ItkFilter, EverySettingReachesTheSolver) {
  const std::pair<std::function<void(Pipeline&)>, std::function<void(Scene&)>> settings[] = {
      {[](auto& p) { p.filter->SetNumberOfIterations(90); }, [](auto& s) { s.schedule.iterations = 90; }},
      {[](auto& p) { p.filter->SetPenalty(3.0); }, [](auto& s) { s.full.penalty = 3.0F; }},
      {[](auto& p) {
         p.filter->SetNumberOfIterations(9);
         p.filter->SetEnergy("elastic");
         p.filter->SetPoissonRatio(0.2);
       },
       use_elastic},
      {[](auto& p) { p.filter->SetPoissonRatio(0.3); }, [](auto& s) { s.elastic.poisson = 0.3; }}};
  Pipeline pipeline;
  VectorField before = pipeline.result();
  int row = 0;
  for (const auto& [change_filter, change_scene] : settings) {
    SCOPED_TRACE(row++);
    const auto time = pipeline.filter->GetOutput()->GetMTime();
    pipeline.filter->SetModulus(1, 30.0); // as it is: nothing is computed twice
    pipeline.filter->Update();
    EXPECT_EQ(pipeline.filter->GetOutput()->GetMTime(), time);
    change_filter(pipeline);
    EXPECT_GT(pipeline.filter->GetMTime(), time);
    change_scene(pipeline.scene);
    const VectorField found = pipeline.result();
    EXPECT_SAME_BITS(test::solved(pipeline.scene).displacement, found);
    EXPECT_GT(compare(before, found).sites, 0);
    before = found;
  }
}

TEST(ItkFilter, AModulusImageTakesThePlaceOfLabelsAndNothingThatOfObservations) {
  Pipeline p;
  const auto moduli = p.geometry.allocate<Filter::ModulusImageType>(p.scene.extent());
  std::ranges::copy(p.scene.full.modulus.values, moduli->GetBufferPointer());
  p.filter->SetModulusImage(moduli);
  EXPECT_THAT(p.refusal(), HasSubstr("Both are set"));
  p.filter->SetLabels(nullptr);
  EXPECT_SAME_BITS(test::solved(p.scene).displacement, p.result());
  p.filter->SetObservationImage(nullptr);
  EXPECT_THAT(p.refusal(), HasSubstr("both or none"));
  p.filter->SetConfidenceImage(nullptr);
  p.scene.full.confidence = VectorField(p.scene.extent());
  p.scene.full.target = VectorField(p.scene.extent());
  p.filter->UpdateOutputInformation(); // the whole image is computed whatever is asked for
  p.filter->GetOutput()->SetRequestedRegion(Field::RegionType({5, 5}, {2, 2}));
  EXPECT_SAME_BITS(test::solved(p.scene).displacement, p.result());
  p.filter->SetModulusImage(nullptr);
  EXPECT_THAT(p.refusal(), HasSubstr("Neither is set"));
}

/// Tissue by a law, in a hole along which it slides, of which a part is taken out.
constexpr const char* organ_text = R"(
[[tissue]]
label = 0
modulus = 0.0
[[tissue]]
label = 1
modulus = 0.003
density = 1000.0
law = "neo-hookean"
fibre_modulus = 0.001
[[tissue]]
label = 2
modulus = 0.01
density = 1000.0
[[condition]]
where = "labels"
labels = [0]
slide = true
[[load]]
gravity = [9.81, 0.0, 0.0]
before = true
[[load]]
gravity = [0.0, 9.81, 0.0]
[[resect]]
label = 2
)";

TEST(ItkFilterRefusals, HaveAReason) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const auto of_all_images = [](const std::function<void(itk::ImageBase<2>&)>& change) {
    return [=](Pipeline& p) {
      for (auto* image :
           std::initializer_list<itk::ImageBase<2>*>{p.displacement, p.labels, p.observation, p.confidence}) {
        change(*image);
      }
    };
  };
  Direction sheared;
  sheared.SetIdentity();
  sheared(0, 1) = 0.2;
  const auto lay_labels = [](const Geometry& geometry, Extent extent) {
    return [=](Pipeline& p) { p.filter->SetLabels(geometry.allocate<Labels>(extent)); };
  };
  const auto forget_one = [](Pipeline& p) {
    p.filter->ClearModuli();
    p.filter->SetModulus(0, 10.0);
  };
  constexpr const char* two_tissues_text =
      "[[tissue]]\nlabel = 0\nmodulus = 10.0\n[[tissue]]\nlabel = 1\nmodulus = 30.0\n";
  const auto of_scene = [](const std::string& text) {
    return [=](Pipeline& p) {
      p.filter->ClearModuli();
      p.filter->SetNumberOfIterations(Filter::New()->GetNumberOfIterations());
      p.filter->SetSceneText(text);
    };
  };
  const std::pair<const char*, std::function<void(Pipeline&)>> cases[] = {
      {"there is no backend \"abacus\"; the backends are scalar",
       [](auto& p) { p.filter->SetBackend("abacus"); }},
      {"openmp has no device \"none\"", [](auto& p) { p.filter->SetDevice("none"); }},
      {"NumberOfIterations is -1", [](auto& p) { p.filter->SetNumberOfIterations(-1); }},
      {"Poisson",
       [](auto& p) {
         p.filter->SetEnergy("elastic");
         p.filter->SetPoissonRatio(0.6);
       }},
      {"there is no energy", [](auto& p) { p.filter->SetEnergy("plastic"); }},
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
      {"the pixels are [1, 1.1], they must be square", of_all_images([](auto& image) {
         image.SetSpacing(std::array{1.0, 1.1}.data());
       })},
      {"Accuracy is -1", [](auto& p) { p.filter->SetAccuracy(-1.0); }},
      {"which the elastic energy", [](auto& p) { p.filter->SetAccuracy(0.1); }},
      {"have no effect beside SetSceneText()", [](auto& p) { p.filter->SetSceneText(organ_text); }},
      {"scene:3: ", of_scene("[[tissue]]\nlabel = 0\nmodulus =\n")},
      {"scene:", of_scene("[[tissue]]\nlabel = 0\nmodulus = 1.0\n")},
      {"is resampled, 41 x 30 pixels to 41 x 60",
       [=](Pipeline& p) {
         of_scene(fmt::format("energy = \"hdm\"\n{}", two_tissues_text))(p);
         for (auto* image : std::initializer_list<itk::ImageBase<2>*>{p.displacement, p.labels, p.observation,
                                                                      p.confidence}) {
           image->SetSpacing(std::array{1.0, 2.0}.data());
         }
       }},
      {"not orthonormal", of_all_images([=](auto& image) { image.SetDirection(sheared); })},
  };
  for (const auto& [says, change] : cases) {
    Pipeline pipeline;
    pipeline.filter->SetBackend("openmp");
    change(pipeline);
    EXPECT_THAT(pipeline.refusal(), HasSubstr(says));
  }
}

/// Keeps what ITK warns of.
class Warnings final : public itk::OutputWindow {
public:
  using Pointer = itk::SmartPointer<Warnings>;
  void DisplayWarningText(const char* warning) override { text += warning; }
  std::string text;
};

/// Returns what the filter warns of.
std::string warnings_of(const Pipeline& pipeline) {
  const Warnings::Pointer warnings(new Warnings);
  warnings->UnRegister(); // the pointer holds it
  const itk::OutputWindow::Pointer before = itk::OutputWindow::GetInstance();
  itk::OutputWindow::SetInstance(warnings);
  pipeline.filter->Update();
  itk::OutputWindow::SetInstance(before);
  return warnings->text;
}

template <typename Picture>
void write_image(const std::filesystem::path& file, const Picture& image) {
  const auto writer = itk::ImageFileWriter<Picture>::New();
  writer->SetFileName(file);
  writer->SetImageIO(itk::NrrdImageIO::New());
  writer->SetInput(&image);
  writer->Update();
}

/// Writes the images beside a scene file and returns what `run FILE --accuracy 0.02mm` finds there.
template <typename LabelImage, typename FieldImage>
Solution solved_by_files(const LabelImage& labels, const std::map<std::string, const FieldImage*>& fields,
                         const std::string& text) {
  const test::TemporaryFolder folder;
  std::string scene_text = "energy = \"elastic\"\n[image]\nlabels = \"labels.nrrd\"\n";
  write_image(folder.path() / "labels.nrrd", labels);
  for (const auto& [key, field] : fields) {
    write_image(folder.path() / (key + ".nrrd"), *field);
    scene_text += fmt::format("{0} = \"{0}.nrrd\"\n", key);
  }
  Scene scene = load_scene(folder.write("organ.toml", scene_text + text).string());
  Progress progress;
  unload(scene, progress);
  return solve_request(scene, parse_request("0.02mm", "", scene.spacing), test::find("openmp"), {}, progress)
      .solution();
}

TEST(ItkFilter, TakesWhatASceneFileSays) {
  constexpr Extent extent{41, 30};
  for (const Geometry& geometry : {Geometry{.spacing = 2.0, .flipped = true},
                                   Geometry{.spacing = 0.5, .angle = 0.6, .first_index = 5}}) {
    Pipeline p(extent, geometry);
    p.filter->ClearModuli();
    p.filter->SetNumberOfIterations(Filter::New()->GetNumberOfIterations());
    const auto force = geometry.allocate<Field>(extent);
    const auto fibre = geometry.allocate<Field>(extent);
    VectorField outward(extent); // across the wall
    p.confidence->FillBuffer(itk::Vector<float, 2>(0.0F));
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      const double distance = std::hypot((x - 20.0) / 1.5, y - 15.0);
      p.labels->GetBufferPointer()[site] = distance > 11.0 ? 0 : std::hypot(x - 24, y - 9) < 4.0 ? 2 : 1;
      force->GetBufferPointer()[site][1] = distance < 8.0 ? 1e-6F * static_cast<float>(x) : 0.0F;
      fibre->GetBufferPointer()[site][0] = 1.0F;
      outward[0][site] = static_cast<float>((x - 20) / 2.25);
      outward[1][site] = static_cast<float>(y - 15);
      if (y == 15 && std::abs(x - 20) == 6) {
        p.observation->GetBufferPointer()[site].Fill(x < 20 ? 0.5F : -0.25F);
        p.confidence->GetBufferPointer()[site].Fill(1.0F);
      }
    });
    p.filter->SetForceImage(force);
    EXPECT_THAT(p.refusal(), HasSubstr("are for SetSceneText()"));
    p.filter->SetSceneText(organ_text);
    p.filter->SetFibreImage(fibre);
    const Field::Pointer normals = to_itk(outward, geometry);
    p.filter->SetNormalImage(normals);
    p.filter->SetAccuracy(0.02);
    const VectorField found = p.result();
    const Solution expected =
        solved_by_files<Labels, Field>(*p.labels,
                                       {{"target", p.observation},
                                        {"confidence", p.confidence},
                                        {"force", force},
                                        {"fibre", fibre},
                                        {"normals", normals}},
                                       std::string("target_unit = \"mm\"\n") + organ_text);
    EXPECT_LE(compare(expected.displacement, found).largest, geometry.angle == 0.0 ? 0.0 : 1e-5);
    EXPECT_GT(largest_magnitude(found), 0.2);
    EXPECT_EQ(p.filter->GetEstimatedError(), *expected.estimated_error * geometry.spacing);
    p.filter->SetNormalImage(nullptr);
    const VectorField by_labels = p.result();
    EXPECT_GT(compare(found, by_labels).largest, 1e-5);
    p.filter->SetForceImage(nullptr);
    EXPECT_GT(compare(by_labels, p.result()).largest, 1e-3);
  }
}

TEST(ItkFilter, TakesRectanglesWithTheElasticEnergy) {
  Pipeline p;
  for (auto* image :
       std::initializer_list<itk::ImageBase<2>*>{p.displacement, p.labels, p.observation, p.confidence}) {
    image->SetSpacing(std::array{1.0, 2.5}.data());
  }
  p.filter->SetEnergy("elastic");
  p.filter->SetPoissonRatio(0.2);
  p.filter->SetNumberOfIterations(9);
  use_elastic(p.scene);
  const VectorField of_squares = test::solved(p.scene).displacement;
  p.scene.full.sides = {1.0, 2.5, 1.0};
  const VectorField expected = test::solved(p.scene).displacement;
  EXPECT_SAME_BITS(expected, p.result());
  EXPECT_GT(compare(expected, of_squares).sites, 1000);
}

TEST(ItkFilter, AbortsBetweenLevelsAndCanBeRunAgain) {
  const Pipeline p;
  bool abort = true;
  int events = 0;
  p.filter->AddObserver(itk::ProgressEvent(), [&](const itk::EventObject&) {
    ++events;
    p.filter->SetAbortGenerateData(abort && p.filter->GetProgress() > 0.01F);
  });
  EXPECT_THROW(p.filter->Update(), itk::ProcessAborted);
  const int until_aborted = events;
  abort = false;
  EXPECT_SAME_BITS(test::solved(p.scene).displacement, p.result());
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
    const FieldDifference difference = compare(test::solved(pipeline.scene).displacement, pipeline.result());
    const bool exact = geometry.angle == 0.0 || geometry.angle == half_turn;
    EXPECT_LE(difference.largest, exact ? 0.0 : 1e-5); // else the rotation of this test rounds
  }
  for (const Extent extent : {Extent{1, 1}, Extent{1, 9}, Extent{9, 1}, Extent{65, 3}}) {
    const Pipeline pipeline(extent);
    EXPECT_SAME_BITS(test::solved(pipeline.scene).displacement, pipeline.result()) << extent.width;
  }
}

/// A stiff frame in tissue a thousand times as soft: two steps are not enough, and nobody but the filter can
/// know.
TEST(ItkFilter, SaysHowFarTheDisplacementIsFromTheAnswer) {
  Pipeline p;
  p.filter->SetEnergy("elastic");
  p.filter->SetModulus(1, 10000.0);
  p.filter->SetNumberOfIterations(2);
  EXPECT_THAT(warnings_of(p), HasSubstr("give more iterations, or an Accuracy"));
  const double far = p.filter->GetEstimatedError();
  const VectorField rough = p.result();
  p.filter->SetAccuracy(1e-3);
  EXPECT_EQ(warnings_of(p), "");
  EXPECT_LE(p.filter->GetEstimatedError(), 1e-3);
  VectorField difference = p.result();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::ranges::transform(difference[axis], rough[axis], difference[axis].begin(), std::minus{});
  }
  const double distance = root_mean_square(difference);
  fmt::print("two steps: about {:.3g} px from finite elements by their own estimate, {:.3g} px in truth\n",
             far, distance);
  EXPECT_THAT(far / distance, AllOf(testing::Gt(0.5), testing::Lt(8.0)));
  p.filter->SetAccuracy(1e-9);
  EXPECT_THAT(warnings_of(p), HasSubstr("NOT met"));
}

/// Turned by quarters, which rounds nothing: columns of the volume lie along z, rows along x, slices along
/// -y.
TEST(ItkFilterGeometry, VolumesAreSolved) {
  using VolumeFilter = itk::HDMRegularizationFilter<itk::Image<itk::Vector<float, 3>, 3>>;
  Scene scene = two_tissues({12, 9, 7});
  use_elastic(scene);
  const auto allocate = [&](auto image, int slices = 7) {
    image->SetRegions(itk::Size<3>{12, 9, static_cast<itk::SizeValueType>(slices)});
    image->SetSpacing(std::array{2.0, 2.0, 2.0}.data());
    itk::Matrix<double, 3, 3> direction;
    direction(2, 0) = direction(0, 1) = 1.0;
    direction(1, 2) = -1.0;
    image->SetDirection(direction);
    image->Allocate(true);
    return image;
  };
  const auto moduli = allocate(VolumeFilter::ModulusImageType::New());
  const auto observation = allocate(VolumeFilter::DisplacementFieldType::New());
  const auto confidence = allocate(VolumeFilter::ConfidenceImageType::New());
  for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
    const auto& target = scene.full.target;
    moduli->GetBufferPointer()[site] = scene.full.modulus.values[site];
    observation->GetBufferPointer()[site] =
        std::array{2.0F * target[1][site], -2.0F * target[2][site], 2.0F * target[0][site]}.data();
    for (unsigned axis = 0; axis < 3; ++axis) {
      confidence->GetBufferPointer()[site][axis] = scene.full.confidence[axis][site];
    }
  }
  const auto filter = VolumeFilter::New();
  filter->SetInput(allocate(VolumeFilter::DisplacementFieldType::New()));
  filter->SetModulusImage(moduli);
  filter->SetObservationImage(observation);
  filter->SetConfidenceImage(confidence);
  filter->SetEnergy("elastic");
  filter->SetPoissonRatio(0.2);
  filter->SetNumberOfIterations(9);
  filter->Update();
  const VectorField expected = test::solved(scene).displacement;
  for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
    const auto& found = filter->GetOutput()->GetBufferPointer()[site];
    EXPECT_EQ(found[0], 2.0F * expected[1][site]);
    EXPECT_EQ(found[1], -2.0F * expected[2][site]);
    EXPECT_EQ(found[2], 2.0F * expected[0][site]);
  }
  EXPECT_GT(largest_magnitude(expected), 1.0);
  const auto flat = VolumeFilter::New();
  flat->SetInput(allocate(VolumeFilter::DisplacementFieldType::New(), 1));
  flat->SetModulusImage(allocate(VolumeFilter::ModulusImageType::New(), 1));
  EXPECT_THAT([&] { flat->Update(); },
              testing::ThrowsMessage<itk::ExceptionObject>(HasSubstr("one slice is")));
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

/// Boxes, not cubes, and the vectors lie along the axes of space.
TEST(ItkFilterGeometry, AVolumeIsWhatItsFilesAre) {
  using VolumeFilter = itk::HDMRegularizationFilter<itk::Image<itk::Vector<float, 3>, 3>>;
  const auto labels = Oblique::allocate({16, 14, 6});
  const auto field = VolumeFilter::DisplacementFieldType::New();
  field->CopyInformation(labels);
  field->SetRegions(labels->GetLargestPossibleRegion());
  field->Allocate(true);
  for_each_site({16, 14, 6}, [&](int x, int y, int z) {
    labels->SetPixel({x, y, z}, std::hypot(x - 8, y - 7, 3 * (z - 3)) < 6.0 ? 1 : 0);
  });
  const std::string text = "[[tissue]]\nlabel = 0\nmodulus = 0.001\ndensity = 1000.0\n[[tissue]]\nlabel = 1\n"
                           "modulus = 0.1\ndensity = 1500.0\n[[load]]\ngravity = [3.0, 9.0, -1.0]\n"
                           "[[condition]]\nwhere = \"border\"\ndx = 0.0\ndy = 0.0\ndz = 0.0\n";
  const auto filter = VolumeFilter::New();
  filter->SetInput(field);
  filter->SetLabels(labels);
  filter->SetSceneText(text);
  filter->SetAccuracy(0.02);
  filter->Update();
  const Solution expected =
      solved_by_files<Oblique::Volume, VolumeFilter::DisplacementFieldType>(*labels, {}, text);
  double farthest = 0.0;
  for (std::size_t site = 0; site < expected.displacement.extent.sites(); ++site) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      double along = 0.0;
      for (unsigned i = 0; i < 3; ++i) {
        along += 0.8 * labels->GetDirection()(axis, i) * expected.displacement[i][site];
      }
      farthest = std::max(farthest, std::abs(along - filter->GetOutput()->GetBufferPointer()[site][axis]));
    }
  }
  EXPECT_LT(farthest, 1e-6);
  EXPECT_GT(largest_magnitude(expected.displacement), 0.01);
}

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
