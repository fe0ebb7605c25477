#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string>
#include <string_view>

/// What all plots share: colours, axes, margins. Lengths are SVG units.
namespace hdmbench::report {

/// Each reaches a contrast of 4.5 on white; neighbours differ in lightness as well as in hue.
inline constexpr std::array<const char*, 8> plot_colours{"1f2328", "0067a8", "b04a00", "00795a",
                                                         "a3307a", "7a5c00", "5b4bb7", "9f1d2f"};
inline constexpr const char* text_colour = "3c4046";
inline constexpr double plot_font_size = 13.0;

/// The terminal with the look of axes, tics and grid.
[[nodiscard]] std::string plot_start(double width, double height);

/// Distances of the axes from the four edges of the picture.
struct Margins {
  double left = 0.0;
  double right = 0.0;
  double top = 0.0;
  double bottom = 0.0;
};
[[nodiscard]] std::string plot_margins(double width, double height, const Margins& margins);

/// Titles of axes at the edge of the picture: the y title centred `from_bottom`, the x title below the axis.
/// A title replaces the one before of the same kind.
[[nodiscard]] std::string y_title(std::string_view text, double width, double height, double from_bottom);
[[nodiscard]] std::string x_title(std::string_view text, double height);

/// The interval of the finite ones among the values.
class Interval {
public:
  void include(double value);
  void include(std::span<const double> values);
  [[nodiscard]] bool empty() const { return low_ > high_; }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }
  /// "[-1.05:1.05]" with a margin on both sides; never of length 0.
  [[nodiscard]] std::string range() const;
  /// 1, 2 or 5 times a power of ten: at most `count` steps in the interval.
  [[nodiscard]] double step(int count) const;

private:
  double low_ = HUGE_VAL;
  double high_ = -HUGE_VAL;
};

/// A named block of lines "x y"; what is not finite interrupts the line. As many x as y.
[[nodiscard]] std::string data_block(std::string_view name, std::span<const double> x,
                                     std::span<const double> y);

} // namespace hdmbench::report
