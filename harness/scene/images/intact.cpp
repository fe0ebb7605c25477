#include "harness/scene/images/intact.hpp"

#include "kernels/data/input_error.hpp"

#include <csetjmp>
#include <cstdio> // jpeglib.h needs FILE

#include <fmt/format.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <jpeglib.h>
#include <nifti1_io.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace hdmbench::images {

namespace {

InputError damaged(const std::filesystem::path& file, std::string_view how) {
  return InputError(
      fmt::format("cannot read the image {}: it is damaged or cut short: {}", file.string(), how));
}

/// Opening a pipe waits for someone who writes to it.
bool is_no_pipe(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored);
}

bool starts_with(const std::filesystem::path& file, std::string_view signature) {
  std::string found(signature.size(), '\0');
  std::ifstream(file, std::ios::binary).read(found.data(), static_cast<std::streamsize>(found.size()));
  return found == signature;
}

bool is_tiff(const std::filesystem::path& file) {
  using namespace std::string_view_literals;
  return starts_with(file, "II*\0"sv) || starts_with(file, "MM\0*"sv) || starts_with(file, "II+\0"sv) ||
         starts_with(file, "MM\0+"sv);
}

void require_intact_png(const std::filesystem::path& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, void (*)(png_imagep)> freed_at_the_end(&image, png_image_free);
  if (png_image_begin_read_from_file(&image, file.c_str()) != 0) {
    // A byte holds 8 pixels at most, and deflate packs at most 1032 of them into one.
    if (static_cast<double>(image.width) * image.height >
        8.0 * 1032.0 * static_cast<double>(std::filesystem::file_size(file))) {
      throw damaged(file, fmt::format("its header promises {} x {} pixels", image.width, image.height));
    }
    std::vector<png_byte> trial(PNG_IMAGE_SIZE(image));
    png_image_finish_read(&image, nullptr, trial.data(), 0, nullptr);
  }
  if (PNG_IMAGE_FAILED(image)) {
    throw damaged(file, image.message);
  }
}

struct JpegErrors {
  jpeg_error_mgr manager; // first, so that libjpeg's pointer to it is a pointer to this
  std::jmp_buf give_up;
  std::array<char, JMSG_LENGTH_MAX> words;
};

[[noreturn]] void give_up(j_common_ptr decoder) {
  auto* const errors = reinterpret_cast<JpegErrors*>(decoder->err);
  decoder->err->format_message(decoder, errors->words.data());
  std::longjmp(errors->give_up, 1);
}

/// A trial run; false: errors.words says why not. libjpeg comes back by longjmp: no destructors in here.
bool decodes(std::FILE* file, JpegErrors& errors) {
  jpeg_decompress_struct decoder{};
  decoder.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = give_up;
  errors.manager.emit_message = [](j_common_ptr common, int level) {
    if (level < 0) { // a warning: the file ends too early, or holds what cannot be decoded
      give_up(common);
    }
  };
  if (setjmp(errors.give_up) != 0) {
    jpeg_destroy_decompress(&decoder);
    return false;
  }
  jpeg_create_decompress(&decoder);
  jpeg_stdio_src(&decoder, file);
  jpeg_read_header(&decoder, TRUE);
  jpeg_start_decompress(&decoder);
  const JDIMENSION row_length = decoder.output_width * static_cast<JDIMENSION>(decoder.output_components);
  const JSAMPARRAY row =
      decoder.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&decoder), JPOOL_IMAGE, row_length, 1);
  while (decoder.output_scanline < decoder.output_height) {
    jpeg_read_scanlines(&decoder, row, 1);
  }
  jpeg_finish_decompress(&decoder);
  jpeg_destroy_decompress(&decoder);
  return true;
}

void require_intact_jpeg(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> opened(std::fopen(file.c_str(), "rb"), std::fclose);
  JpegErrors errors{};
  if (!opened || !decodes(opened.get(), errors)) {
    throw damaged(file, errors.words.data());
  }
}

