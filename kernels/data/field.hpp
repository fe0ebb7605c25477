#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <concepts>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// The sites of an image or a volume along x, y and z, each >= 1: pixels where depth is 1, else voxels. Site
/// (x, y, z) has index (z * height + y) * width + x; y grows downwards.
struct Extent {
  int width = 0;
  int height = 0;
  int depth = 1;

  /// Returns how many components a displacement has: 2 where depth is 1, else 3.
  [[nodiscard]] std::size_t axes() const { return depth > 1 ? 3 : 2; }
  [[nodiscard]] std::size_t sites() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
           static_cast<std::size_t>(depth);
  }
  /// Rows of all slices: y + height * z is one of them.
  [[nodiscard]] int rows() const { return height * depth; }
  [[nodiscard]] std::size_t index(int x, int y, int z = 0) const {
    const auto row =
        static_cast<std::size_t>(z) * static_cast<std::size_t>(height) + static_cast<std::size_t>(y);
    return row * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] std::array<int, 3> sides() const { return {width, height, depth}; }
  /// "300 x 200", of a volume "64 x 48 x 32"; `by` stands between the sides.
  [[nodiscard]] std::string text(std::string_view by = " x ") const {
    std::string sides = std::to_string(width);
    sides.append(by).append(std::to_string(height));
    return depth > 1 ? sides.append(by).append(std::to_string(depth)) : sides;
  }
  /// Returns x, y and z of the site of that index.
  [[nodiscard]] std::array<int, 3> coordinates(std::size_t site) const {
    const auto across = static_cast<std::size_t>(width);
    const auto down = static_cast<std::size_t>(height);
    return {static_cast<int>(site % across), static_cast<int>(site / across % down),
            static_cast<int>(site / (across * down))};
  }
  /// "x = 3, y = 4", of a volume "x = 3, y = 4, z = 5": the site of that index, for messages.
  [[nodiscard]] std::string place(std::size_t site) const {
    const auto [x, y, z] = coordinates(site);
    const std::string in_slice = "x = " + std::to_string(x) + ", y = " + std::to_string(y);
    return depth > 1 ? in_slice + ", z = " + std::to_string(z) : in_slice;
  }
  auto operator<=>(const Extent&) const = default;
};

/// call(x, y) for every site of an image, row by row; call(x, y, z) also for those of a volume, slice by
/// slice.
template <typename Call>
void for_each_site(Extent extent, const Call& call) {
  for (int z = 0; z < extent.depth; ++z) {
    for (int y = 0; y < extent.height; ++y) {
      for (int x = 0; x < extent.width; ++x) {
        if constexpr (std::invocable<const Call&, int, int, int>) {
          call(x, y, z);
        } else {
          call(x, y);
        }
      }
    }
  }
}

/// Below this many sites threads cost more than they bring.
inline constexpr std::size_t sites_worth_threads = std::size_t{1} << 15;

/// Makes call(0) ... call(count - 1), on all threads where `is_worth_it`. Throws the first exception that one
/// of them threw; from a thread of OpenMP itself none may come out.
void on_all_threads(std::size_t count, bool is_worth_it, const std::function<void(std::size_t)>& call);

/// Makes `size` zeros of each of these arrays, which are empty: on a thread each where they are long, as the
/// system clears the memory only when it is touched first.
void make_zeros(std::span<std::vector<float>* const> arrays, std::size_t size);

/// One float per site.
struct ScalarField {
  ScalarField() = default;
  explicit ScalarField(Extent extent_, float fill = 0.0F) : extent(extent_), values(extent_.sites(), fill) {}

  Extent extent;
  std::vector<float> values;
};

/// A vector per site, a plane of numbers for each axis of the extent; the planes of other axes are empty.
template <typename Number>
struct Planes {
  Planes() = default;
  explicit Planes(Extent extent_, Number fill = 0) : extent(extent_) {
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      planes[axis].assign(extent.sites(), fill);
    }
  }

  [[nodiscard]] std::vector<Number>& operator[](std::size_t axis) { return planes[axis]; }
  [[nodiscard]] const std::vector<Number>& operator[](std::size_t axis) const { return planes[axis]; }

  Extent extent;
  std::array<std::vector<Number>, 3> planes;
};

/// Displacement or target (pixels of the full resolution image on every level), or confidence (0 ... 1).
struct VectorField : Planes<float> {
  using Planes::Planes;
  explicit VectorField(Extent extent_) {
    extent = extent_;
    const std::array<std::vector<float>*, 3> arrays{&planes[0], &planes[1], &planes[2]};
    make_zeros(std::span(arrays).first(extent.axes()), extent.sites());
  }
};

/// Gives the field such an extent and values that say nothing. It keeps the memory of one that has it
/// already: the system clears new memory first, which in a large volume takes as long as a sweep.
inline void resize(VectorField& field, Extent extent) {
  if (field.extent != extent || field[0].size() != extent.sites()) {
    field = VectorField(extent);
  }
}

/// A displacement in pixels where float would round too much.
struct DoubleField : Planes<double> {
  using Planes::Planes;
  /// The same values in double.
  explicit DoubleField(const VectorField& field) {
    extent = field.extent;
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      planes[axis].assign(field[axis].begin(), field[axis].end());
    }
  }

  /// Rounded to float.
  [[nodiscard]] VectorField to_float() const {
    const auto round = [](double value) { return static_cast<float>(value); };
    VectorField field(extent);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      std::transform(planes[axis].begin(), planes[axis].end(), field[axis].begin(), round);
    }
    return field;
  }
};

} // namespace hdmbench
