#ifndef itkHDMRegularizationFilter_h
#define itkHDMRegularizationFilter_h

#include <backends/registry.hpp>
#include <harness/scene/method.hpp>
#include <harness/scene/scene_of_images.hpp>
#include <harness/solve/request.hpp>
#include <harness/solve/unloading.hpp>
#include <kernels/data/input_error.hpp>
#include <kernels/data/level.hpp>

#include <itkImage.h>
#include <itkImageRegionIterator.h>
#include <itkImageToImageFilter.h>
#include <itkVector.h>

#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace itk {

/** \class HDMRegularizationFilter
 * \brief Regularises a displacement field by the Hierarchy Displacement Model (kernels/README.md) on any
 * backend of hdmbench; all backends give the same bits.
 *
 * The input is the field to begin with, the output the regularised one. Both, and the observation, hold
 * physical displacements, as ITK's convention is: in the unit of the spacing (millimetres), along the
 * physical axes, and forward: tissue at x moves to x + d(x). Images and volumes; axes must be orthogonal, the
 * direction may be any. Pixels must be square, or voxels cubes, but for the elastic energy.
 *
 * What the tissue is made of comes either from SetLabels() with SetModulus() for every label that occurs, or
 * from SetModulusImage(). What is known of the displacement comes from SetObservationImage() and
 * SetConfidenceImage(), both or none: the confidence, 0 (unknown) ... 1, has one component for the
 * displacement along the image's rows, one for that along its columns and, of a volume, one through its
 * slices, whatever the direction. All images have the same pixels.
 *
 * Or SetSceneText() says what the tissue is made of, what holds it and what loads it, as a scene file does:
 * laws of large strains, void, walls to slide along, gravity, resections. The output is then that of
 * `hdmbench run` for the same images and the same text, to the bit, and the input says only where the pixels
 * lie.
 *
 * The whole image is computed at once. Every level of the pyramid ends with a ProgressEvent, after which
 * AbortGenerateData is honoured. Where the input, a parameter or the device is not fit for the computation,
 * an ExceptionObject says what was wrong, where, and what to do. So it does where there is no answer: where a
 * law has none, or the field is one that no tissue has. Where the answer is not as accurate as asked for, or
 * in doubt, there is a warning of ITK's.
 *
 * CPU backends use as many threads as the filter's MultiThreader may.
 */
template <typename TDisplacementField = Image<Vector<float, 2>, 2>,
          typename TLabelImage = Image<unsigned char, TDisplacementField::ImageDimension>>
class HDMRegularizationFilter : public ImageToImageFilter<TDisplacementField, TDisplacementField> {
public:
  ITK_DISALLOW_COPY_AND_MOVE(HDMRegularizationFilter);

  using Self = HDMRegularizationFilter;
  using Superclass = ImageToImageFilter<TDisplacementField, TDisplacementField>;
  using Pointer = SmartPointer<Self>;
  using ConstPointer = SmartPointer<const Self>;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic" // the macro's own semicolon
  itkNewMacro(Self);
#pragma GCC diagnostic pop
  itkTypeMacro(HDMRegularizationFilter, ImageToImageFilter);

  using DisplacementFieldType = TDisplacementField;
  using DisplacementType = typename TDisplacementField::PixelType;
  using LabelImageType = TLabelImage;
  using LabelType = typename TLabelImage::PixelType;
  static constexpr unsigned Dimension = TDisplacementField::ImageDimension;
  using ModulusImageType = Image<float, Dimension>;
  using ConfidenceImageType = Image<Vector<float, Dimension>, Dimension>;
  static_assert((Dimension == 2 || Dimension == 3) && DisplacementType::Dimension == Dimension,
                "the displacement field is a 2-D image of 2-vectors, or a 3-D image of 3-vectors");
  static_assert(TLabelImage::ImageDimension == Dimension && std::is_integral_v<LabelType>,
                "the labels are an image of integers, of the same dimension");

