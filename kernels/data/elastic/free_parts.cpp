#include "kernels/data/elastic/conditions.hpp"

#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/elastic/wall_hold.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

namespace hdmbench {

namespace {

/// Any confidence above 0 holds; a whole one prescribes.
constexpr float least_holding = std::numeric_limits<float>::denorm_min();
constexpr float prescribing = 1.0F;

/// How a sheet or a body, or a part of one, can move without straining: along its axes, and by small turns,
/// one of a sheet and three of a body. Each known component is an equation of the six; those that do not
/// follow from the others are kept.
class Hold {
  using Equation = std::array<double, 6>;

public:
  /// Takes the components of a site whose confidence is `least` or more, and where any above 0 is, the
  /// directions of its springs.
  void add(const Level& level, int x, int y, int z, float least) {
    axes_ = level.extent.axes();
    sides_ = level.sides;
    const std::size_t at = level.extent.index(x, y, z);
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      if (level.confidence[axis][at] >= least) {
        std::array<double, 3> component{};
        component[axis] = 1.0;
        know(component, {x, y, z});
      }
    }
    for (std::size_t row = 0; row < axes_ && has_springs_by_direction(level) && least <= least_holding;
         ++row) {
      std::array<double, 3> direction{};
      for (std::size_t axis = 0; axis < axes_; ++axis) {
        direction[axis] = entry_by_direction(level, at, row, axis);
      }
      if (direction != std::array<double, 3>{}) {
        slides_ = slides_ || is_on_wall(level, at);
        know(direction, {x, y, z});
      }
    }
  }
  [[nodiscard]] bool knows_nothing() const { return equations_.empty(); }
  [[nodiscard]] bool is_free() const { return equations_.size() < axes_ * (axes_ + 1) / 2; }
  /// "can move in x", "can turn about x = 3, y = 4"; empty: it is held.
  [[nodiscard]] std::string freedom() const {
    if (!is_free()) {
      return "";
    }
    if (slides_) {
      return "can slide along its walls or turn in them; a point or another condition must hold it";
    }
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      if (!first_[axis]) {
        return fmt::format("can move in {}; a condition must give that component somewhere", "xyz"[axis]);
      }
    }
    return axes_ == 3 ? "can turn; known components must lie on more than one line"
                      : fmt::format("can turn about x = {}, y = {}; give x in two rows or y in two columns",
                                    first_[1]->at(0), first_[0]->at(1));
  }
  /// Those that what is known leaves. An equation is about one shift, or about turns alone, as each
  /// component turns about the first place where it is known: so are these.
  [[nodiscard]] std::vector<RigidMotion> motions(Extent body) const {
    const std::array<int, 3> sides = body.sides();
    RigidMotion none{.sides = sides_};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t along = 0; along < 3; ++along) {
        none.about[axis][along] =
            first_[axis] ? static_cast<double>((*first_[axis])[along]) : 0.5 * (sides[along] - 1);
      }
    }
    std::vector<RigidMotion> result;
    std::vector<Equation> known = equations_;
    while (known.size() < axes_ * (axes_ + 1) / 2) {
      Equation left{}; // the largest part of a shift or a turn that follows from no equation
      for (const std::size_t unknown :
           axes_ == 3 ? std::vector<std::size_t>{0, 1, 2, 3, 4, 5} : std::vector<std::size_t>{0, 1, 5}) {
        Equation own{};
        own[unknown] = 1.0;
        own = without(own, known);
        left = product(own, own) > product(left, left) + rounding ? own : left;
      }
      known.push_back(left);
      RigidMotion& motion = result.emplace_back(none);
      const double size = std::sqrt(product(left, left));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        motion.shift[axis] = left[axis] / size;
        motion.turn[axis] = left[3 + axis] / size * (2.0 / std::ranges::max(sides));
      }
    }
    return result;
  }

private:
  /// A site is known along a direction, of any length. Turns are about the first place where a component
  /// is: there it says nothing of them.
  void know(const std::array<double, 3>& direction, std::array<int, 3> place) {
    if (!is_free()) {
      return;
    }
    Equation equation{};
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      if (direction[axis] == 0.0) {
        continue;
      }
      const std::array<int, 3>& first = first_[axis] ? *first_[axis] : first_[axis].emplace(place);
      constexpr double side = 256.0; // sites: all six of about the same size
      const auto way = [&](std::size_t along) {
        return sides_[along % 3] * (place[along % 3] - first[along % 3]) / side;
      };
      equation[axis] = direction[axis];
      equation[3 + (axis + 1) % 3] += direction[axis] * way(axis + 2);
      equation[3 + (axis + 2) % 3] -= direction[axis] * way(axis + 1);
    }
    const double whole = product(equation, equation);
    equation = without(equation, equations_);
    if (product(equation, equation) > rounding * whole) {
      equations_.push_back(equation);
    }
  }
  static double product(const Equation& a, const Equation& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  }
  /// What of it follows from none of the others, which are at right angles to each other.
  static Equation without(Equation equation, const std::vector<Equation>& others) {
    for (const Equation& other : others) {
      const double share = product(equation, other) / product(other, other);
      std::ranges::transform(equation, other, equation.begin(),
                             [&](double own, double its) { return own - share * its; });
    }
    return equation;
  }

  static constexpr double rounding = 1e-9;
  std::size_t axes_ = 2;
  bool slides_ = false; ///< whether a wall was met
  std::array<double, 3> sides_{1.0, 1.0, 1.0};
  std::array<std::optional<std::array<int, 3>>, 3> first_; ///< by component, where it is known
  std::vector<Equation> equations_;                        ///< each at a right angle to the others
};

