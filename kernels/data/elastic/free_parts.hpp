#pragma once

#include "kernels/data/level.hpp"

#include <string>
#include <vector>

namespace hdmbench {

/// A pixel whose modulus is a smaller share of the stiffest one's is void: added to it in float32 it changes
/// no bit, so nobody can have meant it to hold anything.
inline constexpr float void_share = 0x1p-24F;

/// A motion of a sheet that strains nothing, of small turns; pixels.
struct RigidMotion {
  double x = 0.0;
  double y = 0.0;
  double turn = 0.0;
  double column = 0.0; ///< about which it turns
  double row = 0.0;

  [[nodiscard]] double x_at(int site_row) const { return x - turn * (site_row - row); }
  [[nodiscard]] double y_at(int site_column) const { return y + turn * (site_column - column); }
};

/// How a sheet, or a part of one, can move without straining: by (a - t y, b + t x) only. Known x in two
/// rows, or known y in two columns, determine t.
class Hold {
public:
  /// Takes the conditions of a site.
  void add(const Level& level, int x, int y);
  /// x is known somewhere in this row, y in this column.
  void know_x(int row);
  void know_y(int column);
  [[nodiscard]] bool is_free() const { return row_ < 0 || column_ < 0 || turns_; }
  /// "can move in x", "can turn about x = 3, y = 4"; empty: it is held.
  [[nodiscard]] std::string freedom() const;
  /// Those that what is known leaves to the image: at most three.
  [[nodiscard]] std::vector<RigidMotion> motions(Extent image) const;

private:
  int row_ = -1;    // of a known x
  int column_ = -1; // of a known y
  bool turns_ = true;
};

/// Throws InputError where void cuts off a part of the tissue that no condition holds; says which, and how it
/// can move. Pixels next to each other, diagonally too, are one part, and so are those with a single void
/// pixel between them: they share a site of a cell.
void require_parts_held(const Level& level);

} // namespace hdmbench
