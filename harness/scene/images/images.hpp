#pragma once

#include "harness/scene/file_grid.hpp"
#include "harness/scene/placement.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/field.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// Image files through ITK: NRRD, MetaImage, NIfTI, PNG, JPEG and TIFF. Where the project is built without it
/// (-DHDMBENCH_IMAGES=OFF) every function that takes a file throws InputError that says so; have_images()
/// tells beforehand. All throw InputError with the file's path and the cause, in ITK's words where it has
/// any: a file that is missing, cut short, damaged or of an unknown format, more than three axes, the wrong
/// number of components.
namespace hdmbench {

namespace images {
struct Pixels; // harness/scene/images/pixels.hpp
}

[[nodiscard]] bool have_images();

/// To be called first in main(). From then on ITK reads every image file in a process of its own: this
/// program, started again. A file on which it crashes, does not end or takes all memory, or of which it
/// reports that pixels are missing, is then an InputError. In that process this reads the file and ends the
/// process. Without the call, and with HDMBENCH_ASK_IN_PROCESS=1 in the environment (for a debugger), files
/// are read in the process itself: a damaged one may end it, and missing pixels of NIfTI and MetaImage files
/// have any value.
void read_images_apart(int argc, const char* const* argv);

/// An image or a volume, the side of its pixels or voxels in millimetres (1 where the file says nothing) and
/// where it lies. Where a file's pixels are not square, or its voxels no cubes (has_equal_sides), it is
/// resampled to squares or cubes of their shortest side, unless ReadOptions take boxes.
template <typename Pixels>
struct Image {
  Pixels pixels;
  double spacing = 1.0; ///< of boxes the shortest side
  Placement placement{};
  bool padded = false;              ///< `size` has another aspect: pixels beside the file's image are 0
  FileGrid grid{};                  ///< the file's own pixels, those of its slice
  std::optional<FileGrid> oblong{}; ///< the same where their sides differ, by however little
};

/// `slice` picks the slice of a 3-D image along its third axis and is required there unless it has one slice,
/// or `takes_volumes`: then all of them are read. `size` resamples about the image centre to this extent,
/// keeping the aspect ratio, so that the whole image fits: linear for scalars and vectors, nearest neighbour
/// for labels, 0 beside the image. Rows and columns are those of the file: no orientation is applied, but
/// `placement` says how they lie. `spacing` replaces what the file says of its pixels, which are then square.
struct ReadOptions {
  std::optional<int> slice{};
  std::optional<Extent> size{};
  std::optional<double> spacing{};
  bool takes_volumes = false;
  bool as_stored = false; ///< on the file's own pixels, square or not: no `size` beside it
  /// Whether pixels that are no squares, or voxels that are no cubes, may stay what they are, where `size`
  /// and `spacing` do not say other ones: then Placement::aspect has their sides.
  bool takes_boxes = false;
  /// Vectors are physical then, millimetres along the axes of the space as write_displacement writes
  /// them, and become pixels of this side along the image's rows and columns. None: they are as they are.
  std::optional<double> physical_side{};
  const images::Pixels* in_memory = nullptr; ///< the image itself; `file` is then its name in messages alone
};
/// InputError where a pixel is not an integer.
[[nodiscard]] Image<LabelField> read_labels(const std::filesystem::path& file,
                                            const ReadOptions& options = {});
/// Not a number and infinity pass.
[[nodiscard]] Image<ScalarField> read_scalar(const std::filesystem::path& file,
                                             const ReadOptions& options = {});
/// Two components, or three of which the third is ignored, and of a volume three; the values as they are,
/// nothing is rescaled.
[[nodiscard]] Image<VectorField> read_vector(const std::filesystem::path& file,
                                             const ReadOptions& options = {});
/// The same as vectors of length 1 in the space, or 0 where they are, along the image's axes: of an image
/// their share in its plane. One that is not finite has a component that is none.
[[nodiscard]] Image<VectorField> read_directions(const std::filesystem::path& file,
                                                 const ReadOptions& options = {});
/// The same; or of an image of one number a pixel, a distance in any unit, the directions of its gradient.
[[nodiscard]] Image<VectorField> read_normals(const std::filesystem::path& file,
                                              const ReadOptions& options = {});
/// Symmetric matrices, six components, or three of an image: row by row, each from the diagonal on, as NRRD
/// has them (xx, xy, xz, yy, yz, zz), and so in the result, three components of an image. With a
/// ReadOptions::physical_side they are over square millimetres, along the axes of the space, and become over
/// square pixels of this side along the image's rows, columns and slices.
[[nodiscard]] Image<std::vector<ScalarField>> read_matrix(const std::filesystem::path& file,
                                                          const ReadOptions& options = {});
/// A physical displacement in millimetres (ReadOptions::physical_side) in the image's own pixels.
[[nodiscard]] Image<VectorField> read_displacement(const std::filesystem::path& file,
                                                   bool takes_volumes = false);

/// Returns "1 mm x 1 mm x 2.5 mm".
[[nodiscard]] inline std::string sides_text(const FileGrid& grid) {
  return fmt::format("{:g} mm", fmt::join(std::span(grid.sides).first(grid.extent.axes()), " mm x "));
}

/// Which way a slice of a volume lies, and what scene files call it.
enum class Orientation {
  axial,   ///< counted from below; rows begin in front, columns at the patient's right
  coronal, ///< counted from the front; rows begin above, columns at the patient's right
  sagittal ///< counted from the patient's right; rows begin above, columns in front
};
inline constexpr std::array<std::string_view, 3> orientation_names{"axial", "coronal", "sagittal"};

/// A slice of a brain without skull. picture is 0 exactly where tissue is 0, but for dark spots inside.
struct BrainSlice {
  ScalarField picture; ///< gray values 0 ... 255
  LabelField tissue; ///< 0 outside the brain, then 1 ... classes by rising brightness; one part without holes
  double spacing = 1.0;
  Placement placement;
  std::optional<FileGrid> oblong{}; ///< as of Image
};
/// A 3-D image whose background is 0, turned as its header says. No `slice`: the one that shows most of the
/// brain. The grid has `size` pixels with the brain centred and at
/// least `margin` (a fraction of the shorter side, 0 <= margin < 0.5) free around it. `classes`, 1 ... 4,
/// tissue classes by ITK's multi-Otsu thresholds of the brain's pixels as the file has them, so that they do
/// not depend on `size`.
[[nodiscard]] BrainSlice read_brain(const std::filesystem::path& file, std::optional<int> slice, int classes,
                                    double margin, Extent size, Orientation orientation = Orientation::axial);

/// A whole head on the grid of its file, with its brain on the same grid in another one: what is outside both
/// is 0. Tissue is 0, then of the brain 1 ... classes as in a slice, then, what else of the head there is,
/// skull and skin, classes + 1. Gaps of the brain that are narrower than `sulci` millimetres are of class 1,
/// the liquid that fills them, so that the skull's inner side is smooth. `size` as in ReadOptions, nearest
/// neighbour.
[[nodiscard]] BrainSlice read_head(const std::filesystem::path& brain, const std::filesystem::path& head,
                                   int classes, double sulci, std::optional<Extent> size);

/// Which way a displacement leads.
enum class Mapping {
  forward, ///< tissue at x moves to x + d(x)
  backward ///< what is at y came from y + d(y): as ITK, ANTs and 3D Slicer resample a picture
};

/// Writes the displacement, in pixels, as a W x H x D image of physical 3-vectors in millimetres, along the
/// axes of the space and not of the image, that ITK, 3D Slicer and ParaView open; .nrrd, .mha or .nii.gz by
/// the extension, or as a transform of ITK's, .h5. With `grid` at the pixels of that file, linear between
/// those of the displacement. The header of the first two carries the direction of the mapping and the unit
/// as key/values; that of NIfTI has floats for the place. Written beside the target and renamed, so that no
/// half-written file is left.
void write_displacement(const std::filesystem::path& file, const VectorField& displacement, double spacing,
                        const Placement& placement = {}, const std::optional<FileGrid>& grid = {},
                        Mapping mapping = Mapping::forward);
/// Returns what write_displacement() writes: where the pixels lie, and their vectors, millimetres. Throws
/// InputError, which names the `file`, for pixels without a size.
[[nodiscard]] images::Pixels physical_displacement(const std::filesystem::path& file,
                                                   const VectorField& displacement, double spacing,
                                                   const Placement& placement,
                                                   const std::optional<FileGrid>& grid);
/// Throws InputError where write_displacement() could not write a field of this extent by that name.
void require_displacement_name(const std::filesystem::path& file, Extent extent);

/// The values as they are, float or 16-bit integer, as a W x H x D image of pixels with sides of `spacing`
/// millimetres, in the same formats. read_scalar, read_vector and read_labels give them back to
/// the bit. Written beside the target and renamed.
void write_scalar(const std::filesystem::path& file, const ScalarField& field, double spacing,
                  const Placement& placement = {});
/// Two components per pixel, along rows and columns; of a volume three.
void write_vector(const std::filesystem::path& file, const VectorField& field, double spacing,
                  const Placement& placement = {});
/// InputError where a label is beyond 16 bits.
void write_labels(const std::filesystem::path& file, const LabelField& labels, double spacing,
                  const Placement& placement = {});

/// 8-bit grey PNG; gray values are rounded and clamped to 0 ... 255, not a number is 0. Written beside the
/// target and renamed.
void write_png(const std::filesystem::path& file, const ScalarField& picture);

/// 8-bit colour PNG of how far each site moved, black = 0 ... light yellow = `largest` and beyond, brighter
/// all the way. Written beside the target and renamed.
void write_magnitude_png(const std::filesystem::path& file, const ScalarField& magnitude, double largest);

/// 8-bit colour PNG of one signed value per site in raster order: blue = -`largest` and beyond, white = 0,
/// red = `largest`. With a `picture` (gray values 0 ... 255) they are painted over it, in place of white.
/// Written beside the target and renamed.
void write_signed_png(const std::filesystem::path& file, Extent extent, std::span<const float> values,
                      double largest, const ScalarField& picture = {});

/// The sites of a volume whose coordinate along `axis` is `at`. An image has one plane, {2, 0}.
struct Plane {
  std::size_t axis = 2;
  int at = 0;
};
/// The other two axes, in their order, of a volume of this extent.
[[nodiscard]] Extent extent_of(const Plane& plane, Extent extent);
[[nodiscard]] ScalarField slice_of(const ScalarField& field, const Plane& plane);
/// The two components in the plane.
[[nodiscard]] VectorField slice_of(const VectorField& field, const Plane& plane);
/// Across z, y and x, through the site that moves farthest, or the middle where none moves or that site is on
/// the border, of which a slice shows little; of an image its only one. `magnitude`: magnitude_of().
[[nodiscard]] std::vector<Plane> planes_to_show(const ScalarField& magnitude);
/// Pictures in a row, 0 below those that are not as high.
[[nodiscard]] ScalarField side_by_side(std::span<const ScalarField> pictures);

/// How far each site moves, 0 where `tissue` is 0; empty: nowhere. Throws InputError where the displacement
/// is not finite.
[[nodiscard]] ScalarField magnitude_of(const VectorField& displacement, const ScalarField& tissue = {});

/// The picture after the deformation: the gray value at site s moves to s + d_s, linear between sites; the
/// mean where the field folds over itself, 0 where nothing arrives. Of a volume only one `plane` where that
/// is given, into which values also come from the sites beside it. The time grows with the area that pixels
/// are stretched to. Throws InputError where the displacement is not finite or of another extent. Needs no
/// ITK.
[[nodiscard]] ScalarField warp(const ScalarField& picture, const VectorField& displacement,
                               std::optional<Plane> plane = {});

/// A volume before and after its deformation, at all sites or evenly at so many that there are at most
/// 300,000: the slices across z, those of before and then those of after, row by row in one picture that is
/// about as high as wide.
struct ContactSheet {
  ScalarField picture;
  Extent volume; ///< of the sites shown
};
[[nodiscard]] ContactSheet contact_sheet(const ScalarField& picture, const VectorField& displacement);

/// A displacement that leads back.
struct Inverse {
  VectorField displacement{}; ///< pixels: what is at y came from y + d(y)
  std::size_t unmet = 0;      ///< sites that no tissue meets to `inverse_is_met`; where the image folds over
  double farthest = 0.0;      ///< from a site to where its origin in tissue lands, pixels
  std::array<int, 3> at{};    ///< that site
};
inline constexpr double inverse_is_met = 0.01; ///< pixels
/// Inverts x + d(x), linear between sites and moved as the border is beyond them. Where several points land
/// at a site it takes one of them. What comes from sites where `tissue` is 0 is void and need not meet;
/// empty: there is none. Throws InputError where the displacement is not finite. Needs no ITK.
[[nodiscard]] Inverse invert(const VectorField& displacement, const ScalarField& tissue = {});
/// The same of pixels of these sides (Level::sides), whose shortest one is the unit of the displacement.
[[nodiscard]] Inverse invert(const VectorField& displacement, const std::array<double, 3>& pixel,
                             const ScalarField& tissue = {});

/// Moves the image, on its own pixels: what is at p is what it had at p + d(p), in the patient's space, and 0
/// where it had nothing; the displacement d is as physical_displacement() returns it, and 0 beside it.
/// Linear; the nearest pixel `of_labels`. Throws InputError, which names the `file`, where the image has
/// several components.
void move_pixels(const std::filesystem::path& file, const images::Pixels& displacement, bool of_labels,
                 images::Pixels& image);
/// Writes an image that move_pixels() moved, labels of 16 bits as such. The formats of write_scalar().
void write_moved(const std::filesystem::path& file, images::Pixels image, bool of_labels);
/// Does both with files. `transform`: as write_displacement() writes it.
void write_moved(const std::filesystem::path& file, const std::filesystem::path& image,
                 const std::filesystem::path& transform, bool of_labels);

/// Pixels between the lines of a grid, so that about thirty of them go across; at least 2.
[[nodiscard]] int grid_spacing(Extent extent);

/// A picture of dark grid lines on white, one every `every` >= 2 pixels, to be warped. Needs no ITK.
[[nodiscard]] ScalarField grid_picture(Extent extent, int every);

} // namespace hdmbench