/// Sets of sites that are joined one by one (union-find); a set is named by its first site.
class Parts {
public:
  explicit Parts(std::size_t sites) : parent_(sites) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t of(std::size_t site) {
    while (parent_[site] != site) {
      parent_[site] = parent_[parent_[site]];
      site = parent_[site];
    }
    return site;
  }
  void join(std::size_t a, std::size_t b) {
    a = of(a);
    b = of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

private:
  std::vector<std::size_t> parent_;
};

/// What is known of a part.
struct Part {
  Hold hold;
  WallHold walls;
  int tissue = 0;           ///< sites that are not void
  std::array<int, 3> first; ///< of these, along x, y and z
  std::array<int, 3> last;

  void add_tissue(std::array<int, 3> site) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] = tissue == 0 ? site[axis] : std::min(first[axis], site[axis]);
      last[axis] = tissue == 0 ? site[axis] : std::max(last[axis], site[axis]);
    }
    ++tissue;
  }
  /// Returns what Hold says, or how it can move where only errors of normals hold it along walls.
  [[nodiscard]] std::string freedom() const {
    if (const std::string free = hold.freedom(); !free.empty()) {
      return free;
    }
    const double angle = walls.least_angle();
    return angle > error_of_normals
               ? ""
               : fmt::format(
                     "can slide along its walls or turn in them: its sites would go at {:.1f} degrees "
                     "to them, and normals of pixels err by {} themselves; a point or another "
                     "condition must hold it",
                     angle, error_of_normals);
  }
};

/// Parts of the tissue that softer sites cut off.
struct TissueParts {
  std::map<std::size_t, Part> found{}; ///< by their first sites
  Parts sets;

  /// Returns the part of a site of tissue.
  [[nodiscard]] const Part& of(std::size_t site) { return found.at(sets.of(site)); }
};

/// Joins the sites of each cell that has one of this modulus or more. Returns which sites are of such cells.
std::vector<std::uint8_t> join_cells(const Level& level, float least, Parts& parts) {
  const Extent extent = level.extent;
  std::vector<std::uint8_t> joined(extent.sites());
  const auto width = static_cast<std::size_t>(extent.width);
  const Extent rows{1, extent.height - 1, std::max(extent.depth - 1, 1)};
  for_each_site(rows, [&](int, int y, int z) { // in an image each row of a cell's four twice
    const int back = extent.depth > 1 ? z + 1 : z;
    const std::array<std::size_t, 4> row{extent.index(0, y, z), extent.index(0, y + 1, z),
                                         extent.index(0, y, back), extent.index(0, y + 1, back)};
    const auto has_tissue = [&](std::size_t x) {
      return std::ranges::any_of(row,
                                 [&](std::size_t first) { return level.modulus.values[first + x] >= least; });
    };
    const auto join = [&](std::size_t own, std::size_t x) {
      for (const std::size_t first : row) {
        parts.join(own, first + x);
        joined[first + x] = 1;
      }
    };
    bool before = has_tissue(0);
    bool is_joined = false; // whether the cell before has joined the four sites that the two share
    for (std::size_t x = 1; x < width; ++x) {
      const bool here = has_tissue(x);
      if ((before || here) && !is_joined) {
        join(row[0] + x - 1, x - 1);
      }
      if (before || here) {
        join(row[0] + x - 1, x);
      }
      is_joined = before || here;
      before = here;
    }
  });
  return joined;
}

/// Returns those that sites of less than this modulus cut off. Sites next to each other, diagonally too, are
/// one part, and so are those with a single softer one between them: they share a site of a cell.
TissueParts parts_of(const Level& level, float least) {
  const Extent extent = level.extent;
  TissueParts result{.sets = Parts(extent.sites())};
  const std::vector<std::uint8_t> in_tissue = join_cells(level, least, result.sets);
  std::pair<std::size_t, Part*> last{0, nullptr}; // most sites are of the part of the one before
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t at = extent.index(x, y, z);
    if (in_tissue[at] != 0) {
      if (const std::size_t first = result.sets.of(at); last.second == nullptr || first != last.first) {
        last = {first, &result.found[first]};
      }
      Part& part = *last.second;
      part.hold.add(level, x, y, z, least_holding);
      if (level.has_walls) {
        part.walls.add(level, {x, y, z});
      }
      if (level.modulus.values[at] >= least) {
        part.add_tissue({x, y, z});
      }
    }
  });
  return result;
}