  /** TOML, as a scene file has it without its [image] (harness/scene/scenes/README.md): [[tissue]] with a
   * law, [[condition]], [[load]], [[resect]]. Where nothing is said the energy is "elastic" and the border is
   * held. Takes the place of SetModulus(), Energy, PoissonRatio, NumberOfIterations and Penalty. Default:
   * none. */
  itkSetStringMacro(SceneText);
  itkGetStringMacro(SceneText);
  /** \name Of such a scene: a force in N/mm^3, the directions of fibres, the normals of walls; 0
   * where there are none. Along the axes of space. */
  /** @{ */
  itkSetInputMacro(ForceImage, DisplacementFieldType);
  itkGetInputMacro(ForceImage, DisplacementFieldType);
  itkSetInputMacro(FibreImage, DisplacementFieldType);
  itkGetInputMacro(FibreImage, DisplacementFieldType);
  itkSetInputMacro(NormalImage, DisplacementFieldType);
  itkGetInputMacro(NormalImage, DisplacementFieldType);
  /** @} */

  /** Which tissue. */
  itkSetInputMacro(Labels, LabelImageType);
  itkGetInputMacro(Labels, LabelImageType);
  /** Young's modulus of a label, MPa, > 0; only ratios matter. */
  void SetModulus(LabelType label, double megapascal) {
    const auto [found, inserted] = m_Moduli.try_emplace(label, megapascal);
    if (inserted || found->second != megapascal) {
      found->second = megapascal;
      this->Modified();
    }
  }
  void ClearModuli() {
    m_Moduli.clear();
    this->Modified();
  }
  /** Young's modulus itself, MPa, > 0, instead of labels. */
  itkSetInputMacro(ModulusImage, ModulusImageType);
  itkGetInputMacro(ModulusImage, ModulusImageType);

  /** Known displacement, physical; its value counts where the confidence is not 0. */
  itkSetInputMacro(ObservationImage, DisplacementFieldType);
  itkGetInputMacro(ObservationImage, DisplacementFieldType);
  itkSetInputMacro(ConfidenceImage, ConfidenceImageType);
  itkGetInputMacro(ConfidenceImage, ConfidenceImageType);

  /** What the field minimises, by the name that scene files use: "hdm" (the thesis; default) or "elastic",
   * the strain energy of plane stress, or of a volume, as finite elements do. The latter begins with the
   * observation, not with the input, prescribes a component where its confidence is 1 and pulls at it by a
   * spring where it is below, and has no use for Penalty. */
  itkSetStringMacro(Energy);
  itkGetStringMacro(Energy);
  /** Of all tissues, above -1 and at most 0.5, of a volume below it; of the elastic energy. Default 0.3. */
  itkSetMacro(PoissonRatio, double);
  itkGetConstMacro(PoissonRatio, double);
  /** Per level. Of the elastic energy: steps of conjugate gradients at most; they end where only rounding is
   * left. Default 50. */
  itkSetMacro(NumberOfIterations, int);
  itkGetConstMacro(NumberOfIterations, int);
  /** How far from finite elements the displacement may be, root mean square, in the unit of the spacing; of
   * the elastic energy. No more is done than that takes, whatever NumberOfIterations is. 0 (default): nothing
   * is asked for. */
  itkSetMacro(Accuracy, double);
  itkGetConstMacro(Accuracy, double);
  /** K > 0, the weight of the observation. Default 1000. */
  itkSetMacro(Penalty, double);
  itkGetConstMacro(Penalty, double);
  /** "scalar", "openmp" (default), "gl-fragment", "gl-fragment-osmesa", "gl-compute", "vulkan-compute",
   * "opencl". */
  itkSetStringMacro(Backend);
  itkGetStringMacro(Backend);
  /** Part of the device's name, or its number; empty (default): the first hardware. */
  itkSetStringMacro(Device);
  itkGetStringMacro(Device);

  /** \name What the last Update did. */
  /** @{ */
  /** Size and iterations of every level, coarsest first. */
  const std::vector<hdmbench::LevelResult>& GetLevels() const {
    return m_Levels;
  }
  /** Iterations of all levels together. */
  int GetElapsedIterations() const {
    return std::accumulate(m_Levels.begin(), m_Levels.end(), 0,
                           [](int sum, const auto& level) { return sum + level.iterations; });
  }
  /** U of (5.2) at full resolution, in pixels squared; not a number where another energy was minimised. */
  itkGetConstMacro(MeanEnergy, double);
  /** How far from finite elements the displacement is, root mean square, in the unit of the spacing; negative
   * where there is no estimate. */
  itkGetConstMacro(EstimatedError, double);
  /** The name of the device that computed, as its driver calls it. */
  itkGetStringMacro(DeviceUsed);
  /** @} */

protected:
  HDMRegularizationFilter() = default;
  ~HDMRegularizationFilter() override = default;

