#include "harness/python/arrays.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <utility>

namespace hdmbench::python {

namespace {

/// What NumPy makes of a value. Throws InputError where these are no real numbers.
py::array numbers_of(std::string_view name, const py::object& value) {
  const py::array array = py::array::ensure(value);
  if (!array) {
    PyErr_Clear();
    throw InputError(fmt::format("{}: NumPy can make no array of it", name));
  }
  if (std::string_view("biuf").find(array.dtype().kind()) == std::string_view::npos) {
    throw InputError(fmt::format("{}: its values are of the type {}, integers and reals can be read", name,
                                 py::str(array.dtype()).cast<std::string>()));
  }
  return array;
}

std::vector<std::size_t> shape_of(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

/// The numbers in the order in which the first index runs fastest.
std::vector<float> floats_of(const py::array& array) {
  const auto floats = py::array_t<float, py::array::f_style | py::array::forcecast>::ensure(array);
  if (!floats) {
    throw py::error_already_set();
  }
  return {floats.data(), floats.data() + floats.size()};
}

/// Rows of numbers. Throws InputError where it is no matrix of at least `least` columns.
std::vector<std::vector<double>> rows_of(std::string_view name, const py::object& value, py::ssize_t least) {
  const auto matrix =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(numbers_of(name, value));
  if (matrix.ndim() != 2 || matrix.shape(1) < least) {
    throw InputError(fmt::format("{}: has the shape ({}), a point is a row of it", name,
                                 fmt::join(shape_of(matrix), ", ")));
  }
  std::vector<std::vector<double>> rows;
  for (py::ssize_t row = 0; row < matrix.shape(0); ++row) {
    rows.emplace_back(matrix.data(row, 0), matrix.data(row, 0) + matrix.shape(1));
  }
  return rows;
}

Placement::Vector in_lps(const Placement::Vector& vector, Space space) {
  return space == Space::ras ? Placement::turned(vector) : vector;
}

/// Sides of pixels as they are given: one for all axes, or one for each. NaN where nothing is.
std::array<double, 3> sides_of(const py::object& spacing, std::size_t axes) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 3> sides{unknown, unknown, unknown};
  if (spacing.is_none()) {
    return sides;
  }
  const auto given =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(numbers_of("spacing", spacing));
  if (given.ndim() > 1 || (given.ndim() == 1 && static_cast<std::size_t>(given.size()) != axes)) {
    throw InputError(fmt::format("spacing: is one number, or {} of them, one for each axis", axes));
  }
  for (std::size_t axis = 0; axis < sides.size(); ++axis) {
    const std::size_t last = static_cast<std::size_t>(given.size()) - 1;
    sides[axis] = given.data()[std::min(axis, last)];
  }
  sides[2] = axes == 2 ? sides[0] : sides[2];
  return sides;
}

images::Matrix matrix_of(const py::object& affine) {
  const auto given =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(numbers_of("affine", affine));
  if (given.ndim() != 2 || given.shape(0) != 4 || given.shape(1) != 4) {
    throw InputError(fmt::format("affine: has the shape ({}), it is 4 x 4, from voxels to millimetres in RAS",
                                 fmt::join(shape_of(given), ", ")));
  }
  if (given.at(3, 0) != 0.0 || given.at(3, 1) != 0.0 || given.at(3, 2) != 0.0 || given.at(3, 3) != 1.0) {
    throw InputError("affine: its last row is 0 0 0 1");
  }
  images::Matrix matrix{};
  for (std::size_t row = 0; row < matrix.size(); ++row) {
    std::copy_n(given.data(static_cast<py::ssize_t>(row), 0), 4, matrix[row].begin());
  }
  return matrix;
}

/// The sides that the header of an image of nibabel's has beside its affine; None where it has none. Throws
/// InputError where they are no millimetres.
py::object zooms_of(const std::string& name, const py::object& image, std::size_t axes) {
  const py::object header = py::getattr(image, "header", py::none());
  if (py::hasattr(header, "get_xyzt_units")) {
    const auto unit = header.attr("get_xyzt_units")().cast<py::tuple>()[0].cast<std::string>();
    if (unit != "mm" && unit != "unknown") {
      throw InputError(
          fmt::format("{}: its header is in units of a {}; give its affine in millimetres", name, unit));
    }
  }
  if (!py::hasattr(header, "get_zooms")) {
    return py::none();
  }
  return header.attr("get_zooms")()[py::slice(0, static_cast<py::ssize_t>(axes), 1)];
}

/// Lets the image lie where its sides and its affine say.
void place(GivenImage& image, const std::array<double, 3>& sides, bool are_of_header,
           const py::object& affine) {
  images::Geometry& geometry = image.geometry;
  geometry.axes = Placement{}.axes;
  const bool has_sides = !std::isnan(sides[0]);
  geometry.spacing = has_sides ? sides : geometry.spacing;
  geometry.stated = has_sides ? Stated::sides : Stated::nothing;
  if (affine.is_none()) {
    return;
  }
  const auto axes = static_cast<std::size_t>(image.array.ndim());
  images::place(image.name, images::lps_of(matrix_of(affine)), sides, axes, "affine", geometry);
  geometry.stated = Stated::place;
  image.space = Space::ras;
  constexpr double same = 1e-3;
  for (std::size_t axis = 0; has_sides && !are_of_header && axis < axes; ++axis) {
    if (std::abs(geometry.spacing[axis] - sides[axis]) > same * sides[axis]) {
      throw InputError(
          fmt::format("spacing: axis {} has sides of {:g} mm, and by affine of {:g} mm; give one "
                      "of the two",
                      axis, sides[axis], geometry.spacing[axis]));
    }
  }
}

/// Turns every vector from RAS to LPS, or back. None gets a -0.
void turn(std::vector<float>& values, std::size_t components) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = i % components < 2 ? images::with_zero_positive(-values[i]) : values[i];
  }
}

