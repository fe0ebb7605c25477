#pragma once

#include "harness/scene/placement.hpp"
#include "kernels/data/field.hpp"

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// A point of the patient before the displacement, and where it is after it: millimetres along the axes of
/// the space (LPS).
struct PointPair {
  std::string name; ///< as its file has it, else its number
  Placement::Vector before{};
  Placement::Vector after{};
  std::optional<double> deviation{}; ///< millimetres; none: nothing is said
  std::optional<double> area{};      ///< mm^2 of the surface that it is a piece of; none: a point by itself
};

/// Points of 3D Slicer's, .fcsv or .mrk.json, in LPS or RAS as they say, which belong together by their
/// order. Throws InputError with file and line, also where their names say another order.
[[nodiscard]] std::vector<PointPair> read_point_pairs(const std::filesystem::path& before,
                                                      const std::filesystem::path& after);
/// A text or .csv file with a line a point, x y z dx dy dz and perhaps a deviation, with blanks or commas
/// between: where it is before and how it moves, in LPS. "#" begins a comment; a first line of words is left
/// out. Throws InputError with file and line.
[[nodiscard]] std::vector<PointPair> read_point_pairs(const std::filesystem::path& file);

/// The point that such a line tells of. Throws InputError for another count of numbers, one that is not
/// finite, and a deviation below 0.
[[nodiscard]] PointPair point_pair(std::span<const double> numbers, std::string name);

/// A known displacement at a point of a scene.
struct KnownPoint {
  std::string name;
  std::array<double, 3> at{};     ///< among the sites; of an image z is 0
  std::array<double, 3> target{}; ///< pixels
  double deviation = 0.0;         ///< pixels; 0: it is met
  /// A piece of a surface is so many points: its area over the square of point_reach, so that a surface is
  /// as stiff whatever its triangles are. None: it is a point by itself.
  std::optional<double> share{};
};

/// Returns how far the displacement at the point is from the known one, pixels.
[[nodiscard]] double residual_at(const KnownPoint& point, const VectorField& displacement);

/// The share of a site in the spring of a point with a deviation.
struct PointSpring {
  std::array<int, 3> at{}; ///< the site
  double weight = 0.0; ///< so many times the modulus of the site: its stiffness as spring_stiffness() has it
};
/// How far from a point its spring reaches, millimetres, where the pixels are not wider. A pull at one place
/// would move the tissue there the farther the smaller its pixels are. A cube of that side, 15.6 mm^3, is the
/// tissue that a point stands for, in an image the square.
inline constexpr double point_reach = 2.5;
/// Returns the springs that a point with a deviation above 0 puts on the sites around it. Together they weigh
/// as the tissue that it stands for: as stiff as modulus * 15.6 mm^3 / deviation^2 (MPa, mm: N / mm), times
/// its share, in an image modulus * 6.25 mm^2 / deviation^2 times the thickness, at whatever size of the
/// pixels, `spacing` millimetres of the shortest side. They fall linearly to 0 at point_reach, or at the next
/// site where that is farther.
[[nodiscard]] std::vector<PointSpring> point_springs(const KnownPoint& point, Extent extent,
                                                     const std::array<double, 3>& sides, double spacing);

} // namespace hdmbench