  /** What can be said before any upstream filter runs. */
  void VerifyPreconditions() ITKv5_CONST override {
    Superclass::VerifyPreconditions();
    const bool labels = this->GetLabels() != nullptr;
    if (labels == (this->GetModulusImage() != nullptr)) {
      itkExceptionMacro(<< "what is the tissue made of? " << (labels ? "Both are set" : "Neither is set")
                        << ": give either SetLabels() with a SetModulus() per label, or SetModulusImage()");
    }
    if ((this->GetObservationImage() != nullptr) != (this->GetConfidenceImage() != nullptr)) {
      itkExceptionMacro(<< "SetObservationImage() and SetConfidenceImage(): give both or none");
    }
    if (!(m_Accuracy >= 0.0)) {
      itkExceptionMacro(<< "Accuracy is " << m_Accuracy << ", it may not be negative");
    }
    if (m_SceneText.empty()) {
      if (this->GetForceImage() || this->GetFibreImage() || this->GetNormalImage()) {
        itkExceptionMacro(<< "SetForceImage(), SetFibreImage() and SetNormalImage() are for SetSceneText()");
      }
    } else if (const auto defaults = Self::New(); !m_Moduli.empty() || m_Energy != defaults->m_Energy ||
                                                  m_PoissonRatio != defaults->m_PoissonRatio ||
                                                  m_Penalty != defaults->m_Penalty ||
                                                  m_NumberOfIterations != defaults->m_NumberOfIterations) {
      itkExceptionMacro(
          << "SetModulus(), Energy, PoissonRatio, NumberOfIterations and Penalty have no effect "
             "beside SetSceneText(): its [[tissue]] tables and keys say that");
    }
    if (m_NumberOfIterations < 0) {
      itkExceptionMacro(<< "NumberOfIterations is " << m_NumberOfIterations << ", it may not be negative");
    }
    if (!(m_PoissonRatio > -1.0 && m_PoissonRatio <= 0.5)) {
      itkExceptionMacro(<< "PoissonRatio is " << m_PoissonRatio << ", it must be above -1 and at most 0.5");
    }
    try {
      const auto backends = hdmbench::make_backends();
      (void)hdmbench::find_backend(backends, m_Backend);
      (void)hdmbench::find_energy(m_Energy);
    } catch (const hdmbench::InputError& error) {
      itkExceptionMacro(<< error.what());
    }
  }

  void VerifyInputInformation() ITKv5_CONST override {
    Superclass::VerifyInputInformation();
    const auto* const field = this->GetInput();
    const auto region = field->GetLargestPossibleRegion();
    for (const auto& name : this->GetInputNames()) {
      const auto* const image =
          dynamic_cast<const ImageBase<Dimension>*>(this->ProcessObject::GetInput(name));
      if (image != nullptr && image->GetLargestPossibleRegion() != region) {
        itkExceptionMacro(<< "the input " << name << " has " << image->GetLargestPossibleRegion().GetSize()
                          << " pixels from index " << image->GetLargestPossibleRegion().GetIndex()
                          << ", the displacement field " << region.GetSize() << " from " << region.GetIndex()
                          << ": resample one of them");
      }
    }
    const auto spacing = field->GetSpacing();
    const auto& direction = field->GetDirection();
    auto rest = direction.GetVnlMatrix().transpose() * direction.GetVnlMatrix();
    const bool takes_boxes = !m_SceneText.empty() || hdmbench::find_energy(m_Energy).takes_boxes;
    for (unsigned axis = 0; axis < Dimension; ++axis) {
      if (!takes_boxes && !(std::abs(spacing[0] - spacing[axis]) <= SquareTolerance * spacing[0])) {
        itkExceptionMacro(<< "the pixels are " << spacing
                          << ", they must be square: resample the images, or SetEnergy(\"elastic\")");
      }
      if (Dimension == 3 && region.GetSize(axis) < 2) {
        itkExceptionMacro(<< "a volume of " << region.GetSize()
                          << " is not possible, each side must be at least 2; one slice is a 2-D image");
      }
      rest(axis, axis) -= 1.0;
    }
    if (!(rest.absolute_value_max() <= OrthogonalityTolerance)) {
      itkExceptionMacro(<< "the image's direction is not orthonormal, so its pixels are not square:\n"
                        << direction);
    }
  }