toml::array list_of(const py::handle& values);

// A list has lists in it.
// NOLINTNEXTLINE(misc-no-recursion)
template <typename Store>
void store(const py::handle& value, const Store& into) {
  if (py::isinstance<py::bool_>(value)) {
    into(value.cast<bool>());
  } else if (py::isinstance<py::int_>(value)) {
    into(value.cast<std::int64_t>());
  } else if (py::isinstance<py::float_>(value)) {
    into(value.cast<double>());
  } else if (py::isinstance<py::dict>(value)) {
    into(table_of(value.cast<py::dict>()));
  } else if (is_path(value.cast<py::object>())) {
    into(path_of(value.cast<py::object>()));
  } else if (py::hasattr(value, "tolist")) { // NumPy's numbers and arrays
    store(value.attr("tolist")(), into);
  } else if (py::isinstance<py::sequence>(value)) {
    into(list_of(value));
  } else {
    throw InputError(fmt::format("{}: is no number, word, list or dictionary of these",
                                 py::repr(value).cast<std::string>()));
  }
}

// NOLINTNEXTLINE(misc-no-recursion)
toml::array list_of(const py::handle& values) {
  toml::array list;
  for (const py::handle value : values) {
    store(value, [&](auto stored) { list.push_back(std::move(stored)); });
  }
  return list;
}

} // namespace

GivenImage given_image(std::string name, const py::object& image, const py::object& spacing,
                       const py::object& affine) {
  const bool is_nibabel = py::hasattr(image, "dataobj") && py::hasattr(image, "affine");
  GivenImage given{.name = std::move(name), .array = {}, .geometry = {}};
  given.array = numbers_of(given.name, is_nibabel ? py::object(image.attr("dataobj")) : image);
  const std::vector<std::size_t> shape = shape_of(given.array);
  if (shape.size() != 2 && shape.size() != 3) {
    throw InputError(fmt::format("{}: has the shape ({}), an image has two axes, a volume three", given.name,
                                 fmt::join(shape, ", ")));
  }
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    given.geometry.size[axis] = static_cast<int>(std::min(shape[axis], std::size_t{1} << 30U));
  }
  const bool takes_header = is_nibabel && affine.is_none() && spacing.is_none();
  const py::object sides = takes_header ? zooms_of(given.name, image, shape.size()) : spacing;
  place(given, sides_of(sides, shape.size()), takes_header,
        is_nibabel && affine.is_none() ? py::object(image.attr("affine")) : affine);
  return given;
}

