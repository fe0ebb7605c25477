#include "kernels/data/elastic/conditions.hpp"

#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <string>

namespace hdmbench {

namespace {

/// How a sheet, or a part of one, can move without straining: by (a - t y, b + t x) only. Known x in two
/// rows, or known y in two columns, determine t. A body has three more motions: each known component is an
/// equation of the six, and those that do not follow from the others are kept.
class Hold {
public:
  /// Takes the components of a site whose confidence is `least` or more.
  void add(const Level& level, int x, int y, int z, float least) {
    const std::size_t at = level.extent.index(x, y, z);
    if (level.extent.axes() == 3) {
      is_body_ = true;
      const std::array<double, 3> place{static_cast<double>(x), static_cast<double>(y),
                                        static_cast<double>(z)};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (level.confidence[axis][at] >= least) {
          know(axis, place);
        }
      }
      return;
    }
    know(level.confidence[0][at] >= least, y, row_);
    know(level.confidence[1][at] >= least, x, column_);
  }
  [[nodiscard]] bool is_free() const {
    return is_body_ ? equations_.size() < 6 : row_ < 0 || column_ < 0 || turns_;
  }
  /// "can move in x", "can turn about x = 3, y = 4"; empty: it is held.
  [[nodiscard]] std::string freedom() const {
    if (!is_free()) {
      return "";
    }
    if (is_body_) {
      const auto missing = std::ranges::find(is_known_, false);
      return missing == is_known_.end()
                 ? "can turn; known components must lie on more than one line"
                 : fmt::format("can move in {}; a condition must give that component somewhere",
                               "xyz"[missing - is_known_.begin()]);
    }
    if (row_ < 0 || column_ < 0) {
      return fmt::format("can move in {}; a condition must give that component somewhere",
                         row_ < 0 ? 'x' : 'y');
    }
    return fmt::format("can turn about x = {}, y = {}; give x in two rows or y in two columns", column_,
                       row_);
  }
  /// Those that what is known leaves to the image: at most three.
  /// None of a body.
  [[nodiscard]] std::vector<RigidMotion> motions(Extent image) const {
    std::vector<RigidMotion> result;
    if (is_body_) {
      return result;
    }
    if (row_ < 0) {
      result.push_back({.x = 1.0});
    }
    if (column_ < 0) {
      result.push_back({.y = 1.0});
    }
    if (turns_) {
      result.push_back({.turn = 2.0 / std::max(image.width, image.height),
                        .column = column_ < 0 ? 0.5 * (image.width - 1) : column_,
                        .row = row_ < 0 ? 0.5 * (image.height - 1) : row_});
    }
    return result;
  }

private:
  void know(bool is_known, int line, int& known) {
    if (is_known) {
      turns_ = turns_ && (known < 0 || known == line);
      known = line;
    }
  }

  /// By a motion: three components, and three turns. What is left of it besides the equations before it.
  void know(std::size_t axis, std::array<double, 3> place) {
    is_known_[axis] = true;
    constexpr double side = 256.0; // sites: all six of about the same size
    std::array<double, 6> equation{};
    equation[axis] = 1.0;
    equation[3 + (axis + 1) % 3] = place[(axis + 2) % 3] / side;
    equation[3 + (axis + 2) % 3] = -place[(axis + 1) % 3] / side;
    const auto product = [](const auto& a, const auto& b) {
      return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
    };
    const double whole = product(equation, equation);
    for (const std::array<double, 6>& other : equations_) {
      const double share = product(equation, other) / product(other, other);
      std::ranges::transform(equation, other, equation.begin(),
                             [&](double own, double its) { return own - share * its; });
    }
    constexpr double rounding = 1e-9;
    if (equations_.size() < 6 && product(equation, equation) > rounding * whole) {
      equations_.push_back(equation);
    }
  }