  void GenerateInputRequestedRegion() override {
    Superclass::GenerateInputRequestedRegion();
    for (const auto& name : this->GetInputNames()) {
      if (auto* const input = this->ProcessObject::GetInput(name)) {
        input->SetRequestedRegionToLargestPossibleRegion();
      }
    }
  }

  void EnlargeOutputRequestedRegion(DataObject* output) override {
    Superclass::EnlargeOutputRequestedRegion(output);
    output->SetRequestedRegionToLargestPossibleRegion();
  }

  void GenerateData() override {
    try {
      hdmbench::Scene scene = m_SceneText.empty() ? this->MakeScene() : this->SceneOfText();
      const hdmbench::Answer answer = this->Solve(scene);
      const hdmbench::Solution& solution = answer.solution();
      this->Judge(scene, answer);
      this->AllocateOutputs();
      this->ToPhysical(solution.displacement, *this->GetOutput());
      m_Levels = solution.levels;
      m_MeanEnergy = scene.energy->is_of_cells() ? std::numeric_limits<double>::quiet_NaN()
                                                 : hdmbench::mean_energy(scene.full, solution.displacement);
    } catch (const std::runtime_error& error) { // bad input, or the device
      itkExceptionMacro(<< error.what());
    }
  }

  void PrintSelf(std::ostream& os, Indent indent) const override {
    Superclass::PrintSelf(os, indent);
    os << indent << "Moduli:";
    for (const auto& [label, megapascal] : m_Moduli) {
      os << ' ' << +label << ": " << megapascal << " MPa";
    }
    const auto print = [&](const char* name, const auto& value) {
      os << '\n' << indent << name << ": " << value;
    };
    print("Energy", m_Energy);
    print("PoissonRatio", m_PoissonRatio);
    print("NumberOfIterations", m_NumberOfIterations);
    print("Accuracy", m_Accuracy);
    print("Penalty", m_Penalty);
    print("SceneText", m_SceneText);
    print("Backend", m_Backend);
    print("Device", m_Device);
    print("DeviceUsed", m_DeviceUsed);
    print("ElapsedIterations", this->GetElapsedIterations());
    print("MeanEnergy", m_MeanEnergy);
    print("EstimatedError", m_EstimatedError);
    os << std::endl;
  }

private:
  /** Rounding in file headers, not another shape. */
  static constexpr double SquareTolerance = 0.01;        // of a pixel's side
  static constexpr double OrthogonalityTolerance = 1e-4; // of a unit vector
  /** Less is not seen in a picture. */
  static constexpr double VisibleError = 0.1; // pixels

  /** visit(site, value) for every pixel in raster order. */
  template <typename TImage, typename TVisit>
  static void ForEachPixel(const TImage& image, TVisit visit) {
    std::size_t site = 0;
    for (ImageRegionConstIterator<TImage> pixel(&image, image.GetLargestPossibleRegion()); !pixel.IsAtEnd();
         ++pixel) {
      visit(site++, pixel.Get());
    }
  }

  template <typename TImage>
  static hdmbench::Extent ExtentOf(const TImage& image) {
    const auto size = image.GetLargestPossibleRegion().GetSize();
    return {static_cast<int>(size[0]), static_cast<int>(size[1]),
            Dimension == 3 ? static_cast<int>(size[Dimension - 1]) : 1};
  }

  /** The unit of displacements. */
  double ShortestSide() const {
    const auto spacing = this->GetInput()->GetSpacing();
    return *std::min_element(spacing.Begin(), spacing.End());
  }

  /** As Level::sides; all 1 where they are taken for squares or cubes. */
  std::array<double, 3> Sides() const {
    const auto spacing = this->GetInput()->GetSpacing();
    std::array<double, 3> sides{1.0, 1.0, 1.0};
    for (unsigned axis = 0; axis < Dimension; ++axis) {
      const double side = spacing[axis] / this->ShortestSide();
      sides[axis] = side <= 1.0 + SquareTolerance ? 1.0 : side;
    }
    return sides;
  }