images::Pixels pixels_of(const GivenImage& image) {
  return {image.geometry, floats_of(image.array)};
}

images::Pixels vectors_of(const GivenImage& image, std::string_view name, const py::object& vectors,
                          bool physical) {
  const py::array array = numbers_of(name, vectors);
  std::vector<std::size_t> shape = shape_of(image.array);
  const std::vector<std::size_t> found = shape_of(array);
  const std::size_t axes = shape.size();
  shape.push_back(found.empty() ? 0 : found.back());
  if (found != shape || (shape.back() != axes && shape.back() != 3)) {
    throw InputError(fmt::format("{}: has the shape ({}), the pixels of {} have ({}), each with {}", name,
                                 fmt::join(found, ", "), image.name, fmt::join(shape_of(image.array), ", "),
                                 axes == 2 ? "2 or 3 components" : "3 components"));
  }
  images::Pixels pixels{image.geometry,
                        floats_of(py::module_::import("numpy").attr("moveaxis")(array, -1, 0))};
  pixels.geometry.components = shape.back();
  if (physical && image.space == Space::ras) {
    turn(pixels.values, shape.back());
  }
  return pixels;
}

images::Pixels matrices_of(const GivenImage& image, std::string_view name, const py::object& matrices) {
  const py::array array = numbers_of(name, matrices);
  std::vector<std::size_t> shape = shape_of(image.array);
  const std::size_t axes = shape.size();
  shape.insert(shape.end(), {axes, axes});
  if (shape_of(array) != shape) {
    throw InputError(fmt::format("{}: has the shape ({}), the pixels of {} have ({}), each with a matrix of "
                                 "{} x {}",
                                 name, fmt::join(shape_of(array), ", "), image.name,
                                 fmt::join(shape_of(image.array), ", "), axes, axes));
  }
  const auto numpy = py::module_::import("numpy");
  if (!numpy
           .attr("allclose")(array, array.attr("swapaxes")(-1, -2), py::arg("rtol") = 1e-6,
                             py::arg("atol") = 0.0, py::arg("equal_nan") = true)
           .cast<bool>()) {
    throw InputError(fmt::format("{}: has matrices that are not symmetric", name));
  }
  images::Pixels pixels{image.geometry, {}};
  pixels.geometry.components = axes * (axes + 1) / 2;
  py::list entries;
  for (std::size_t row = 0; row < axes; ++row) {
    for (std::size_t column = row; column < axes; ++column) {
      const py::array entry = array[py::make_tuple(py::ellipsis(), row, column)];
      const bool changes_sign = image.space == Space::ras && column == 2 && row < 2;
      entries.append(changes_sign ? entry.attr("__neg__")() : py::object(entry));
    }
  }
  pixels.values = floats_of(numpy.attr("stack")(entries));
  return pixels;
}

images::Pixels vectors_like(const py::array& like, std::string_view name, const py::object& vectors,
                            Space space) {
  const py::array array = numbers_of(name, vectors);
  if (shape_of(array) != shape_of(like)) {
    throw InputError(fmt::format("{}: has the shape ({}), the displacement ({})", name,
                                 fmt::join(shape_of(array), ", "), fmt::join(shape_of(like), ", ")));
  }
  images::Pixels pixels{{}, floats_of(py::module_::import("numpy").attr("moveaxis")(array, -1, 0))};
  pixels.geometry.components = 3;
  if (space == Space::ras) {
    turn(pixels.values, 3);
  }
  return pixels;
}

images::Pixels confidence_of(const GivenImage& image, const py::object& confidence) {
  const py::array array = numbers_of("confidence", confidence);
  if (array.ndim() != image.array.ndim()) {
    return vectors_of(image, "confidence", array, false);
  }
  std::vector<std::size_t> shape = shape_of(array);
  const std::size_t axes = shape.size();
  shape.push_back(axes);
  const py::object alike = array.attr("reshape")(py::make_tuple(-1, 1), py::arg("order") = "F");
  const py::object repeated = alike.attr("repeat")(axes, py::arg("axis") = 1);
  return vectors_of(image, "confidence", repeated.attr("reshape")(py::cast(shape), py::arg("order") = "F"),
                    false);
}

