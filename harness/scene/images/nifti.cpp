#include "harness/scene/images/pixels.hpp"

#include <nifti1_io.h>
#include <zlib.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <numeric>

// NIfTI files are read here, and not by ITK's reader: that turns values that are not finite into 0, refuses
// directions that are off by rounding, takes an origin in metres for millimetres, and reads a header whose
// offset is wrong as pixels.

namespace hdmbench::images {

namespace {

using Header = std::unique_ptr<nifti_1_header, decltype(&std::free)>;
using Stream = std::unique_ptr<gzFile_s, int (*)(gzFile)>;
using Details = std::unique_ptr<nifti_image, decltype(&nifti_image_free)>;

Matrix matrix_of(const mat44& stored) {
  Matrix matrix{};
  for (std::size_t row = 0; row < matrix.size(); ++row) {
    std::copy_n(stored.m[row], matrix[row].size(), matrix[row].begin());
  }
  return matrix;
}

/// The most that the places of a voxel lie apart, in voxels.
double farthest_apart(const Frame& a, const Frame& b, const std::array<int, 3>& size) {
  double farthest = 0.0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Placement::Vector way{};
    for (std::size_t row = 0; row < 3; ++row) {
      way[row] = a.origin[row] - b.origin[row];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        way[row] += static_cast<int>(corner >> axis & 1U) * (size[axis] - 1) *
                    (a.columns[axis][row] - b.columns[axis][row]);
      }
    }
    farthest = std::max(farthest, length_of(way));
  }
  const auto& columns = a.columns;
  return farthest / std::min({length_of(columns[0]), length_of(columns[1]), length_of(columns[2])});
}

double millimetres_of(const std::filesystem::path& file, int unit) {
  switch (unit) {
  case NIFTI_UNITS_UNKNOWN:
  case NIFTI_UNITS_MM:
    return 1.0;
  case NIFTI_UNITS_METER:
    return 1000.0;
  case NIFTI_UNITS_MICRON:
    return 0.001;
  default:
    throw unreadable(file, fmt::format("its unit of length is number {}, which NIfTI does not have", unit));
  }
}

/// What NIfTI's library would mend without a word.
void require_possible_header(const std::filesystem::path& file, const nifti_1_header& header) {
  for (int axis = 1; axis <= std::min<int>(header.dim[0], 3); ++axis) {
    if (!(std::isfinite(header.pixdim[axis]) && header.pixdim[axis] > 0.0F)) {
      throw unreadable(file,
                       fmt::format("its header has a voxel of {} mm along axis {} (pixdim): none of zero, "
                                   "negative or non-finite size is possible",
                                   header.pixdim[axis], axis));
    }
  }
  for (int axis = 4; axis <= header.dim[0]; ++axis) {
    if (header.dim[axis] > 1 && axis != 5) {
      throw unreadable(file, fmt::format("axis {} has {} pixels, only three axes may have more than one",
                                         axis, header.dim[axis]));
    }
  }
}

/// Where the voxels lie by the header's sform, else by its qform, as nibabel, FSL and SPM have it.
void place_by_header(const std::filesystem::path& file, const nifti_image& details, Geometry& geometry) {
  const double unit = millimetres_of(file, details.xyz_units);
  const std::array<double, 3> sides{details.dx * unit, details.dy * unit, details.dz * unit};
  if (details.sform_code <= 0 && details.qform_code <= 0) {
    remark(file,
           "it has neither sform nor qform and does not say how it lies: its rows are taken to lead to the "
           "left, its columns to the back");
    geometry.spacing = sides;
    geometry.axes = Placement{}.axes;
    geometry.stated = Stated::sides;
    return;
  }
  const Frame by_sform = lps_of(matrix_of(details.sto_xyz), unit);
  const Frame by_qform = lps_of(matrix_of(details.qto_xyz), unit);
  const bool has_sform = details.sform_code > 0;
  const Frame& frame = has_sform ? by_sform : by_qform;
  place(file, frame, sides, details.ndim < 3 ? 2 : 3, has_sform ? "sform" : "qform", geometry);
  if (has_sform && details.qform_code > 0) {
    if (const double apart = farthest_apart(by_sform, by_qform, geometry.size); !(apart <= 0.1)) {
      remark(file, fmt::format("its sform and its qform say different places, up to {:.3g} voxels apart: the "
                               "sform is taken, as nibabel, FSL and SPM do",
                               apart));
    }
  }
}

