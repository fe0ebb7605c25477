#include "harness/scene/images/pixels.hpp"

#include "harness/scene/images/intact.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <itkImageFileReader.h>
#include <itkJPEGImageIO.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkPNGImageIO.h>
#include <itkTIFFImageIO.h>

#include <fstream>
#include <new>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>

namespace hdmbench::images {

namespace {

template <typename Error = InputError>
Error unreadable(const std::filesystem::path& file, std::string_view why) {
  return Error(fmt::format("cannot read the image {}: {}", file.string(), why));
}

/// ITK reports a folder and a missing file as an unknown format.
void require_file(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    throw unreadable<MissingFile>(file, "there is no such file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw unreadable(file, "it is not a file");
  }
  if (!std::ifstream(file)) {
    throw unreadable(file, "it may not be opened (permission denied)");
  }
}

/// Chosen by hand, not by ITK's factories: those are global state, and load what an environment variable
/// names.
template <typename... Formats>
itk::ImageIOBase::Pointer first_that_can_read(const std::filesystem::path& file) {
  itk::ImageIOBase::Pointer found;
  const auto try_format = [&](itk::ImageIOBase::Pointer format) {
    if (format->CanReadFile(file.c_str())) {
      found = format;
    }
    return found.IsNotNull();
  };
  (try_format(Formats::New().GetPointer()) || ...);
  return found;
}

/// What a NRRD header says of where its pixels are; nothing where they follow it.
std::optional<std::string> nrrd_data_file(const std::filesystem::path& file) {
  std::ifstream header(file, std::ios::binary);
  std::string line;
  if (!std::getline(header, line) || !line.starts_with("NRRD")) {
    return std::nullopt;
  }
  while (std::getline(header, line) && line.find_first_not_of("\r") != std::string::npos) {
    if (line.starts_with("data file:") || line.starts_with("datafile:")) {
      const auto name = line.find_first_not_of(" \t", line.find(':') + 1);
      return name == std::string::npos ? "" : line.substr(name, line.find_last_not_of(" \t\r") + 1 - name);
    }
  }
  return std::nullopt;
}

/// Opening a pipe waits for someone who writes to it. Where the header names several files the name is none.
void require_no_pipe(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path holder = file.parent_path() / nrrd_data_file(file).value_or("");
  if (std::filesystem::is_fifo(holder, ignored)) {
    throw unreadable(file, fmt::format("{} with its pixels is a pipe", holder.string()));
  }
}

itk::ImageIOBase::Pointer recognise(const std::filesystem::path& file) {
  const auto format = first_that_can_read<itk::NrrdImageIO, itk::MetaImageIO, itk::NiftiImageIO,
                                          itk::PNGImageIO, itk::JPEGImageIO, itk::TIFFImageIO>(file);
  if (format.IsNull()) {
    throw unreadable(
        file, "its content or its name is not that of a NRRD, MetaImage, NIfTI, PNG, JPEG or TIFF image");
  }
  format->SetFileName(file.string());
  format->ReadImageInformation();
  return format;
}

/// Whether the pixels may be in another file: NRRD with a line "data file: ...". MetaImage and NIfTI, which
/// know that as well, have passed require_intact.
bool may_be_apart(const std::filesystem::path& file, const itk::ImageIOBase& format) {
  if (dynamic_cast<const itk::NrrdImageIO*>(&format) == nullptr) {
    return dynamic_cast<const itk::TIFFImageIO*>(&format) == nullptr;
  }
  return nrrd_data_file(file).has_value();
}

/// ImageFileReader would drop the axes past the third without a word.
void require_reasonable(const std::filesystem::path& file, const itk::ImageIOBase& format) {
  double values = format.GetNumberOfComponents();
  for (unsigned axis = 0; axis < format.GetNumberOfDimensions(); ++axis) {
    const auto size = format.GetDimensions(axis);
    if (axis > 2 && size != 1) {
      throw unreadable(
          file, fmt::format("axis {} has {} pixels, only three axes may have more than one", axis + 1, size));
    }
    values *= static_cast<double>(size);
  }
  constexpr double most_values = 1 << 30; // 4 GiB as float
  if (!(values >= 1.0 && values <= most_values)) {
    throw unreadable(file,
                     fmt::format("its header promises {} values, 1 to {} can be read", values, most_values));
  }
  // What the best of their compressions, bzip2, makes of nothing but zeros. ITK would fill the memory first.
  constexpr double most_values_per_byte = 50000.0;
  const auto bytes = std::filesystem::file_size(file);
  if (!may_be_apart(file, format) && values > most_values_per_byte * static_cast<double>(bytes)) {
    throw unreadable(file, fmt::format("it is damaged or cut short: {} bytes for {} values", bytes, values));
  }
}

} // namespace

std::string own_words(const itk::ExceptionObject& error) {
  std::istringstream description(error.GetDescription());
  std::string words;
  for (std::string word; description >> word;) {
    words += (words.empty() ? "" : " ") + word;
  }
  // "ITK ERROR: PNGImageIO(0x5581): ..."
  if (words.starts_with("ITK ERROR: ") || words.starts_with("itk::ERROR: ")) {
    const auto address_end = words.find("): ");
    words.erase(0, address_end == std::string::npos ? 0 : address_end + 3);
  }
  // "... [nrrd] nrrdRead: trouble [nrrd] _nrrdEncodingRaw_read: fread got only ...": the last one says why
  if (const auto last = words.rfind("[nrrd] "); last != std::string::npos) {
    words.erase(0, words.find(": ", last) + 2);
  }
  return words;
}

Pixels::Pointer read_pixels(const std::filesystem::path& file) {
  require_file(file);
  try {
    require_intact(file);
    require_no_pipe(file);
    const auto format = recognise(file);
    require_reasonable(file, *format);
    const auto reader = itk::ImageFileReader<Pixels>::New();
    reader->SetFileName(file.string());
    reader->SetImageIO(format);
    reader->Update();
    if (format->GetNumberOfDimensions() < 3) { // whatever ITK made of the third one
      Pixels::SpacingType spacing = reader->GetOutput()->GetSpacing();
      spacing[2] = spacing[0];
      reader->GetOutput()->SetSpacing(spacing);
    }
    return reader->GetOutput();
  } catch (const itk::ExceptionObject& error) {
    throw unreadable(file, own_words(error));
  } catch (const std::bad_alloc&) {
    throw unreadable(file, "it does not fit into memory");
  }
}

} // namespace hdmbench::images