/// Says where softer sites, of less than `share` of the largest modulus, cut off a part of the tissue that no
/// condition holds, and how it can move; empty: all parts are held.
std::string free_part(const Level& level, float share) {
  const ModulusRange range = modulus_range(level.modulus);
  const float least = share * static_cast<float>(range.stiffest);
  if (static_cast<float>(range.softest) >= least) {
    return "";
  }
  const Extent extent = level.extent;
  for (const auto& [site, part] : parts_of(level, least).found) {
    if (const std::string freedom = part.freedom(); !freedom.empty()) {
      std::string where;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        where += fmt::format("{}{} = {} ... {}", axis == 0 ? "" : ", ", "xyz"[axis], part.first[axis],
                             part.last[axis]);
      }
      return fmt::format("{} {}{} at {} with {} around it (less than {:.0e} of the largest modulus): it {}",
                         part.tissue, extent.axes() == 3 ? "voxel" : "pixel", part.tissue == 1 ? "" : "s",
                         where, share == void_share ? "void" : "soft tissue", share, freedom);
    }
  }
  return "";
}

/// Of all that has this confidence or more.
Hold hold_of(const Level& level, float least) {
  Hold hold;
  for_each_site(level.extent, [&](int x, int y, int z) {
    if (hold.is_free()) {
      hold.add(level, x, y, z, least);
    }
  });
  return hold;
}

} // namespace

void require_held(const Level& level) {
  const Extent image = level.extent;
  if (image.width < 2 || image.height < 2) {
    throw InputError(fmt::format("the elastic energy needs at least 2 x 2 pixels, the image is {} x {}",
                                 image.width, image.height));
  }
  if (const double contrast = contrast_of(level.modulus); contrast > most_contrast) {
    throw InputError(fmt::format("the largest modulus is {:.3g} times the smallest one, and float32 can hold "
                                 "{:.0e}: give the softest tissue more, or the stiffest one less",
                                 contrast, most_contrast));
  }
  const Hold hold = hold_of(level, least_holding);
  if (const std::string freedom = hold.freedom(); !freedom.empty()) {
    throw InputError(
        image.axes() == 3
            ? fmt::format("the conditions leave the elastic body free to move: all {} x {} x {} sites {}",
                          image.width, image.height, image.depth, freedom)
            : fmt::format("the conditions leave the elastic sheet free to move: all {} x {} sites {}",
                          image.width, image.height, freedom));
  }
  if (const std::string part = free_part(level, void_share); !part.empty()) {
    throw InputError("no condition holds a part of the tissue, " + part);
  }
}

Specks loose_specks(const Level& level) {
  TissueParts parts = parts_of(level, void_modulus(level));
  const auto is_loose = [&](const Part& part) {
    return part.tissue < fewest_sites_of_part(level.extent.axes()) && part.hold.knows_nothing();
  };
  Specks specks;
  for (const auto& [first, part] : parts.found) {
    specks.parts += is_loose(part) ? 1 : 0;
  }
  if (specks.parts == 0 || specks.parts == parts.found.size()) {
    return {};
  }
  const float least = void_modulus(level);
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    if (level.modulus.values[site] >= least && is_loose(parts.of(site))) {
      specks.sites.push_back(site);
    }
  }
  return specks;
}

float void_modulus(const Level& level) {
  return void_share * static_cast<float>(modulus_range(level.modulus).stiffest);
}

bool has_void(const Level& level) {
  return static_cast<float>(modulus_range(level.modulus).softest) < void_modulus(level);
}

void keep_void(float least, Level& level) {
  const float least_here = void_modulus(level);
  if (least_here < void_share * least) {
    return; // all of it is void
  }
  const float filling = 0.5F * least_here;
  for (float& modulus : level.modulus.values) {
    modulus = modulus < least ? filling : modulus;
  }
  set_inverse_modulus(level);
}

std::string floating_part(const Level& level) {
  return free_part(level, floating_share);
}

double least_angle_to_walls(const Level& level) {
  double least = 90.0;
  if (level.has_walls) {
    for (const auto& [site, part] : parts_of(level, void_modulus(level)).found) {
      least = std::min(least, part.walls.least_angle());
    }
  }
  return least;
}

std::vector<RigidMotion> free_motions(const Level& level) {
  return hold_of(level, prescribing).motions(level.extent);
}

} // namespace hdmbench