/// NIfTI's library would take the end of the header for pixels.
void require_pixels_behind_header(const std::filesystem::path& file, const nifti_1_header& header) {
  constexpr float after_header = 352.0F; // and the four bytes that say whether there is an extension
  const bool is_one_file = std::string_view(header.magic, 3) == std::string_view("n+1", 3);
  if (is_one_file && !(header.vox_offset >= after_header && header.vox_offset < 1e9F)) {
    throw unreadable(file,
                     fmt::format("its header says that the pixels begin at byte {:g} (vox_offset), within "
                                 "the header",
                                 header.vox_offset));
  }
}

/// The numbers of one type in a file, as floats.
template <typename Number>
std::vector<float> converted(const std::vector<char>& bytes) {
  std::vector<float> values(bytes.size() / sizeof(Number));
  for (std::size_t i = 0; i < values.size(); ++i) {
    Number number{};
    std::memcpy(&number, bytes.data() + i * sizeof number, sizeof number);
    values[i] = static_cast<float>(number);
  }
  return values;
}

std::vector<float> values_of(const std::filesystem::path& file, int type, const std::vector<char>& bytes) {
  switch (type) {
  case NIFTI_TYPE_UINT8:
  case NIFTI_TYPE_RGB24:
  case NIFTI_TYPE_RGBA32:
    return converted<std::uint8_t>(bytes);
  case NIFTI_TYPE_INT8:
    return converted<std::int8_t>(bytes);
  case NIFTI_TYPE_INT16:
    return converted<std::int16_t>(bytes);
  case NIFTI_TYPE_UINT16:
    return converted<std::uint16_t>(bytes);
  case NIFTI_TYPE_INT32:
    return converted<std::int32_t>(bytes);
  case NIFTI_TYPE_UINT32:
    return converted<std::uint32_t>(bytes);
  case NIFTI_TYPE_INT64:
    return converted<std::int64_t>(bytes);
  case NIFTI_TYPE_UINT64:
    return converted<std::uint64_t>(bytes);
  case NIFTI_TYPE_FLOAT32:
    return converted<float>(bytes);
  case NIFTI_TYPE_FLOAT64:
    return converted<double>(bytes);
  default:
    throw unreadable(file, fmt::format("its pixels are of the type {}, integers and reals can be read",
                                       nifti_datatype_string(type)));
  }
}

/// The pixels' bytes in this machine's order.
std::vector<char> bytes_of(const std::filesystem::path& file, const nifti_image& details, bool is_swapped,
                           std::size_t count) {
  constexpr std::uintmax_t most_compression = 1100; // of zeros by gzip; the memory is not filled for less
  std::error_code ignored;
  if (const std::uintmax_t size = std::filesystem::file_size(details.iname, ignored);
      !ignored && count / most_compression > size) {
    throw unreadable(file,
                     fmt::format("it is damaged or cut short: {} bytes for {} bytes of pixels", size, count));
  }
  std::vector<char> bytes(count);
  const Stream stream(gzopen(details.iname, "rb"), &gzclose);
  if (stream == nullptr) {
    throw unreadable(file, fmt::format("there is no file {} with its pixels", details.iname));
  }
  std::size_t read = 0;
  if (gzseek(stream.get(), details.iname_offset, SEEK_SET) == details.iname_offset) {
    constexpr std::size_t most = std::size_t{1} << 30U;
    for (int got = 1; got > 0 && read < count; read += static_cast<std::size_t>(std::max(got, 0))) {
      got = gzread(stream.get(), bytes.data() + read, static_cast<unsigned>(std::min(most, count - read)));
    }
  }
  if (read < count) {
    throw unreadable(
        file,
        fmt::format("it is damaged or cut short: {} of the {} bytes of its pixels are there", read, count));
  }
  if (is_swapped && details.swapsize > 1) {
    const auto size = static_cast<std::size_t>(details.swapsize);
    nifti_swap_Nbytes(count / size, details.swapsize, bytes.data());
  }
  return bytes;
}

/// Returns the components of each pixel one after the other; a file has all first components first.
std::vector<float> interleaved(std::vector<float> values, std::size_t components) {
  const std::size_t pixels = values.size() / components;
  std::vector<float> result(values.size());
  for (std::size_t component = 0; component < components; ++component) {
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      result[pixel * components + component] = values[component * pixels + pixel];
    }
  }
  return result;
}

} // namespace

bool is_nifti(const std::filesystem::path& file) {
  nifti_set_debug_level(0);
  const int kind = is_nifti_file(file.c_str());
  if (kind == 0) {
    throw unreadable(file,
                     "it is an Analyze 7.5 file, which does not say which side is left; convert it to NIfTI");
  }
  return kind > 0;
}

