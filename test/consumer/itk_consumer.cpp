#include <itkHDMRegularizationFilter.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkNrrdImageIO.h>

#include <iostream>

/// A row of 20 pixels whose ends are pulled apart: writes the displacement to the file FILE.nrrd, reads and
/// prints it; it must have moved.
int main(int argc, char** argv) {
  if (argc != 2) {
    return 2;
  }
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
  const auto writer = itk::ImageFileWriter<Filter::DisplacementFieldType>::New();
  writer->SetImageIO(itk::NrrdImageIO::New());
  writer->SetFileName(argv[1]);
  writer->SetInput(filter->GetOutput());
  writer->Update();
  const auto reader = itk::ImageFileReader<Filter::DisplacementFieldType>::New();
  reader->SetImageIO(itk::NrrdImageIO::New());
  reader->SetFileName(argv[1]);
  reader->Update();
  for (int x = 0; x < 20; ++x) {
    std::cout << reader->GetOutput()->GetPixel({x, 0})[0] << ' ';
  }
  std::cout << "\n" << filter->GetDeviceUsed() << '\n';
  return reader->GetOutput()->GetPixel({0, 0})[0] < -3.8F ? 0 : 1;
}
