#ifndef itkHDMRegularizationFilter_h
#define itkHDMRegularizationFilter_h

#include <harness/solve/solve.hpp>

#include <itkImage.h>
#include <itkImageToImageFilter.h>
#include <itkVector.h>

#include <map>
#include <string>
#include <type_traits>
#include <vector>

namespace itk {

/** \class HDMRegularizationFilter
 * \brief Regularises a displacement field by the Hierarchy Displacement Model (kernels/README.md) on any
 * backend of hdmbench; all backends give the same bits.
 *
 * The input is the field to begin with, the output the regularised one. Both, and the observation, hold
 * physical displacements, as ITK's convention is: in the unit of the spacing (millimetres), along the
 * physical axes, and forward: tissue at x moves to x + d(x). Pixels must be square, axes orthogonal; the
 * direction may be any.
 *
 * What the tissue is made of comes either from SetLabels() with SetModulus() for every label that occurs, or
 * from SetModulusImage(). What is known of the displacement comes from SetObservationImage() and
 * SetConfidenceImage(), both or none: the confidence, 0 (unknown) ... 1, has one component for the
 * displacement along the image's rows and one for that along its columns, whatever the direction. All images
 * have the same pixels.
 *
 * The whole image is computed at once. Every level of the pyramid ends with a ProgressEvent, after which
 * AbortGenerateData is honoured. Where the input, a parameter or the device is not fit for the computation,
 * an ExceptionObject says what was wrong, where, and what to do.
 *
 * CPU backends use as many threads as the filter's MultiThreader may.
 */
template <typename TDisplacementField = Image<Vector<float, 2>, 2>,
          typename TLabelImage = Image<unsigned char, 2>>
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
  using ModulusImageType = Image<float, 2>;
  using ConfidenceImageType = Image<Vector<float, 2>, 2>;
  static_assert(TDisplacementField::ImageDimension == 2 && DisplacementType::Dimension == 2,
                "the displacement field is a 2-D image of 2-vectors");
  static_assert(TLabelImage::ImageDimension == 2 && std::is_integral_v<LabelType>,
                "the labels are a 2-D image of integers");

  using EnergyEnum = hdmbench::EnergyModel;
  using StopCriterionEnum = hdmbench::Stop;
  using AlignmentEnum = hdmbench::Alignment;
  /** Number of the level that is beyond every pyramid: start where it is coarsest. */
  static constexpr int CoarsestLevel = 64;

  /** Which tissue. */
  itkSetInputMacro(Labels, LabelImageType);
  itkGetInputMacro(Labels, LabelImageType);
  /** Young's modulus of a label, MPa, > 0; only ratios matter. */
  void SetModulus(LabelType label, double megapascal);
  /** That of a label that was named, else 0. */
  double GetModulus(LabelType label) const;
  void ClearModuli();
  /** Young's modulus itself, MPa, > 0, instead of labels. */
  itkSetInputMacro(ModulusImage, ModulusImageType);
  itkGetInputMacro(ModulusImage, ModulusImageType);

  /** Known displacement, physical; its value counts where the confidence is not 0. */
  itkSetInputMacro(ObservationImage, DisplacementFieldType);
  itkGetInputMacro(ObservationImage, DisplacementFieldType);
  itkSetInputMacro(ConfidenceImage, ConfidenceImageType);
  itkGetInputMacro(ConfidenceImage, ConfidenceImageType);

