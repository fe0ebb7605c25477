#pragma once

#include "kernels/data/elastic/law.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/modulus.hpp"

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

/// The forces of tissues with laws of large strains (specification/laws), on the host: the same bits whatever
/// backend solves.
namespace hdmbench {

/// The cell that has kept least of its volume, or of its area in an image, at one of its Gauss points.
struct LeastVolume {
  double share = std::numeric_limits<double>::infinity();
  std::size_t site = 0; ///< the corner of the cell with the least coordinates
};

/// Returns the law of the level's tissues: where it names none, the shipped one.
[[nodiscard]] const Law& law_of(const Level& level);

/// A level whose tissues have laws; one without is linear everywhere. Where walls are (Level::has_walls), all
/// of a cell with a corner in void is void: its other corners slide, and half of a cell that hangs on them
/// would turn over.
class LawForces {
public:
  /// The level must outlive this object.
  LawForces(const Level& level, const ElasticModel& model);

  /// Sets `force` to what the tissues do to every site under a displacement, in the unit of sessions
  /// (force_unit), 0 at prescribed components. Springs and loads are not in it. Returns the cell that has
  /// kept least, of those whose corners are not all prescribed; linear tissue counts as if it kept all.
  LeastVolume operator()(const VectorField& displacement, VectorField& force) const;

  /// Another one for each object, as long as somebody has it.
  [[nodiscard]] std::shared_ptr<const void> identity() const { return identity_; }
  [[nodiscard]] const Level& level() const { return level_; }
  [[nodiscard]] const Law& law() const { return law_; }
  [[nodiscard]] const CellConstants& constants() const { return constants_; }
  /// Returns whether the cell whose corner with the least coordinates is site x of a row is one that can
  /// move.
  [[nodiscard]] bool can_move(int x, std::size_t row) const {
    return x >= rows_[row].begin && x < rows_[row].end;
  }

  /// Returns how many times as stiff the tissue of every site is under a displacement as without, 0.1 ... 10,
  /// in the stiffest of the cells around it: what a preconditioner that follows the strain multiplies moduli
  /// by. Too stiff, it goes too slowly there; too soft, every step of all would be as short as one cell
  /// needs. Turned over tissue would have any.
  [[nodiscard]] ScalarField stiffness_ratio(const VectorField& displacement) const;

private:
  class Part;

  /// The cells of a row that a component can move: the others are as the conditions have them.
  struct Cells {
    int begin = 0;
    int end = 0;
  };

  /// Where a row of sites begins that a row (y, z) of cells lies between.
  [[nodiscard]] std::size_t corner_row(int y, int z, std::size_t row) const;
  /// `none` and `linear`: rows of 0, and of what says that tissue is linear.
  [[nodiscard]] CellRows rows_at(int y, int z, const VectorField& displacement, const float* none,
                                 const float* linear) const;

  std::shared_ptr<const void> identity_ = std::make_shared<int>();
  const Level& level_;
  const Law& law_;
  CellConstants constants_;
  std::vector<Cells> rows_;
};

} // namespace hdmbench
