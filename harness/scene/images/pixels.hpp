#pragma once

#include "harness/scene/images/geometry.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/field.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace itk {
class ExceptionObject;
}

/// What needs ITK, and what it gives the rest of this folder.
namespace hdmbench::images {

[[nodiscard]] inline InputError unreadable(const std::filesystem::path& file, std::string_view why) {
  return InputError(fmt::format("cannot read the image {}: {}", file.string(), why));
}
[[nodiscard]] inline InputError unwritable(const std::filesystem::path& file, std::string_view why) {
  return InputError(fmt::format("cannot write the image {}: {}", file.string(), why));
}

/// What begins a line on standard error that says how an odd file was read, and is no complaint about it.
inline constexpr std::string_view remark_begin = "note: ";

/// Says on standard error how a file was read that could be meant otherwise.
inline void remark(const std::filesystem::path& file, std::string_view how) {
  fmt::print(stderr, "{}{}: {}\n", remark_begin, file.string(), how);
}

/// The whole file, its values unchanged but for the rounding to float. Read in a process of its own after
/// read_images_apart(), else in this one. Throws InputError and MissingFile.
[[nodiscard]] Pixels read_pixels(const std::filesystem::path& file);

/// ITK makes its list of factories with its first object, without a lock: this makes it before there are
/// threads that read and write.
void make_factories();

/// Reads in this process: a damaged file may crash ITK's readers, or make them run for ever. What they would
/// not notice is noticed here, but for pixels that are missing at the end of a MetaImage file: these
/// they only report on standard error, which is for the process that started this one to judge. Throws
/// InputError.
[[nodiscard]] Pixels read_pixels_here(const std::filesystem::path& file);

/// Throws InputError where there are none, or more than can be read.
void require_reasonable_number(const std::filesystem::path& file, double values);
void require_reasonable_number(const std::filesystem::path& file, const Geometry& geometry);

/// The first three rows of a matrix from voxels to millimetres, in NIfTI's RAS.
using Matrix = std::array<std::array<double, 4>, 3>;
/// Its columns and its origin, in LPS.
struct Frame {
  std::array<Placement::Vector, 3> columns{};
  Placement::Vector origin{};
};
/// NIfTI's axes lead to the right and to the front, ITK's to the left and to the back. `unit`: millimetres.
[[nodiscard]] Frame lps_of(const Matrix& matrix, double unit = 1.0);
[[nodiscard]] double length_of(const Placement::Vector& vector);
/// Lets the pixels of an image of so many `axes` lie where the frame says. `sides`: of a pixel, millimetres,
/// as something else says them, which is taken where the frame differs by rounding alone. Throws InputError,
/// which names the `source` of the frame, for a direction of no length.
void place(const std::filesystem::path& file, const Frame& frame, const std::array<double, 3>& sides,
           std::size_t axes, std::string_view source, Geometry& geometry);

/// Whether a file is NIfTI's, by its name and its header. Throws InputError where it is of its forerunner.
[[nodiscard]] bool is_nifti(const std::filesystem::path& file);
/// Millimetres, whatever the file's unit. Where sform and qform differ, the sform, with a remark.
[[nodiscard]] Pixels read_nifti(const std::filesystem::path& file);

/// Compresses a NIfTI file that ITK has written, whose vectors become displacements: the header says so, and
/// they are along NIfTI's axes, as other programs expect of such.
void write_as_displacement(const std::filesystem::path& plain, const std::filesystem::path& file);

/// The header of an NRRD file: fields by name in small letters, as "space directions"; none of another file.
using NrrdFields = std::map<std::string, std::string, std::less<>>;
[[nodiscard]] NrrdFields nrrd_fields(const std::filesystem::path& file);
/// Puts right what ITK makes of the space and the units of an NRRD file. Throws InputError where these do not
/// say how the patient lies.
void correct_nrrd_place(const std::filesystem::path& file, const NrrdFields& fields, Geometry& geometry);

/// Pixels that ITK's reader of TIFF does not read, 32-bit integers; nothing where it reads the file. Throws
/// InputError where nobody does, and where readers differ about black and white.
[[nodiscard]] std::optional<Pixels> read_tiff_integers(const std::filesystem::path& file);

/// A picture, labels or numbers: the components of a pixel, then the next pixel of the row.
using Values = std::variant<std::vector<unsigned char>, std::vector<std::int16_t>, std::vector<float>>;
using Keys = std::vector<std::pair<std::string, std::string>>;

/// Writes a picture as PNG, everything else as .nrrd, .mha or .nii.gz by the file's extension. With `keys`,
/// which the first two have in their header, it is a displacement, and is not compressed. Written beside the
/// target and renamed. Throws InputError.
void write_pixels(const std::filesystem::path& file, const Geometry& geometry, const Values& values,
                  const Keys& keys = {});

/// Returns the value without the sign of a 0. Drivers differ in it, and files are compared byte by byte.
[[nodiscard]] inline float with_zero_positive(double value) {
  const auto stored = static_cast<float>(value);
  // By its bits: compilers are told that the sign does not matter.
  return std::bit_cast<std::uint32_t>(stored) == 0x80000000U ? 0.0F : stored;
}

/// Whether it is a file of ITK's transforms, by its name.
[[nodiscard]] inline bool is_transform(const std::filesystem::path& file) {
  return file.extension() == ".h5";
}
/// A displacement field in a file of ITK's transforms: its vectors, millimetres along the axes of the space.
/// Read in this process. Throws InputError, and what ITK throws.
[[nodiscard]] Pixels read_transform(const std::filesystem::path& file);
/// Written beside the target and renamed. Throws InputError.
void write_transform(const std::filesystem::path& file, const Geometry& geometry,
                     const std::vector<float>& values);
/// Puts in place of the image's pixels what it has where the displacement leads from them.
void resample(const Pixels& displacement, bool to_nearest, Pixels& image);

/// Resamples every component to `size` by nearest neighbours, as read_labels does. Throws InputError, about
/// `file`, where it has another number of axes.
void fit_nearest(const std::filesystem::path& file, Image<std::vector<ScalarField>>& image,
                 std::optional<Extent> size);

/// ITK's message on one line, without the class, the address and the empty lines around it.
[[nodiscard]] std::string own_words(const itk::ExceptionObject& error);

/// Linear interpolation along all axes at a finite position in pixels, pixel centres at integers; beyond the
/// outer centres the nearest pixel of the border.
[[nodiscard]] inline float linear_at(const std::vector<float>& values, Extent extent, double x, double y,
                                     double z = 0.0) {
  const double inside_x = std::clamp(x, 0.0, extent.width - 1.0);
  const double inside_y = std::clamp(y, 0.0, extent.height - 1.0);
  const int left = static_cast<int>(inside_x);
  const int top = static_cast<int>(inside_y);
  const int right = std::min(left + 1, extent.width - 1);
  const int bottom = std::min(top + 1, extent.height - 1);
  const auto in_slice = [&](int slice) {
    const auto value = [&](int column, int row) { return double{values[extent.index(column, row, slice)]}; };
    const double upper = std::lerp(value(left, top), value(right, top), inside_x - left);
    const double lower = std::lerp(value(left, bottom), value(right, bottom), inside_x - left);
    return std::lerp(upper, lower, inside_y - top);
  };
  if (extent.depth == 1) {
    return static_cast<float>(in_slice(0));
  }
  const double inside_z = std::clamp(z, 0.0, extent.depth - 1.0);
  const int front = static_cast<int>(inside_z);
  const int back = std::min(front + 1, extent.depth - 1);
  return static_cast<float>(std::lerp(in_slice(front), in_slice(back), inside_z - front));
}

} // namespace hdmbench::images