  /** What the field minimises: EnergyEnum::hdm (the thesis; default) or EnergyEnum::elastic, the strain
   * energy of plane stress, as finite elements do. The latter begins with the observation, not with the
   * input, prescribes a component where its confidence is 1 and pulls at it by a spring where it is below,
   * and has no use for StopCriterion, Epsilon, StartLevel, Alignment, Penalty, StepSet and
   * DuringIterationUpdate. */
  itkSetEnumMacro(Energy, EnergyEnum);
  itkGetEnumMacro(Energy, EnergyEnum);
  /** Of all tissues, above -1 and at most 0.5; of the elastic energy. Default 0.3. */
  itkSetMacro(PoissonRatio, double);
  itkGetConstMacro(PoissonRatio, double);
  /** Per level: exact with StopCriterionEnum::fixed, else at most. Of the elastic energy: steps of conjugate
   * gradients at most; they end where only rounding is left. Default 50. */
  itkSetMacro(NumberOfIterations, int);
  itkGetConstMacro(NumberOfIterations, int);
  /** When a level ends: fixed (default), still (no site changed), energy (see Epsilon). */
  itkSetEnumMacro(StopCriterion, StopCriterionEnum);
  itkGetEnumMacro(StopCriterion, StopCriterionEnum);
  /** For StopCriterionEnum::energy: the change of the mean energy of one iteration. Default 1e-6. */
  itkSetMacro(Epsilon, double);
  itkGetConstMacro(Epsilon, double);
  /** First level computed, 0 the full resolution alone. Default CoarsestLevel. */
  itkSetMacro(StartLevel, int);
  itkGetConstMacro(StartLevel, int);
  /** How coarse sites stand for fine ones. Default corner. */
  itkSetEnumMacro(Alignment, AlignmentEnum);
  itkGetEnumMacro(Alignment, AlignmentEnum);
  /** Sites read what their neighbours became in the same iteration: backend "scalar" only. Default off. */
  itkSetMacro(DuringIterationUpdate, bool);
  itkGetConstMacro(DuringIterationUpdate, bool);
  itkBooleanMacro(DuringIterationUpdate);
  /** K > 0, the weight of the observation. Default 1000. */
  itkSetMacro(Penalty, double);
  itkGetConstMacro(Penalty, double);
  /** Candidate steps in pixels: "default", "thesis", "fine" or numbers with commas between. */
  itkSetStringMacro(StepSet);
  itkGetStringMacro(StepSet);
  /** "scalar", "openmp" (default), "gl-fragment", "gl-fragment-osmesa", "gl-compute", "vulkan-compute". */
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
  int GetElapsedIterations() const;
  /** U of (5.2) at full resolution, in pixels squared. */
  itkGetConstMacro(MeanEnergy, double);
  /** The name of the device that computed, as its driver calls it. */
  itkGetStringMacro(DeviceUsed);
  /** @} */

protected:
  HDMRegularizationFilter() = default;
  ~HDMRegularizationFilter() override = default;

  void VerifyPreconditions() ITKv5_CONST override;
  void VerifyInputInformation() ITKv5_CONST override;
  void GenerateInputRequestedRegion() override;
  void EnlargeOutputRequestedRegion(DataObject* output) override;
  void GenerateData() override;
  void PrintSelf(std::ostream& os, Indent indent) const override;

private:
  hdmbench::Update UpdateOfSites() const;
  hdmbench::Scene MakeScene() const;
  hdmbench::ScalarField ModuliOfLabels() const;
  hdmbench::VectorField ToPixels(const DisplacementFieldType& field) const;
  void ToPhysical(const hdmbench::VectorField& displacement, DisplacementFieldType& field) const;
  hdmbench::Solution Solve(const hdmbench::Scene& scene);

  std::map<LabelType, double> m_Moduli;
  int m_NumberOfIterations = 50;
  StopCriterionEnum m_StopCriterion = StopCriterionEnum::fixed;
  double m_Epsilon = 1e-6;
  int m_StartLevel = CoarsestLevel;
  AlignmentEnum m_Alignment = AlignmentEnum::corner;
  bool m_DuringIterationUpdate = false;
  double m_Penalty = 1000.0;
  EnergyEnum m_Energy = EnergyEnum::hdm;
  double m_PoissonRatio = 0.3;
  std::string m_StepSet = "default";
  std::string m_Backend = "openmp";
  std::string m_Device;

  std::vector<hdmbench::LevelResult> m_Levels;
  double m_MeanEnergy = 0.0;
  std::string m_DeviceUsed;
};

} // namespace itk

#ifndef ITK_MANUAL_INSTANTIATION
#include "itkHDMRegularizationFilter.hxx"
#endif

#endif