  /** Along rows, columns and slices, in pixels. The direction is orthonormal: its inverse is its transpose,
   * which for unrotated images is exact. */
  hdmbench::VectorField ToPixels(const DisplacementFieldType& field) const {
    const auto& direction = this->GetInput()->GetDirection();
    const double spacing = this->ShortestSide();
    hdmbench::VectorField pixels(ExtentOf(field));
    ForEachPixel(field, [&](std::size_t site, const DisplacementType& physical) {
      for (unsigned axis = 0; axis < Dimension; ++axis) {
        double along = 0.0;
        for (unsigned i = 0; i < Dimension; ++i) {
          along += direction(i, axis) * physical[i];
        }
        pixels[axis][site] = static_cast<float>(along / spacing);
      }
    });
    return pixels;
  }

  void ToPhysical(const hdmbench::VectorField& displacement, DisplacementFieldType& field) const {
    using ComponentType = typename DisplacementType::ValueType;
    const auto& direction = this->GetInput()->GetDirection();
    const double spacing = this->ShortestSide();
    ImageRegionIterator<DisplacementFieldType> pixel(&field, field.GetLargestPossibleRegion());
    for (std::size_t site = 0; !pixel.IsAtEnd(); ++pixel, ++site) {
      DisplacementType physical;
      for (unsigned axis = 0; axis < Dimension; ++axis) {
        double along = 0.0;
        for (unsigned i = 0; i < Dimension; ++i) {
          along += direction(axis, i) * displacement[i][site];
        }
        physical[axis] = static_cast<ComponentType>(along * spacing);
      }
      pixel.Set(physical);
    }
  }

  template <typename TImage>
  static hdmbench::images::Pixels ToMemory(const TImage& image) {
    hdmbench::images::Pixels pixels;
    auto& geometry = pixels.geometry;
    geometry.axes = hdmbench::Placement{}.axes;
    for (unsigned axis = 0; axis < Dimension; ++axis) {
      geometry.size[axis] = static_cast<int>(image.GetLargestPossibleRegion().GetSize(axis));
      geometry.spacing[axis] = image.GetSpacing()[axis];
      for (unsigned i = 0; i < Dimension; ++i) {
        geometry.axes[axis][i] = image.GetDirection()(i, axis);
      }
    }
    geometry.spacing[2] = Dimension == 2 ? geometry.spacing[0] : geometry.spacing[2];
    const auto origin = FirstPixel(image);
    std::copy_n(origin.Begin(), Dimension, geometry.origin.begin());
    constexpr bool is_scalar = std::is_arithmetic_v<typename TImage::PixelType>;
    geometry.components = is_scalar ? 1 : Dimension;
    pixels.values.reserve(geometry.values());
    ForEachPixel(image, [&](std::size_t, const auto& value) {
      if constexpr (is_scalar) {
        pixels.values.push_back(static_cast<float>(value));
      } else {
        for (unsigned i = 0; i < Dimension; ++i) {
          pixels.values.push_back(static_cast<float>(value[i]));
        }
      }
    });
    return pixels;
  }

  /** Where it lies; its index need not be 0. */
  template <typename TImage>
  static typename TImage::PointType FirstPixel(const TImage& image) {
    typename TImage::PointType point;
    image.TransformIndexToPhysicalPoint(image.GetLargestPossibleRegion().GetIndex(), point);
    return point;
  }

  hdmbench::Scene SceneOfText() const {
    hdmbench::ImagesByKey images;
    const auto add = [&](const char* key, const auto* image) {
      if (image != nullptr) {
        images.emplace(key, ToMemory(*image));
      }
    };
    add("labels", this->GetLabels());
    add("modulus", this->GetModulusImage());
    add("target", this->GetObservationImage());
    add("confidence", this->GetConfidenceImage());
    add("force", this->GetForceImage());
    add("fibre", this->GetFibreImage());
    add("normals", this->GetNormalImage());
    hdmbench::Scene scene = hdmbench::make_scene(m_SceneText, std::move(images));
    if (const auto extent = ExtentOf(*this->GetInput()); scene.extent() != extent) {
      itkExceptionMacro(<< "the scene of SetSceneText() is resampled, " << extent.text() << " pixels to "
                        << scene.extent().text()
                        << ": resample the images, or let its energy be \"elastic\"");
    }
    return scene;
  }

