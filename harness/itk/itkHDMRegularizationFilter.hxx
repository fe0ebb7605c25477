#ifndef itkHDMRegularizationFilter_hxx
#define itkHDMRegularizationFilter_hxx

#include "itkHDMRegularizationFilter.h"

#include <backends/registry.hpp>
#include <harness/scene/method.hpp>
#include <harness/solve/methods/solver.hpp>
#include <kernels/data/input_error.hpp>
#include <kernels/data/mean_energy.hpp>

#include <itkImageRegionConstIteratorWithIndex.h>
#include <itkImageRegionIterator.h>

#include <cmath>
#include <utility>

namespace itk {

namespace hdm_regularization {

/** Rounding in file headers, not another shape. */
constexpr double SquareTolerance = 0.01;        // of a pixel's side
constexpr double OrthogonalityTolerance = 1e-4; // of a unit vector

/** visit(site, value) for every pixel in raster order. */
template <typename TImage, typename TVisit>
void ForEachPixel(const TImage& image, TVisit visit) {
  std::size_t site = 0;
  for (ImageRegionConstIterator<TImage> pixel(&image, image.GetLargestPossibleRegion()); !pixel.IsAtEnd();
       ++pixel) {
    visit(site++, pixel.Get());
  }
}

template <typename TImage>
hdmbench::Extent ExtentOf(const TImage& image) {
  const auto size = image.GetLargestPossibleRegion().GetSize();
  return {static_cast<int>(size[0]), static_cast<int>(size[1])};
}

} // namespace hdm_regularization

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::SetModulus(LabelType label,
                                                                          double megapascal) {
  const auto [found, inserted] = m_Moduli.try_emplace(label, megapascal);
  if (inserted || found->second != megapascal) {
    found->second = megapascal;
    this->Modified();
  }
}

template <typename TDisplacementField, typename TLabelImage>
double HDMRegularizationFilter<TDisplacementField, TLabelImage>::GetModulus(LabelType label) const {
  const auto found = m_Moduli.find(label);
  return found == m_Moduli.end() ? 0.0 : found->second;
}

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::ClearModuli() {
  if (!m_Moduli.empty()) {
    m_Moduli.clear();
    this->Modified();
  }
}

template <typename TDisplacementField, typename TLabelImage>
int HDMRegularizationFilter<TDisplacementField, TLabelImage>::GetElapsedIterations() const {
  int sum = 0;
  for (const auto& level : m_Levels) {
    sum += level.iterations;
  }
  return sum;
}

/** What can be said before any upstream filter runs. */
template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::VerifyPreconditions() ITKv5_CONST {
  Superclass::VerifyPreconditions();
  const bool labels = this->GetLabels() != nullptr;
  if (labels == (this->GetModulusImage() != nullptr)) {
    itkExceptionMacro(<< "what is the tissue made of? " << (labels ? "Both are set" : "Neither is set")
                      << ": give either SetLabels() with a SetModulus() per label, or SetModulusImage()");
  }
  if ((this->GetObservationImage() != nullptr) != (this->GetConfidenceImage() != nullptr)) {
    itkExceptionMacro(<< "SetObservationImage() and SetConfidenceImage(): give both or none");
  }
  if (m_NumberOfIterations < 0 || m_StartLevel < 0 || !(m_Epsilon >= 0.0)) {
    itkExceptionMacro(<< "NumberOfIterations is " << m_NumberOfIterations << ", StartLevel " << m_StartLevel
                      << ", Epsilon " << m_Epsilon << ": none may be negative");
  }
  if (!(m_PoissonRatio > -1.0 && m_PoissonRatio <= 0.5)) {
    itkExceptionMacro(<< "PoissonRatio is " << m_PoissonRatio << ", it must be above -1 and at most 0.5");
  }
  try {
    (void)hdmbench::StepSet::parse(m_StepSet);
    const auto backends = hdmbench::make_backends();
    const auto& backend = hdmbench::find_backend(backends, m_Backend);
    if (!backend.supports(this->UpdateOfSites())) {
      itkExceptionMacro(<< m_Backend
                        << " cannot update during an iteration, only scalar can: call SetBackend(\"scalar\") "
                           "or DuringIterationUpdateOff()");
    }
  } catch (const hdmbench::InputError& error) {
    itkExceptionMacro(<< error.what());
  }
}

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::VerifyInputInformation() ITKv5_CONST {
  Superclass::VerifyInputInformation();
  const auto* const field = this->GetInput();
  const auto region = field->GetLargestPossibleRegion();
  for (const auto& name : this->GetInputNames()) {
    const auto* const image = dynamic_cast<const ImageBase<2>*>(this->ProcessObject::GetInput(name));
    if (image != nullptr && image->GetLargestPossibleRegion() != region) {
      itkExceptionMacro(<< "the input " << name << " has " << image->GetLargestPossibleRegion().GetSize()
                        << " pixels from index " << image->GetLargestPossibleRegion().GetIndex()
                        << ", the displacement field " << region.GetSize() << " from " << region.GetIndex()
                        << ": resample one of them");
    }
  }
  const auto spacing = field->GetSpacing();
  if (!(std::abs(spacing[0] - spacing[1]) <= hdm_regularization::SquareTolerance * spacing[0])) {
    itkExceptionMacro(<< "the pixels are " << spacing[0] << " x " << spacing[1]
                      << ", they must be square: resample the images");
  }
  const auto& direction = field->GetDirection();
  const auto product = direction.GetVnlMatrix().transpose() * direction.GetVnlMatrix();
  for (unsigned row = 0; row < 2; ++row) {
    for (unsigned column = 0; column < 2; ++column) {
      if (!(std::abs(product(row, column) - (row == column ? 1.0 : 0.0)) <=
            hdm_regularization::OrthogonalityTolerance)) {
        itkExceptionMacro(<< "the image's direction is not orthonormal, so its pixels are not square:\n"
                          << direction);
      }
    }
  }
}

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::GenerateInputRequestedRegion() {
  Superclass::GenerateInputRequestedRegion();
  for (const auto& name : this->GetInputNames()) {
    if (auto* const input = this->ProcessObject::GetInput(name)) {
      input->SetRequestedRegionToLargestPossibleRegion();
    }
  }
}

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::EnlargeOutputRequestedRegion(
    DataObject* output) {
  Superclass::EnlargeOutputRequestedRegion(output);
  output->SetRequestedRegionToLargestPossibleRegion();
}

template <typename TDisplacementField, typename TLabelImage>
hdmbench::Update HDMRegularizationFilter<TDisplacementField, TLabelImage>::UpdateOfSites() const {
  return m_DuringIterationUpdate ? hdmbench::Update::sequential : hdmbench::Update::simultaneous;
}

template <typename TDisplacementField, typename TLabelImage>
hdmbench::ScalarField HDMRegularizationFilter<TDisplacementField, TLabelImage>::ModuliOfLabels() const {
  const auto* const labels = this->GetLabels();
  hdmbench::ScalarField moduli(hdm_regularization::ExtentOf(*labels));
  hdm_regularization::ForEachPixel(*labels, [&](std::size_t site, LabelType label) {
    const auto found = m_Moduli.find(label);
    if (found == m_Moduli.end()) {
      const auto width = static_cast<std::size_t>(moduli.extent.width);
      itkExceptionMacro(<< "the label " << +label << " of the pixel x = " << site % width << ", y = "
                        << site / width << " has no modulus: call SetModulus(" << +label << ", ...)");
    }
    moduli.values[site] = static_cast<float>(found->second);
  });
  return moduli;
}

/** Along rows and columns, in pixels. The direction is orthonormal: its inverse is its transpose, which for
 * unrotated images is exact. */
template <typename TDisplacementField, typename TLabelImage>
hdmbench::VectorField
HDMRegularizationFilter<TDisplacementField, TLabelImage>::ToPixels(const DisplacementFieldType& field) const {
  const auto& direction = this->GetInput()->GetDirection();
  const double spacing = this->GetInput()->GetSpacing()[0];
  hdmbench::VectorField pixels(hdm_regularization::ExtentOf(field));
  hdm_regularization::ForEachPixel(field, [&](std::size_t site, const DisplacementType& physical) {
    const double x = physical[0];
    const double y = physical[1];
    pixels.x[site] = static_cast<float>((direction(0, 0) * x + direction(1, 0) * y) / spacing);
    pixels.y[site] = static_cast<float>((direction(0, 1) * x + direction(1, 1) * y) / spacing);
  });
  return pixels;
}

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::ToPhysical(
    const hdmbench::VectorField& displacement, DisplacementFieldType& field) const {
  using ComponentType = typename DisplacementType::ValueType;
  const auto& direction = this->GetInput()->GetDirection();
  const double spacing = this->GetInput()->GetSpacing()[0];
  ImageRegionIterator<DisplacementFieldType> pixel(&field, field.GetLargestPossibleRegion());
  for (std::size_t site = 0; !pixel.IsAtEnd(); ++pixel, ++site) {
    const double x = displacement.x[site];
    const double y = displacement.y[site];
    DisplacementType physical;
    physical[0] = static_cast<ComponentType>((direction(0, 0) * x + direction(0, 1) * y) * spacing);
    physical[1] = static_cast<ComponentType>((direction(1, 0) * x + direction(1, 1) * y) * spacing);
    pixel.Set(physical);
  }
}

template <typename TDisplacementField, typename TLabelImage>
hdmbench::Scene HDMRegularizationFilter<TDisplacementField, TLabelImage>::MakeScene() const {
  hdmbench::Scene scene;
  const hdmbench::VectorField& start = scene.start.emplace(this->ToPixels(*this->GetInput()));
  scene.schedule = {.iterations = m_NumberOfIterations,
                    .stop = m_StopCriterion,
                    .epsilon = m_Epsilon,
                    .start_level = m_StartLevel,
                    .alignment = m_Alignment};
  const hdmbench::Extent extent = start.extent;
  hdmbench::Level& full = scene.full;
  full.extent = extent;
  full.penalty = static_cast<float>(m_Penalty);
  full.steps = hdmbench::StepSet::parse(m_StepSet);
  full.update = this->UpdateOfSites();
  full.target = hdmbench::VectorField(extent);
  full.confidence = hdmbench::VectorField(extent);
  if (const auto* const confidence = this->GetConfidenceImage()) {
    full.target = this->ToPixels(*this->GetObservationImage());
    hdm_regularization::ForEachPixel(*confidence, [&](std::size_t site, const auto& value) {
      full.confidence.x[site] = value[0];
      full.confidence.y[site] = value[1];
    });
  }
  if (const auto* const moduli = this->GetModulusImage()) {
    full.modulus = hdmbench::ScalarField(extent);
    hdm_regularization::ForEachPixel(
        *moduli, [&](std::size_t site, float modulus) { full.modulus.values[site] = modulus; });
  } else {
    full.modulus = this->ModuliOfLabels();
  }
  hdmbench::set_inverse_modulus(full);
  if (m_Energy == EnergyEnum::elastic) {
    scene.poisson = m_PoissonRatio;
    hdmbench::use_method(scene, hdmbench::find_method(hdmbench::elastic_conjugate_gradients),
                         m_NumberOfIterations);
  }
  hdmbench::validate(full);
  hdmbench::validate(start, extent, "the displacement to be regularised");
  return scene;
}

template <typename TDisplacementField, typename TLabelImage>
hdmbench::Solution
HDMRegularizationFilter<TDisplacementField, TLabelImage>::Solve(const hdmbench::Scene& scene) {
  const hdmbench::SessionOptions options{
      .device = m_Device, .threads = static_cast<int>(this->GetMultiThreader()->GetMaximumNumberOfThreads())};
  const auto backends = hdmbench::make_backends();
  const auto& backend = hdmbench::find_backend(backends, m_Backend);
  m_DeviceUsed = backend.device(options).name;
  hdmbench::Progress progress([this](double done) {
    this->UpdateProgress(static_cast<float>(done));
    if (this->GetAbortGenerateData()) {
      throw ProcessAborted(__FILE__, __LINE__);
    }
  });
  progress.set_total(hdmbench::site_updates(scene));
  return hdmbench::Solver(backend, options).solve(scene, progress);
}

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::GenerateData() {
  try {
    const hdmbench::Scene scene = this->MakeScene();
    hdmbench::Solution solution = this->Solve(scene);
    this->AllocateOutputs();
    this->ToPhysical(solution.displacement, *this->GetOutput());
    m_Levels = std::move(solution.levels);
    m_MeanEnergy = hdmbench::mean_energy(scene.full, solution.displacement);
  } catch (const hdmbench::InputError& error) {
    itkExceptionMacro(<< error.what());
  } catch (const hdmbench::DeviceError& error) {
    itkExceptionMacro(<< error.what());
  }
}

template <typename TDisplacementField, typename TLabelImage>
void HDMRegularizationFilter<TDisplacementField, TLabelImage>::PrintSelf(std::ostream& os,
                                                                         Indent indent) const {
  Superclass::PrintSelf(os, indent);
  os << indent << "Moduli:";
  for (const auto& [label, megapascal] : m_Moduli) {
    os << ' ' << +label << ": " << megapascal << " MPa";
  }
  os << '\n';
  os << indent << "Energy: " << hdmbench::energy_names[static_cast<std::size_t>(m_Energy)] << '\n';
  os << indent << "PoissonRatio: " << m_PoissonRatio << '\n';
  os << indent << "NumberOfIterations: " << m_NumberOfIterations << '\n';
  os << indent << "StopCriterion: " << static_cast<int>(m_StopCriterion) << '\n';
  os << indent << "Epsilon: " << m_Epsilon << '\n';
  os << indent << "StartLevel: " << m_StartLevel << '\n';
  os << indent << "Alignment: " << static_cast<int>(m_Alignment) << '\n';
  os << indent << "DuringIterationUpdate: " << (m_DuringIterationUpdate ? "On" : "Off") << '\n';
  os << indent << "Penalty: " << m_Penalty << '\n';
  os << indent << "StepSet: " << m_StepSet << '\n';
  os << indent << "Backend: " << m_Backend << '\n';
  os << indent << "Device: " << m_Device << '\n';
  os << indent << "ElapsedIterations: " << this->GetElapsedIterations() << '\n';
  os << indent << "MeanEnergy: " << m_MeanEnergy << '\n';
  os << indent << "DeviceUsed: " << m_DeviceUsed << std::endl;
}

} // namespace itk

#endif