std::vector<PointPair> points_of(const py::object& points, Space space) {
  std::vector<PointPair> pairs;
  for (const std::vector<double>& row : rows_of("points", points, 0)) {
    try {
      pairs.push_back(point_pair(row, std::to_string(pairs.size() + 1)));
    } catch (const InputError& error) {
      throw InputError(fmt::format("points: row {} {}", pairs.size(), error.what()));
    }
    pairs.back().before = in_lps(pairs.back().before, space);
    pairs.back().after = in_lps(pairs.back().after, space);
  }
  return pairs;
}

std::vector<PointPair> points_of(const py::object& before, const py::object& after, Space space) {
  const auto from = rows_of("points before", before, 2);
  const auto to = rows_of("points after", after, 2);
  if (from.size() != to.size()) {
    throw InputError(
        fmt::format("points: before has {}, after has {}: each needs its other one", from.size(), to.size()));
  }
  const auto vector_of = [&](const std::vector<double>& row) {
    if (row.size() > 3 || !std::ranges::all_of(row, [](double number) { return std::isfinite(number); })) {
      throw InputError("points: before and after are rows of x y z, finite numbers");
    }
    Placement::Vector vector{};
    std::ranges::copy(row, vector.begin());
    return in_lps(vector, space);
  };
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < from.size(); ++i) {
    pairs.push_back({std::to_string(i + 1), vector_of(from[i]), vector_of(to[i])});
  }
  return pairs;
}

py::array array_of(images::Pixels pixels, std::size_t axes, Space space) {
  const std::size_t components = pixels.geometry.components;
  if (space == Space::ras && components == 3) {
    turn(pixels.values, components);
  }
  std::vector<py::ssize_t> shape;
  std::vector<py::ssize_t> strides;
  auto stride = static_cast<py::ssize_t>(components * sizeof(float));
  for (std::size_t axis = 0; axis < axes; ++axis) {
    shape.push_back(pixels.geometry.size[axis]);
    strides.push_back(stride);
    stride *= pixels.geometry.size[axis];
  }
  if (components > 1) {
    shape.push_back(static_cast<py::ssize_t>(components));
    strides.push_back(sizeof(float));
  }
  auto owner = std::make_unique<std::vector<float>>(std::move(pixels.values));
  const float* const first = owner->data();
  const py::capsule keeper(owner.release(),
                           [](void* values) { delete static_cast<std::vector<float>*>(values); });
  return py::array_t<float>(shape, strides, first, keeper);
}

py::array affine_of(const images::Geometry& geometry, Space space) {
  py::array_t<double> affine({4, 4});
  auto to = affine.mutable_unchecked<2>();
  for (py::ssize_t row = 0; row < 4; ++row) {
    const auto at = static_cast<std::size_t>(row);
    const double sign = space == Space::ras && row < 2 ? -1.0 : 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to(row, static_cast<py::ssize_t>(axis)) =
          row == 3 ? 0.0 : sign * geometry.axes[axis][at] * geometry.spacing[axis] + 0.0;
    }
    to(row, 3) = row == 3 ? 1.0 : sign * geometry.origin[at] + 0.0;
  }
  return affine;
}

// A table has tables in it.
// NOLINTNEXTLINE(misc-no-recursion)
toml::table table_of(const py::dict& values) {
  toml::table table;
  for (const auto& [key, value] : values) {
    const auto name = py::str(key).cast<std::string>();
    store(value, [&](auto stored) { table.insert(name, std::move(stored)); });
  }
  return table;
}

toml::array tables_of(std::string_view name, const py::iterable& values) {
  toml::array tables;
  for (const py::handle value : values) {
    if (!py::isinstance<py::dict>(value)) {
      throw InputError(fmt::format("{}: is a list of dictionaries, and {} is none", name,
                                   py::repr(value).cast<std::string>()));
    }
    tables.push_back(table_of(value.cast<py::dict>()));
  }
  return tables;
}

bool is_path(const py::object& value) {
  return py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__");
}

std::string path_of(const py::object& value) {
  return py::module_::import("os").attr("fspath")(value).cast<std::string>();
}

} // namespace hdmbench::python