/// ITK inverts the orientation with a library that ends the program where a number is not finite.
bool is_sound(const mat44& orientation, const nifti_image& header) {
  constexpr double largest = 1e10; // millimetres, and the inverse of the smallest
  for (const auto& row : orientation.m) {
    if (!std::ranges::all_of(row, [](float value) { return std::abs(value) <= largest; })) {
      return false;
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto& m = orientation.m;
    const double length = std::hypot(m[0][axis], m[1][axis], m[2][axis]);
    const double spacing = std::abs(header.pixdim[axis + 1]);
    if (!(length * largest >= 1.0 && spacing * largest >= 1.0 && spacing <= largest)) {
      return false;
    }
  }
  return true;
}

/// Plain or compressed, one file or header and pixels apart.
void require_intact_nifti(const std::filesystem::path& file) {
  const std::unique_ptr<nifti_image, void (*)(nifti_image*)> header(nifti_image_read(file.c_str(), 0),
                                                                    nifti_image_free);
  if (!header || header->iname == nullptr) {
    throw damaged(file, "its NIfTI header makes no sense");
  }
  if ((header->qform_code > 0 && !is_sound(header->qto_xyz, *header)) ||
      (header->sform_code > 0 && !is_sound(header->sto_xyz, *header))) {
    throw damaged(file, "its orientation (qform or sform) makes no sense");
  }
  const auto close = [](znzFile stream) { znzclose(stream); };
  const std::unique_ptr<znzptr, decltype(close)> stream(
      is_no_pipe(header->iname) ? znzopen(header->iname, "rb", nifti_is_gzfile(header->iname)) : nullptr,
      close);
  if (!stream) {
    throw damaged(file, fmt::format("{} with its pixels cannot be opened", header->iname));
  }
  const std::size_t needed =
      static_cast<std::size_t>(std::max(header->iname_offset, 0)) + nifti_get_volsize(header.get());
  std::vector<char> block(std::size_t{1} << 20);
  std::size_t found = 0;
  std::size_t length = 0;
  do { // to the end, where the checksum of a compressed file stands
    length = znzread(block.data(), 1, block.size(), stream.get());
    found += std::min(length, block.size());
  } while (length == block.size());
  if (length > block.size()) {
    throw damaged(file, "its compressed bytes cannot be decoded");
  }
  if (found < needed) {
    throw damaged(file, fmt::format("{} of {} bytes can be read", found, needed));
  }
}

/// How many bytes a zlib or gzip stream gives; no value where it is damaged or ends too early.
std::optional<std::uintmax_t> inflated_length(std::istream& compressed) {
  z_stream zlib{};
  constexpr int any_header = 32 + MAX_WBITS;
  if (inflateInit2(&zlib, any_header) != Z_OK) {
    return std::nullopt;
  }
  const std::unique_ptr<z_stream, int (*)(z_streamp)> freed_at_the_end(&zlib, inflateEnd);
  std::vector<char> in(std::size_t{1} << 16U);
  std::vector<Bytef> out(std::size_t{1} << 18U);
  std::uintmax_t length = 0;
  int status = Z_OK;
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
  }
  return status == Z_STREAM_END ? std::optional(length) : std::nullopt;
}

/// MetaIO reports success whatever it could read, and leaves the other pixels as they were.
void require_intact_meta_image(const std::filesystem::path& file) {
  require_sound_meta_header(file);
  const auto format = itk::MetaImageIO::New();
  format->SetFileName(file.string());
  format->ReadImageInformation();
  const MetaImage& header = *format->GetMetaImagePointer();
  if (!header.BinaryData()) {
    throw InputError(
        fmt::format("cannot read the image {}: its pixels are written as text (BinaryData = False), "
                    "where ITK does not notice missing ones",
                    file.string()));
  }
  const std::filesystem::path data_file = header.ElementDataFileName();
  const bool apart = data_file != "LOCAL" && data_file != "Local" && data_file != "local";
  const std::filesystem::path holder = apart ? file.parent_path() / data_file : file;
  std::ifstream data;
  if (is_no_pipe(holder)) {
    data.open(holder, std::ios::binary);
  }
  if (!data.is_open()) {
    throw damaged(file, fmt::format("{} with its pixels cannot be opened", data_file.string()));
  }
  for (std::string line; !apart && !line.starts_with("ElementDataFile") && std::getline(data, line);) {
  }
  const auto begin = data.tellg();
  data.seekg(0, std::ios::end);
  const auto stored = static_cast<std::uintmax_t>(data.tellg() - begin);
  data.seekg(begin);
  const auto found = header.CompressedData() ? inflated_length(data) : std::optional(stored);
  if (!found) {
    throw damaged(file, "its compressed bytes cannot be decoded");
  }
  const auto needed = static_cast<std::uintmax_t>(format->GetImageSizeInBytes());
  if (*found < needed) {
    throw damaged(file, fmt::format("{} bytes for {} bytes of pixels", *found, needed));
  }
}

} // namespace

void require_intact(const std::filesystem::path& file) {
  if (starts_with(file, "\x89PNG\r\n\x1a\n")) {
    require_intact_png(file);
  } else if (starts_with(file, "\xff\xd8")) {
    require_intact_jpeg(file);
  } else if (is_tiff(file)) {
    require_sound_tiff_directories(file);
  } else if (itk::NiftiImageIO::New()->CanReadFile(file.c_str())) {
    require_intact_nifti(file);
  } else if (itk::MetaImageIO::New()->CanReadFile(file.c_str())) {
    require_intact_meta_image(file);
  }
}

} // namespace hdmbench::images
