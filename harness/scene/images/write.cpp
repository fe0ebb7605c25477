#include "harness/scene/images/images.hpp"

#include "harness/scene/displacement_file.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/images/pixels.hpp"

#include "kernels/data/input_error.hpp"
#include "kernels/data/level.hpp"

#include <fmt/format.h>
#include <itkImageFileWriter.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkPNGImageIO.h>
#include <itkRGBPixel.h>
#include <itkVector.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace hdmbench {

namespace {

InputError unwritable(const std::filesystem::path& file, std::string_view why) {
  return InputError(fmt::format("cannot write the image {}: {}", file.string(), why));
}

/// Where the disk is full, or a file may not be that large, ITK 5.2 frees memory twice, or reports success.
void require_space(const std::filesystem::path& file, std::uintmax_t pixel_bytes) {
  constexpr std::uintmax_t header = 1U << 16U;
  const std::uintmax_t needed =
      pixel_bytes + pixel_bytes / 8 + header; // what cannot be compressed grows a little
  std::error_code error;
  const auto space = std::filesystem::space(file.parent_path(), error);
  if (!error && space.available < needed) {
    throw unwritable(file,
                     fmt::format("{} bytes are free on the disk, {} may be needed", space.available, needed));
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < needed) {
    throw unwritable(
        file, fmt::format("files may have {} bytes (ulimit -f), {} may be needed", limit.rlim_cur, needed));
  }
}

template <typename Picture>
void write_file(const std::filesystem::path& file, const Picture* picture, itk::ImageIOBase* format) {
  write_atomically(file, [&](const std::filesystem::path& partial) {
    require_space(partial, picture->GetLargestPossibleRegion().GetNumberOfPixels() *
                               sizeof(typename Picture::PixelType));
    try {
      const auto writer = itk::ImageFileWriter<Picture>::New();
      writer->SetFileName(partial.string());
      writer->SetImageIO(format);
      writer->SetInput(picture);
      writer->SetUseCompression(true);
      writer->Update();
    } catch (const itk::ExceptionObject& error) {
      throw unwritable(file, images::own_words(error));
    }
  });
}

template <typename Picture>
typename Picture::Pointer allocate(Extent extent) {
  typename Picture::SizeType size;
  size.Fill(1);
  size[0] = static_cast<itk::SizeValueType>(extent.width);
  size[1] = static_cast<itk::SizeValueType>(extent.height);
  const auto picture = Picture::New();
  picture->SetRegions(size);
  picture->Allocate();
  return picture;
}

void require_png(const std::filesystem::path& file) {
  if (file.extension() != ".png") {
    throw unwritable(file, "the name of a picture must end in .png");
  }
}

struct Colour {
  double red, green, blue;
};

/// From black by violet, red and orange to light yellow: the brightness rises all the way, so that the order
/// shows in grey and to the colour-blind as well. Equal distances in `fraction`, 0 ... 1.
Colour colour_of(double fraction) {
  constexpr std::array<Colour, 7> ramp{{{0, 0, 0},
                                        {40, 11, 84},
                                        {110, 25, 110},
                                        {180, 45, 85},
                                        {230, 95, 40},
                                        {250, 165, 25},
                                        {255, 250, 175}}};
  const double position = std::clamp(fraction, 0.0, 1.0) * (ramp.size() - 1);
  const std::size_t from = std::min(static_cast<std::size_t>(position), ramp.size() - 2);
  const double share = position - static_cast<double>(from);
  const Colour& a = ramp[from];
  const Colour& b = ramp[from + 1];
  return {std::lerp(a.red, b.red, share), std::lerp(a.green, b.green, share),
          std::lerp(a.blue, b.blue, share)};
}

/// Not a number becomes 0.
unsigned char to_byte(double gray) {
  return static_cast<unsigned char>(std::lround(gray > 0.0 ? std::min(gray, 255.0) : 0.0));
}

/// `colour` gives the colour of a site by its index.
template <typename SiteColour>
void write_colours(const std::filesystem::path& file, Extent extent, const SiteColour& colour) {
  using Pixel = itk::RGBPixel<unsigned char>;
  const auto picture = allocate<itk::Image<Pixel, 2>>(extent);
  Pixel* const pixels = picture->GetBufferPointer();
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const Colour own = colour(site);
    pixels[site].Set(to_byte(own.red), to_byte(own.green), to_byte(own.blue));
  }
  write_file(file, picture.GetPointer(), itk::PNGImageIO::New());
}

itk::ImageIOBase::Pointer format_of_values(const std::filesystem::path& file) {
  if (file.extension() == ".nrrd") {
    return itk::NrrdImageIO::New().GetPointer();
  }
  if (file.extension() == ".mha") {
    return itk::MetaImageIO::New().GetPointer();
  }
  throw unwritable(file, "the name of a field must end in .nrrd or .mha");
}

void require_spacing(const std::filesystem::path& file, double spacing) {
  if (!(spacing > 0.0) || !std::isfinite(spacing)) {
    throw unwritable(file, fmt::format("a pixel of {} mm", spacing));
  }
}