  hdmbench::Scene MakeScene() const {
    hdmbench::Scene scene;
    const hdmbench::VectorField& start = scene.start.emplace(this->ToPixels(*this->GetInput()));
    scene.schedule.iterations = m_NumberOfIterations;
    const hdmbench::Extent extent = start.extent;
    scene.spacing = this->ShortestSide();
    hdmbench::Level& full = scene.full;
    full.extent = extent;
    full.sides = this->Sides();
    full.penalty = static_cast<float>(m_Penalty);
    full.target = hdmbench::VectorField(extent);
    full.confidence = hdmbench::VectorField(extent);
    if (const auto* const confidence = this->GetConfidenceImage()) {
      full.target = this->ToPixels(*this->GetObservationImage());
      ForEachPixel(*confidence, [&](std::size_t site, const auto& value) {
        for (unsigned axis = 0; axis < Dimension; ++axis) {
          full.confidence[axis][site] = value[axis];
        }
      });
    }
    full.modulus = hdmbench::ScalarField(extent);
    if (const auto* const moduli = this->GetModulusImage()) {
      ForEachPixel(*moduli, [&](std::size_t site, float modulus) { full.modulus.values[site] = modulus; });
    } else {
      ForEachPixel(*this->GetLabels(), [&](std::size_t site, LabelType label) {
        const auto found = m_Moduli.find(label);
        if (found == m_Moduli.end()) {
          itkExceptionMacro(<< "the label " << +label << " of the pixel " << extent.place(site)
                            << " has no modulus: call SetModulus(" << +label << ", ...)");
        }
        full.modulus.values[site] = static_cast<float>(found->second);
      });
    }
    hdmbench::set_inverse_modulus(full);
    scene.elastic.poisson = m_PoissonRatio;
    scene.energy = &hdmbench::find_energy(m_Energy);
    hdmbench::set_energy_of_sites(scene);
    if (scene.energy->is_of_cells()) {
      hdmbench::use_method(scene, hdmbench::find_method(hdmbench::elastic_conjugate_gradients),
                           m_NumberOfIterations);
    }
    hdmbench::validate(full);
    hdmbench::validate(start, extent, "the displacement to be regularised");
    return scene;
  }

  hdmbench::Answer Solve(hdmbench::Scene& scene) {
    const hdmbench::SessionOptions options{
        .device = m_Device,
        .threads = static_cast<int>(this->GetMultiThreader()->GetMaximumNumberOfThreads())};
    const auto backends = hdmbench::make_backends();
    const auto& backend = hdmbench::choose_backend(backends, m_Backend, scene);
    m_DeviceUsed = backend.device(options).name;
    hdmbench::Progress progress([this](double done) {
      this->UpdateProgress(static_cast<float>(done));
      if (this->GetAbortGenerateData()) {
        throw ProcessAborted(__FILE__, __LINE__);
      }
    });
    hdmbench::unload(scene, progress);
    hdmbench::Request request;
    if (m_Accuracy > 0.0) {
      request.accuracy = m_Accuracy / scene.spacing;
    }
    return hdmbench::solve_request(scene, request, backend, options, progress);
  }

  /** Throws where the answer is none, and warns where it is in doubt. */
  void Judge(const hdmbench::Scene& scene, const hdmbench::Answer& answer) {
    const hdmbench::Solution& solution = answer.solution();
    if (const std::string none = hdmbench::why_absurd(scene, solution); !none.empty()) {
      itkExceptionMacro(<< "there is no displacement: " << none);
    }
    if (const std::string& doubt = hdmbench::doubt_about(solution); !doubt.empty()) {
      itkWarningMacro(<< doubt);
    }
    m_EstimatedError = solution.estimated_error ? *solution.estimated_error * scene.spacing : -1.0;
    if (answer.plan && !answer.plan->met) {
      itkWarningMacro(<< answer.plan->outcome);
    } else if (!answer.plan && m_EstimatedError > VisibleError * scene.spacing) {
      itkWarningMacro(<< "the displacement is about " << m_EstimatedError
                      << " from finite elements: give more iterations, or an Accuracy");
    }
  }

  std::map<LabelType, double> m_Moduli;
  int m_NumberOfIterations = 50;
  double m_Penalty = 1000.0;
  std::string m_Energy = "hdm";
  double m_PoissonRatio = 0.3;
  double m_Accuracy = 0.0;
  std::string m_SceneText;
  std::string m_Backend = "openmp";
  std::string m_Device;

  std::vector<hdmbench::LevelResult> m_Levels;
  double m_EstimatedError = -1.0;
  double m_MeanEnergy = 0.0;
  std::string m_DeviceUsed;
};

} // namespace itk

#endif
