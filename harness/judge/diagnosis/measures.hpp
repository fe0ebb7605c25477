#pragma once

#include "harness/judge/diagnosis/diagnosis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The numbers that warnings are made of, and how one is made of them.
namespace hdmbench {

namespace diagnosis {

/// The row of warnings.json with these figures. Its kind is the row's name up to a slash.
[[nodiscard]] Warning warning_of(std::string_view row, std::optional<std::size_t> sites,
                                 fmt::format_args figures);

/// Adds the row of warnings.json; `figures` are named arguments of fmt beside `sites`.
template <typename... Figures>
void warn(Warnings& warnings, std::string_view row, std::optional<std::size_t> sites,
          const Figures&... figures) {
  warnings.push_back(
      warning_of(row, sites, fmt::make_format_args(fmt::arg("sites", sites.value_or(0)), figures...)));
}

/// Returns the warnings without advice that the scene has followed already: parts between semicolons that
/// begin with its own method or candidates are left out, where others remain.
[[nodiscard]] Warnings without_what_is_given(Warnings warnings, const Scene& scene);

/// At how many sites something is seen, and where most.
struct Seen {
  std::size_t count = 0;
  double most = 0.0;
  std::size_t worst = 0; ///< the site

  void add(double how_much, std::size_t site) {
    ++count;
    worst = how_much > most ? site : worst;
    most = std::max(most, how_much);
  }
  /// Adds what was seen at later sites.
  void add(const Seen& later) {
    count += later.count;
    worst = later.most > most ? later.worst : worst;
    most = std::max(most, later.most);
  }
};

/// Smallest and largest value; `any` false where there was none.
struct Range {
  double least = 0.0;
  double most = 0.0;
  bool any = false;

  void include(double value);
  [[nodiscard]] double width() const { return most - least; }
};

/// One component of a scene at full resolution.
struct Component {
  char name;        ///< 'x', 'y' or 'z'
  std::size_t axis; ///< of any field
  int thickness;    ///< sites across the image in its direction
  std::span<const float> target;
  std::span<const float> confidence;
  std::span<const float> start; ///< empty: 0 everywhere
  Range known{};                ///< of the targets that are known, pixels

  [[nodiscard]] double start_of(std::size_t site) const {
    return start.empty() ? 0.0 : static_cast<double>(start[site]);
  }
};
[[nodiscard]] std::vector<Component> components(const Scene& scene);

/// The smallest candidate that moves and the largest, pixels, without sign; 0 where 0 is the only one.
struct StepSizes {
  double smallest = 0.0;
  double largest = 0.0;
};
[[nodiscard]] StepSizes step_sizes(const StepSet& steps);

/// Half of it is how far a component may stay from its own minimum: the smallest candidate where the rule
/// has candidates, else 0.
[[nodiscard]] double quantum(const Scene& scene);

/// call(site, next, axis) for every two sites that follow each other along an axis.
template <typename Call>
void for_each_pair(Extent extent, const Call& call) {
  const std::array<std::size_t, 3> strides{1, extent.index(0, 1), extent.index(0, 0, 1)};
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    const auto side = static_cast<std::size_t>(extent.sides()[axis]);
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      if (site / strides[axis] % side + 1 < side) {
        call(site, site + strides[axis], axis);
      }
    }
  }
}

/// Distance to the nearest counted site (a value > 0) in sites along a path of straight steps and of diagonal
/// ones, each as long as it says; the sum of the sides where there is none.
[[nodiscard]] std::vector<float> distance_to_nearest(Extent extent, std::span<const float> counted,
                                                     float diagonal = 1.0F);

} // namespace diagnosis

/// How far a field is from rest on the full resolution.
struct RestState {
  /// Distance of each component from the minimum of its own energy, observation included, pixels, signed.
  VectorField missing;
  double rms = 0.0; ///< sqrt(mean |missing|^2), pixels
  /// Sites that one more simultaneous sweep over the candidates would move, and those of them that a second
  /// one would move back to the bit. Rule::steps only, else 0.
  std::size_t moving = 0;
  std::size_t swapping = 0;
  /// The root mean square of the part of `missing` that changes sign from site to site along a component's
  /// own axis, pixels, and its share of the whole, squared: 1 for stripes, 3/8 for noise, 0 for what is
  /// smooth.
  double stripes = 0.0;
  double stripes_share = 0.0;
};

/// `displacement` is finite and has the scene's extent.
[[nodiscard]] RestState measure_rest(const Scene& scene, const VectorField& displacement);

/// An estimate of the RMSD to the fixed point from RestState::missing, pixels; good to a factor of three
/// where the moduli are nearly equal. There a component is the mean of its neighbours, and its error d obeys
/// -(1/2 d_xx + 1/3 d_yy) = missing, in a volume with 1/3 d_zz more (y, z: the same with 1/2 for their own
/// axis). So a wave of the wave number k in `missing` is amplified by 2.4 / k^2, in a volume by 2.6 / k^2, on
/// average over its directions. Waves of 2 s to 4 s pixels are what block means over s sites a side keep and
/// those over 2 s lose. The longest wave is, along each axis, four times the largest distance of a free site
/// from the nearest condition. Observed components are not amplified.
[[nodiscard]] double accumulated_distance(const Scene& scene, const VectorField& missing);

} // namespace hdmbench
