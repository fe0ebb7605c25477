#include "harness/scene/images/pixels.hpp"

#include "harness/scene/files.hpp"

#include <itkImageFileReader.h>
#include <itkJPEGImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkPNGImageIO.h>
#include <itkTIFFImageIO.h>
#include <itkVectorImage.h>
#include <sys/resource.h>
#include <zlib.h>

#include <fstream>
#include <new>
#include <sstream>
#include <system_error>

namespace hdmbench::images {

namespace {

InputError damaged(const std::filesystem::path& file, std::string_view how) {
  return unreadable(file, fmt::format("it is damaged or cut short: {}", how));
}

/// Throws InputError where the header of a NRRD or MetaImage file names a pipe with its pixels: opening it
/// would wait for someone who writes to it.
void require_no_pipe(const std::filesystem::path& file) {
  std::string header(1U << 13U, '\0');
  std::ifstream(file, std::ios::binary).read(header.data(), static_cast<std::streamsize>(header.size()));
  std::istringstream words(header);
  for (std::string word; words >> word;) {
    std::error_code ignored;
    if (std::filesystem::is_fifo(file.parent_path() / word, ignored)) {
      throw unreadable(file, fmt::format("{} with its pixels is a pipe", word));
    }
  }
}

/// How many bytes a zlib stream gives, or one of gzip with all its members; 0 where one is damaged or ends
/// too early.
std::uintmax_t inflated_length(std::istream& compressed) {
  z_stream zlib{};
  constexpr int any_header = 32 + MAX_WBITS;
  int status = inflateInit2(&zlib, any_header);
  std::vector<char> in(std::size_t{1} << 16U);
  std::vector<Bytef> out(std::size_t{1} << 18U);
  std::uintmax_t length = 0;
  while (status == Z_OK) {
    if (zlib.avail_in == 0) {
      compressed.read(in.data(), static_cast<std::streamsize>(in.size()));
      zlib.next_in = reinterpret_cast<Bytef*>(in.data());
      zlib.avail_in = static_cast<uInt>(compressed.gcount());
    }
    zlib.next_out = out.data();
    zlib.avail_out = static_cast<uInt>(out.size());
    status = inflate(&zlib, Z_NO_FLUSH); // Z_BUF_ERROR once the stream has run dry
    length += out.size() - zlib.avail_out;
    if (status == Z_STREAM_END && zlib.avail_in == 0 && compressed.peek() != EOF) {
      compressed.read(in.data(), static_cast<std::streamsize>(in.size()));
      zlib.next_in = reinterpret_cast<Bytef*>(in.data());
      zlib.avail_in = static_cast<uInt>(compressed.gcount());
    }
    constexpr Bytef begin_of_member = 0x1f; // what else follows is not looked at, by nobody
    if (status == Z_STREAM_END && zlib.avail_in > 0 && *zlib.next_in == begin_of_member) {
      status = inflateReset(&zlib);
    }
  }
  inflateEnd(&zlib);
  return status == Z_STREAM_END ? length : 0;
}

/// For the readers that do not look: that of NIfTI for the checksum of a compressed file, and JPEG's, which
/// makes grey pixels of those that are missing, for the mark at the end.
void require_whole(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const int first = stream.get();
  const int second = stream.get();
  stream.seekg(0);
  if (first == 0x1f && second == 0x8b && inflated_length(stream) == 0) {
    throw damaged(file, "its compressed bytes cannot be decoded");
  }
  if (first == 0xff && second == 0xd8) {
    const std::string bytes = read_file(file);
    const auto end = bytes.rfind("\xff\xd9");
    const auto scan = bytes.rfind("\xff\xda"); // in the bytes of pixels neither of them occurs
    if (end == std::string::npos || (scan != std::string::npos && scan > end)) {
      throw damaged(file, "the mark at the end of a JPEG image is missing");
    }
  }
}

/// MetaIO does not notice that compressed pixels cannot be decoded, or that pixels in words are missing.
void require_whole_meta_image(const std::filesystem::path& file, itk::MetaImageIO& format) {
  const MetaImage& header = *format.GetMetaImagePointer();
  if (!header.BinaryData()) {
    throw unreadable(file, "its pixels are written as text (BinaryData = False), where ITK does not notice "
                           "missing ones");
  }
  const std::string name = header.ElementDataFileName();
  const bool apart = name != "LOCAL" && name != "Local" && name != "local";
  const std::filesystem::path pixels = file.parent_path() / name;
  if (apart && !std::filesystem::exists(pixels)) {
    throw damaged(file, fmt::format("there is no file {} with its pixels", name));
  }
  if (!header.CompressedData()) {
    return;
  }
  std::ifstream data(file, std::ios::binary);
  bool says_length = false;
  for (std::string line; !line.starts_with("ElementDataFile") && std::getline(data, line);) {
    says_length = says_length || line.starts_with("CompressedDataSize");
  }
  if (!says_length) { // MetaIO then gives whatever the memory held
    throw unreadable(file, "its header has no CompressedDataSize");
  }
  if (apart) {
    data = std::ifstream(pixels, std::ios::binary);
  }
  if (inflated_length(data) < static_cast<std::uintmax_t>(format.GetImageSizeInBytes())) {
    throw damaged(file, "its compressed bytes cannot be decoded, or are too few");
  }
}

/// Throws InputError for a NRRD file that ends before its pixels, where they stand in it.
void require_whole_nrrd(const std::filesystem::path& file, const NrrdFields& fields,
                        const itk::ImageIOBase& format) {
  const auto encoding = fields.find("encoding");
  if (encoding == fields.end() ||
      !(encoding->second.starts_with("gz") || encoding->second.starts_with("GZ")) ||
      fields.contains("line skip") || fields.contains("byte skip")) {
    return;
  }
  std::ifstream data(file, std::ios::binary);
  for (std::string line; std::getline(data, line) && !line.empty() && line != "\r";) {
  }
  if (inflated_length(data) < static_cast<std::uintmax_t>(format.GetImageSizeInBytes())) {
    throw damaged(file, "its compressed bytes cannot be decoded, or are too few");
  }
}

/// Chosen by hand, not by ITK's factories: those are global state, and load what an environment variable
/// names.
itk::ImageIOBase::Pointer recognise(const std::filesystem::path& file) {
  const std::array<itk::ImageIOBase::Pointer, 5> formats{
      itk::NrrdImageIO::New().GetPointer(), itk::MetaImageIO::New().GetPointer(),
      itk::PNGImageIO::New().GetPointer(), itk::JPEGImageIO::New().GetPointer(),
      itk::TIFFImageIO::New().GetPointer()};
  const auto* const found = std::ranges::find_if(
      formats, [&](const itk::ImageIOBase::Pointer& format) { return format->CanReadFile(file.c_str()); });
  if (found == formats.end()) {
    throw unreadable(
        file, "its content or its name is not that of a NRRD, MetaImage, NIfTI, PNG, JPEG or TIFF image");
  }
  return *found;
}

/// ImageFileReader would drop the axes past the third without a word.
void require_reasonable(const std::filesystem::path& file, const itk::ImageIOBase& format, bool apart) {
  double values = format.GetNumberOfComponents();
  for (unsigned axis = 0; axis < format.GetNumberOfDimensions(); ++axis) {
    const auto size = format.GetDimensions(axis);
    if (axis > 2 && size != 1) {
      throw unreadable(
          file, fmt::format("axis {} has {} pixels, only three axes may have more than one", axis + 1, size));
    }
    values *= static_cast<double>(size);
  }
  require_reasonable_number(file, values);
  // More than any of their compressions makes of nothing but zeros. ITK would fill the memory first.
  constexpr double most_values_per_byte = 50000.0;
  const auto bytes = std::filesystem::file_size(file);
  const bool may_be_short = dynamic_cast<const itk::TIFFImageIO*>(&format) != nullptr ||
                            dynamic_cast<const itk::NrrdImageIO*>(&format) != nullptr;
  if (may_be_short && values > most_values_per_byte * static_cast<double>(bytes) && !apart) {
    throw damaged(file, fmt::format("{} bytes for {} values", bytes, values));
  }
}

using Image = itk::VectorImage<float, 3>;

/// `axes`: how many the file has.
Pixels pixels_of(const Image& image, unsigned axes) {
  Pixels pixels;
  pixels.geometry.components = image.GetNumberOfComponentsPerPixel();
  for (unsigned axis = 0; axis < 3; ++axis) {
    pixels.geometry.size[axis] = static_cast<int>(image.GetLargestPossibleRegion().GetSize()[axis]);
    // whatever ITK made of the third axis of a flat image
    pixels.geometry.spacing[axis] = image.GetSpacing()[axis == 2 && axes < 3 ? 0 : axis];
    pixels.geometry.origin[axis] = image.GetOrigin()[axis];
    for (unsigned row = 0; row < 3; ++row) {
      pixels.geometry.axes[axis][row] = image.GetDirection()(row, axis);
    }
  }
  pixels.values.assign(image.GetBufferPointer(), image.GetBufferPointer() + pixels.geometry.values());
  return pixels;
}

itk::ImageIOBase::Pointer format_to_write(const std::filesystem::path& file, bool is_picture) {
  const std::string name = file.filename();
  if (is_picture && name.ends_with(".png")) {
    return itk::PNGImageIO::New().GetPointer();
  }
  if (!is_picture && name.ends_with(".nrrd")) {
    return itk::NrrdImageIO::New().GetPointer();
  }
  if (!is_picture && name.ends_with(".mha")) {
    return itk::MetaImageIO::New().GetPointer();
  }
  if (!is_picture && name.ends_with(".nii.gz")) {
    return itk::NiftiImageIO::New().GetPointer();
  }
  throw unwritable(file, is_picture ? "the name of a picture must end in .png"
                                    : "the name of a field must end in .nrrd, .mha or .nii.gz");
}

/// Where the disk is full, or a file may not be that large, ITK 5.2 frees memory twice, or reports success.
void require_space(const std::filesystem::path& file, std::uintmax_t pixel_bytes) {
  constexpr std::uintmax_t header = 1U << 16U;
  const std::uintmax_t needed =
      pixel_bytes + pixel_bytes / 8 + header; // what cannot be compressed grows a little
  std::error_code error;
  const auto space = std::filesystem::space(file.parent_path(), error);
  rlimit limit{};
  const bool is_limited = getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < needed;
  if (is_limited || (!error && space.available < needed)) {
    throw unwritable(
        file, fmt::format("{} bytes {}, {} may be needed", is_limited ? limit.rlim_cur : space.available,
                          is_limited ? "are all that a file may have (ulimit -f)" : "are free on the disk",
                          needed));
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

namespace {

/// Reads a file of one of the formats that ITK reads.
Pixels read_by_itk(const std::filesystem::path& file) {
  const auto format = recognise(file);
  format->SetFileName(file.string());
  format->ReadImageInformation();
  const NrrdFields fields = nrrd_fields(file);
  const bool apart = fields.contains("data file") || fields.contains("datafile");
  require_reasonable(file, *format, apart);
  if (dynamic_cast<itk::TIFFImageIO*>(format.GetPointer()) != nullptr) {
    if (auto integers = read_tiff_integers(file)) {
      return std::move(*integers);
    }
  }
  auto* const meta = dynamic_cast<itk::MetaImageIO*>(format.GetPointer());
  const bool is_nrrd = dynamic_cast<itk::NrrdImageIO*>(format.GetPointer()) != nullptr;
  if (meta != nullptr) {
    require_whole_meta_image(file, *meta);
  }
  if (is_nrrd && !apart) {
    require_whole_nrrd(file, fields, *format);
  }
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetFileName(file.string());
  reader->SetImageIO(format);
  reader->Update();
  Pixels pixels = pixels_of(*reader->GetOutput(), format->GetNumberOfDimensions());
  pixels.geometry.stated = meta != nullptr ? Stated::place : Stated::nothing;
  if (is_nrrd) {
    correct_nrrd_place(file, fields, pixels.geometry);
  }
  return pixels;
}

} // namespace

void make_factories() {
  (void)itk::PNGImageIO::New();
}

Pixels read_pixels_here(const std::filesystem::path& file) {
  try {
    require_no_pipe(file);
    if (is_transform(file)) {
      return read_transform(file);
    }
    require_whole(file);
    return is_nifti(file) ? read_nifti(file) : read_by_itk(file);
  } catch (const itk::ExceptionObject& error) {
    throw unreadable(file, own_words(error));
  } catch (const std::bad_alloc&) {
    throw unreadable(file, "it does not fit into memory");
  }
}

namespace {

/// What is written before a .nii.gz beside it: the same, not compressed.
struct Plain {
  explicit Plain(const std::filesystem::path& compressed)
      : file(compressed.parent_path() / compressed.stem()) {}
  Plain(const Plain&) = delete;
  Plain& operator=(const Plain&) = delete;
  ~Plain() {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
  }

  std::filesystem::path file;
};

} // namespace

void write_pixels(const std::filesystem::path& file, const Geometry& geometry, const Values& values,
                  const Keys& keys) {
  const bool is_picture = std::holds_alternative<std::vector<unsigned char>>(values);
  const auto format = format_to_write(file, is_picture);
  const auto write = [&]<typename Value>(const std::filesystem::path& partial,
                                         const std::vector<Value>& stored) {
    require_space(partial, stored.size() * sizeof(Value));
    const unsigned axes = is_picture ? 2 : 3;
    format->SetNumberOfDimensions(axes);
    itk::ImageIORegion region(axes);
    for (unsigned axis = 0; axis < axes; ++axis) {
      const auto size = static_cast<itk::SizeValueType>(geometry.size[axis]);
      const auto& direction = geometry.axes[axis];
      format->SetDimensions(axis, size);
      format->SetSpacing(axis, geometry.spacing[axis]);
      format->SetOrigin(axis, geometry.origin[axis]);
      format->SetDirection(axis, std::vector(direction.begin(), direction.begin() + axes));
      region.SetSize(axis, size);
    }
    format->SetIORegion(region);
    format->SetNumberOfComponents(static_cast<unsigned>(geometry.components));
    format->SetPixelType(geometry.components == 1 ? itk::IOPixelEnum::SCALAR
                         : is_picture             ? itk::IOPixelEnum::RGB
                                                  : itk::IOPixelEnum::VECTOR);
    format->SetComponentType(itk::ImageIOBase::MapPixelType<Value>::CType);
    for (const auto& [key, text] : keys) {
      itk::EncapsulateMetaData<std::string>(format->GetMetaDataDictionary(), key, text);
    }
    format->SetUseCompression(keys.empty());
    format->SetFileName(partial.string());
    format->WriteImageInformation();
    format->Write(stored.data());
  };
  const bool is_marked = !keys.empty() && dynamic_cast<itk::NiftiImageIO*>(format.GetPointer()) != nullptr;
  write_atomically(file, [&](const std::filesystem::path& partial) {
    try {
      if (is_marked) {
        const Plain plain(partial);
        std::visit([&](const auto& stored) { write(plain.file, stored); }, values);
        write_as_displacement(plain.file, partial);
      } else {
        std::visit([&](const auto& stored) { write(partial, stored); }, values);
      }
    } catch (const itk::ExceptionObject& error) {
      throw unwritable(file, own_words(error));
    }
  });
}

} // namespace hdmbench::images