/// W x H x 1.
template <typename Pixel>
typename itk::Image<Pixel, 3>::Pointer allocate_values(const std::filesystem::path& file, Extent extent,
                                                       double spacing, const Placement& placement) {
  require_spacing(file, spacing);
  using Field = itk::Image<Pixel, 3>;
  auto field = allocate<Field>(extent);
  typename Field::SpacingType spacings;
  spacings.Fill(spacing);
  spacings[2] = placement.thickness > 0.0 ? placement.thickness : spacing;
  field->SetSpacing(spacings);
  field->SetOrigin(placement.origin.data());
  typename Field::DirectionType direction;
  for (unsigned axis = 0; axis < 3; ++axis) {
    for (unsigned row = 0; row < 3; ++row) {
      direction(row, axis) = placement.axes[axis][row];
    }
  }
  field->SetDirection(direction);
  return field;
}

} // namespace

void write_displacement(const std::filesystem::path& file, const VectorField& displacement, double spacing,
                        const Placement& placement) {
  const auto format = format_of_values(file);
  validate(displacement, displacement.extent, "the displacement to write");
  if (file.extension() == ".nrrd") { // ranks write their parts of such a file, too, so it is not ITK's
    require_spacing(file, spacing);
    return write_displacement_file(file, displacement, spacing, placement);
  }
  const auto field = allocate_values<itk::Vector<float, 3>>(file, displacement.extent, spacing, placement);
  const std::vector<float> values =
      displacement_values(displacement, 0, displacement.extent.sites(), spacing, placement);
  std::ranges::copy(values, field->GetBufferPointer()->GetDataPointer());
  auto& keys = field->GetMetaDataDictionary();
  for (const auto& [key, text] : displacement_keys) {
    itk::EncapsulateMetaData<std::string>(keys, std::string(key), std::string(text));
  }
  write_file(file, field.GetPointer(), format);
}

void write_scalar(const std::filesystem::path& file, const ScalarField& field, double spacing,
                  const Placement& placement) {
  const auto format = format_of_values(file);
  const auto image = allocate_values<float>(file, field.extent, spacing, placement);
  std::ranges::copy(field.values, image->GetBufferPointer());
  write_file(file, image.GetPointer(), format);
}

void write_vector(const std::filesystem::path& file, const VectorField& field, double spacing,
                  const Placement& placement) {
  const auto format = format_of_values(file);
  const auto image = allocate_values<itk::Vector<float, 2>>(file, field.extent, spacing, placement);
  auto* const values = image->GetBufferPointer();
  for (std::size_t site = 0; site < field.extent.sites(); ++site) {
    values[site][0] = field.x[site];
    values[site][1] = field.y[site];
  }
  write_file(file, image.GetPointer(), format);
}

void write_labels(const std::filesystem::path& file, const LabelField& labels, double spacing,
                  const Placement& placement) {
  const auto format = format_of_values(file);
  const auto image = allocate_values<std::int16_t>(file, labels.extent, spacing, placement);
  std::ranges::transform(labels.values, image->GetBufferPointer(), [&](int label) {
    if (!std::in_range<std::int16_t>(label)) {
      throw unwritable(file, fmt::format("the label {} is beyond 16 bits", label));
    }
    return static_cast<std::int16_t>(label);
  });
  write_file(file, image.GetPointer(), format);
}

void write_png(const std::filesystem::path& file, const ScalarField& picture) {
  require_png(file);
  using Gray = itk::Image<unsigned char, 2>;
  const auto bytes = allocate<Gray>(picture.extent);
  std::ranges::transform(picture.values, bytes->GetBufferPointer(), to_byte);
  write_file(file, bytes.GetPointer(), itk::PNGImageIO::New());
}

void write_magnitude_png(const std::filesystem::path& file, const VectorField& displacement, double largest) {
  require_png(file);
  validate(displacement, displacement.extent, "the displacement to write");
  write_colours(file, displacement.extent, [&](std::size_t site) {
    const double magnitude = std::hypot(displacement.x[site], displacement.y[site]);
    return colour_of(magnitude > 0.0 ? magnitude / largest : 0.0);
  });
}

void write_signed_png(const std::filesystem::path& file, Extent extent, std::span<const float> values,
                      double largest, const ScalarField& picture) {
  require_png(file);
  if (values.size() != extent.sites() || (!picture.values.empty() && picture.extent != extent) ||
      !std::ranges::all_of(values, [](float v) { return std::isfinite(v); })) {
    throw unwritable(file, "the values are not finite or not one per site");
  }
  write_colours(file, extent, [&](std::size_t site) {
    const double fraction = std::clamp(static_cast<double>(values[site]) / largest, -1.0, 1.0);
    const Colour end = fraction < 0.0 ? Colour{20, 70, 180} : Colour{180, 30, 30};
    // Some of the picture is seen through the strongest colour.
    const double gray =
        picture.values.empty() ? 255.0 : std::clamp(static_cast<double>(picture.values[site]), 0.0, 255.0);
    const double share = (picture.values.empty() ? 1.0 : 0.7) * std::abs(fraction);
    return Colour{std::lerp(gray, end.red, share), std::lerp(gray, end.green, share),
                  std::lerp(gray, end.blue, share)};
  });
}

} // namespace hdmbench