  bool is_body_ = false;
  std::array<bool, 3> is_known_{};
  std::vector<std::array<double, 6>> equations_; ///< each at a right angle to the others
  int row_ = -1;                                 // of a known x
  int column_ = -1;                              // of a known y
  bool turns_ = true;
};

/// Any confidence above 0 holds; a whole one prescribes.
constexpr float least_holding = std::numeric_limits<float>::denorm_min();
constexpr float prescribing = 1.0F;

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
};

/// call(x, y, z) for every site, or every cell, in reading order.
template <typename Call>
void for_each(Extent extent, const Call& call) {
  for (int z = 0; z < extent.depth; ++z) {
    for (int y = 0; y < extent.height; ++y) {
      for (int x = 0; x < extent.width; ++x) {
        call(x, y, z);
      }
    }
  }
}

/// Where void cuts off a part of the tissue that no condition holds. Sites next to each other, diagonally
/// too, are one part, and so are those with a single void one between them: they share a site of a cell.
void require_parts_held(const Level& level) {
  const std::vector<float>& modulus = level.modulus.values;
  const ModulusRange range = modulus_range(level.modulus);
  const float least = void_share * static_cast<float>(range.stiffest);
  if (static_cast<float>(range.softest) >= least) {
    return;
  }
  const Extent extent = level.extent;
  Parts parts(extent.sites());
  std::vector<std::uint8_t> in_tissue(extent.sites()); // a site of a cell that is not all void
  const Extent cells{extent.width - 1, extent.height - 1, std::max(extent.depth - 1, 1)};
  for_each(cells, [&](int x, int y, int z) {
    std::array<std::size_t, 8> corners{};
    for (std::size_t corner = 0; corner < 8; ++corner) { // in an image each of four twice
      const auto bit = [&](std::size_t axis) { return static_cast<int>(corner >> axis & 1); };
      corners[corner] = extent.index(x + bit(0), y + bit(1), extent.depth > 1 ? z + bit(2) : 0);
    }
    if (std::ranges::any_of(corners, [&](std::size_t at) { return modulus[at] >= least; })) {
      for (const std::size_t at : corners) {
        parts.join(corners[0], at);
        in_tissue[at] = 1;
      }
    }
  });
  std::map<std::size_t, Part> found; // by the first site
  for_each(extent, [&](int x, int y, int z) {
    const std::size_t at = extent.index(x, y, z);
    if (in_tissue[at] != 0) {
      Part& part = found[parts.of(at)];
      part.hold.add(level, x, y, z, least_holding);
      if (modulus[at] >= least) {
        part.add_tissue({x, y, z});
      }
    }
  });
  for (const auto& [site, part] : found) {
    if (const std::string freedom = part.hold.freedom(); !freedom.empty()) {
      std::string where;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        where += fmt::format("{}{} = {} ... {}", axis == 0 ? "" : ", ", "xyz"[axis], part.first[axis],
                             part.last[axis]);
      }
      throw InputError(
          fmt::format("no condition holds a part of the tissue, {} {}{} at {} with void around it "
                      "(less than {:.0e} of the largest modulus): it {}",
                      part.tissue, extent.axes() == 3 ? "voxel" : "pixel", part.tissue == 1 ? "" : "s", where,
                      void_share, freedom));
    }
  }
}

/// Of all that has this confidence or more.
Hold hold_of(const Level& level, float least) {
  Hold hold;
  for_each(level.extent, [&](int x, int y, int z) {
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
  const Hold hold = hold_of(level, least_holding);
  if (const std::string freedom = hold.freedom(); !freedom.empty()) {
    throw InputError(
        image.axes() == 3
            ? fmt::format("the conditions leave the elastic body free to move: all {} x {} x {} sites {}",
                          image.width, image.height, image.depth, freedom)
            : fmt::format("the conditions leave the elastic sheet free to move: all {} x {} sites {}",
                          image.width, image.height, freedom));
  }
  require_parts_held(level);
}

std::vector<RigidMotion> free_motions(const Level& level) {
  return hold_of(level, prescribing).motions(level.extent);
}

} // namespace hdmbench
