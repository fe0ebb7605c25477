#include <itkHDMRegularizationFilter.h>

#include <iostream>

/// A row of 20 pixels whose ends are pulled apart: prints the displacement, which must have moved.
int main() {
  using Filter = itk::HDMRegularizationFilter<>;
  const auto allocate = [](auto image) {
    image->SetRegions(Filter::LabelImageType::SizeType{20, 1});
    image->Allocate(true);
    return image;
  };
  const auto observation = allocate(Filter::DisplacementFieldType::New());
  const auto confidence = allocate(Filter::ConfidenceImageType::New());
  for (const int x : {0, 19}) {
    observation->GetPixel({x, 0})[0] = x == 0 ? -4.0F : 4.0F;
    confidence->GetPixel({x, 0})[0] = 1.0F;
  }
  const auto filter = Filter::New();
  filter->SetInput(allocate(Filter::DisplacementFieldType::New()));
  filter->SetLabels(allocate(Filter::LabelImageType::New()));
  filter->SetModulus(0, 10.0);
  filter->SetObservationImage(observation);
  filter->SetConfidenceImage(confidence);
  filter->Update();
  for (int x = 0; x < 20; ++x) {
    std::cout << filter->GetOutput()->GetPixel({x, 0})[0] << ' ';
  }
  std::cout << "\n" << filter->GetDeviceUsed() << '\n';
  return filter->GetOutput()->GetPixel({0, 0})[0] < -3.8F ? 0 : 1;
}
