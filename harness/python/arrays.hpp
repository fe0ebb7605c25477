#pragma once

#include "harness/scene/images/pixels.hpp"
#include "harness/scene/points.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <toml++/toml.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// What Python callers give, as the scene takes it, and back. Index 0 of an array is x, 1 is y, 2 is z, as in
/// nibabel, in any memory order. Everything here needs the GIL and throws InputError.
namespace hdmbench::python {

namespace py = pybind11;

/// Whose axes positions and vectors are along.
enum class Space {
  lps, ///< the project's own; where nothing is said, the axes of the array
  ras, ///< nibabel's, of whoever gives an affine
};

/// A NumPy array of two or three axes, and where its pixels lie.
struct GivenImage {
  std::string name; ///< for messages: "labels"
  py::array array;
  images::Geometry geometry; ///< in LPS; one component
  Space space = Space::lps;
};

/// `image`: an array, what NumPy makes one of, or an image of nibabel's, which has an affine. `spacing`:
/// None, millimetres, or as many as the array has axes. `affine`: None, or 4 x 4 in RAS, in place of the
/// image's.
[[nodiscard]] GivenImage given_image(std::string name, const py::object& image, const py::object& spacing,
                                     const py::object& affine);

/// Returns the values of an array of the image's shape.
[[nodiscard]] images::Pixels pixels_of(const GivenImage& image);

/// Returns vectors at the image's pixels, an array of its shape with an axis of components more: of an image
/// two or three, of a volume three. Those that are `physical` are turned from the image's space to LPS.
[[nodiscard]] images::Pixels vectors_of(const GivenImage& image, std::string_view name,
                                        const py::object& vectors, bool physical);

/// Returns symmetric matrices at the image's pixels, an array of its shape with two axes of components more,
/// as images::read_matrix() takes them, turned from the image's space to LPS. Throws InputError where one is
/// not symmetric to a float's rounding.
[[nodiscard]] images::Pixels matrices_of(const GivenImage& image, std::string_view name,
                                         const py::object& matrices);

/// Returns vectors of the shape of `like`, in LPS; `space` is theirs.
[[nodiscard]] images::Pixels vectors_like(const py::array& like, std::string_view name,
                                          const py::object& vectors, Space space);

/// Returns scalars at the image's pixels, or vectors as above, as vectors.
[[nodiscard]] images::Pixels confidence_of(const GivenImage& image, const py::object& confidence);

/// Returns points that have moved, in LPS: an array of lines as a file of pairs has them, x y z dx dy dz
/// [deviation], or where they were before and are after, of images with or without z.
[[nodiscard]] std::vector<PointPair> points_of(const py::object& points, Space space);
[[nodiscard]] std::vector<PointPair> points_of(const py::object& before, const py::object& after,
                                               Space space);

/// Returns the array that is made of these numbers, which it owns: a view of them by x, y, z (where there are
/// `axes` of 3) and component.
[[nodiscard]] py::array array_of(images::Pixels pixels, std::size_t axes, Space space);

/// Returns the 4 x 4 matrix from indices to millimetres in that space.
[[nodiscard]] py::array affine_of(const images::Geometry& geometry, Space space);

/// Returns a dictionary of numbers, words, lists and dictionaries as a table.
[[nodiscard]] toml::table table_of(const py::dict& values);
/// Returns a list of dictionaries, the argument `name`, as tables. Throws InputError for anything else in it.
[[nodiscard]] toml::array tables_of(std::string_view name, const py::iterable& values);

/// Whether it is a path: str, or os.PathLike.
[[nodiscard]] bool is_path(const py::object& value);
[[nodiscard]] std::string path_of(const py::object& value);

} // namespace hdmbench::python