Pixels read_nifti(const std::filesystem::path& file) {
  int is_swapped = 0;
  const Header header(nifti_read_header(file.c_str(), &is_swapped, 1), &std::free);
  const Details details(header == nullptr ? nullptr : nifti_convert_nhdr2nim(*header, file.c_str()),
                        &nifti_image_free);
  if (details == nullptr) {
    throw unreadable(file, "its header is not that of a NIfTI image");
  }
  require_possible_header(file, *header);
  Pixels pixels;
  Geometry& geometry = pixels.geometry;
  const auto at_least_one = [](auto count) {
    return std::max(static_cast<int>(count), 1);
  }; // 0: no such axis
  geometry.size = {at_least_one(details->nx), at_least_one(details->ny), at_least_one(details->nz)};
  const bool is_colour = details->datatype == NIFTI_TYPE_RGB24 || details->datatype == NIFTI_TYPE_RGBA32;
  geometry.components = is_colour ? static_cast<std::size_t>(details->nbyper)
                                  : static_cast<std::size_t>(at_least_one(details->nu));
  require_reasonable_number(file, geometry);
  place_by_header(file, *details, geometry);
  require_pixels_behind_header(file, *header);
  const auto width = is_colour ? std::size_t{1} : static_cast<std::size_t>(details->nbyper);
  pixels.values = values_of(file, details->datatype,
                            bytes_of(file, *details, is_swapped != 0, geometry.values() * width));
  if (!is_colour) {
    pixels.values = interleaved(std::move(pixels.values), geometry.components);
    const auto slope = double{details->scl_slope};
    const auto intercept = double{details->scl_inter};
    if (slope != 0.0 && (slope != 1.0 || intercept != 0.0)) {
      std::ranges::transform(pixels.values, pixels.values.begin(), [&](float value) {
        return static_cast<float>(slope * double{value} + intercept);
      });
    }
  }
  if (details->intent_code == NIFTI_INTENT_SYMMATRIX && geometry.components == 6) {
    for (std::size_t i = 0; i < pixels.values.size(); i += 6) { // xx, xy, yy, xz, yz, zz
      std::swap(pixels.values[i + 2], pixels.values[i + 3]);
    }
  }
  if (details->intent_code == NIFTI_INTENT_DISPVECT) { // along NIfTI's own axes
    for (std::size_t i = 0; i < pixels.values.size(); ++i) {
      pixels.values[i] = i % geometry.components < 2 ? 0.0F - pixels.values[i] : pixels.values[i];
    }
  }
  return pixels;
}

void write_as_displacement(const std::filesystem::path& plain, const std::filesystem::path& file) {
  std::ifstream from(plain, std::ios::binary);
  // Runs of the same byte (R) are all that zlib finds in floats, and it finds them in a quarter of the time.
  Stream to(gzopen(file.c_str(), "wbR"), &gzclose);
  const std::uintmax_t size = std::filesystem::file_size(plain);
  std::uintmax_t begin = 0; // of the components along x and y, which the file has before those along z
  std::uintmax_t end = 0;
  std::vector<char> block(std::size_t{1} << 20U);
  for (std::uintmax_t at = 0; at < size; at += block.size()) {
    block.resize(static_cast<std::size_t>(std::min<std::uintmax_t>(block.size(), size - at)));
    from.read(block.data(), std::ssize(block));
    if (nifti_1_header header{}; at == 0 && block.size() >= sizeof header) { // written here, in this order
      std::memcpy(&header, block.data(), sizeof header);
      header.intent_code = NIFTI_INTENT_DISPVECT;
      std::memcpy(block.data(), &header, sizeof header);
      begin = static_cast<std::uintmax_t>(header.vox_offset);
      end = begin + (size - begin) / 3 * 2;
    }
    for (std::size_t i = 0; i + sizeof(float) <= block.size(); i += sizeof(float)) {
      if (at + i >= begin && at + i < end) {
        float value = 0.0F;
        std::memcpy(&value, block.data() + i, sizeof value);
        value = 0.0F - value;
        std::memcpy(block.data() + i, &value, sizeof value);
      }
    }
    const auto count = static_cast<unsigned>(block.size());
    if (!from || to == nullptr || gzwrite(to.get(), block.data(), count) != static_cast<int>(count)) {
      throw unwritable(file, !from ? "it cannot be read again" : "the disk is full");
    }
  }
  if (gzclose(to.release()) != Z_OK) {
    throw unwritable(file, "the disk is full");
  }
}

} // namespace hdmbench::images
