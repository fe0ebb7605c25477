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
/// rows, or known y in two columns, determine t.
class Hold {
public:
  /// Takes the components of a site whose confidence is `least` or more.
  void add(const Level& level, int x, int y, float least) {
    const std::size_t at = level.extent.index(x, y);
    know(level.confidence[0][at] >= least, y, row_);
    know(level.confidence[1][at] >= least, x, column_);
  }
  [[nodiscard]] bool is_free() const { return row_ < 0 || column_ < 0 || turns_; }
  /// "can move in x", "can turn about x = 3, y = 4"; empty: it is held.
  [[nodiscard]] std::string freedom() const {
    if (!is_free()) {
      return "";
    }
    if (row_ < 0 || column_ < 0) {
      return fmt::format("can move in {}; a condition must give that component somewhere",
                         row_ < 0 ? 'x' : 'y');
    }
    return fmt::format("can turn about x = {}, y = {}; give x in two rows or y in two columns", column_,
                       row_);
  }
  /// Those that what is known leaves to the image: at most three.
  [[nodiscard]] std::vector<RigidMotion> motions(Extent image) const {
    std::vector<RigidMotion> result;
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

  int row_ = -1;    // of a known x
  int column_ = -1; // of a known y
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
  int tissue = 0; ///< pixels that are not void
  int left = 0;
  int right = 0;
  int top = 0;
  int bottom = 0;

  void add_tissue(int x, int y) {
    left = tissue == 0 ? x : std::min(left, x);
    right = tissue == 0 ? x : std::max(right, x);
    top = tissue == 0 ? y : top; // rows come in order
    bottom = y;
    ++tissue;
  }
};

/// Where void cuts off a part of the tissue that no condition holds. Pixels next to each other, diagonally
/// too, are one part, and so are those with a single void pixel between them: they share a site of a cell.
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
  for (int y = 0; y + 1 < extent.height; ++y) {
    for (int x = 0; x + 1 < extent.width; ++x) {
      const std::array<std::size_t, 4> corners{extent.index(x, y), extent.index(x + 1, y),
                                               extent.index(x, y + 1), extent.index(x + 1, y + 1)};
      if (std::ranges::any_of(corners, [&](std::size_t at) { return modulus[at] >= least; })) {
        for (const std::size_t at : corners) {
          parts.join(corners[0], at);
          in_tissue[at] = 1;
        }
      }
    }
  }
  std::map<std::size_t, Part> found; // by the first site
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t at = extent.index(x, y);
      if (in_tissue[at] != 0) {
        Part& part = found[parts.of(at)];
        part.hold.add(level, x, y, least_holding);
        if (modulus[at] >= least) {
          part.add_tissue(x, y);
        }
      }
    }
  }
  for (const auto& [first, part] : found) {
    if (const std::string freedom = part.hold.freedom(); !freedom.empty()) {
      throw InputError(fmt::format("no condition holds a part of the tissue, {} {} at x = {} ... {}, y = {} "
                                   "... {} with void around it "
                                   "(less than {:.0e} of the largest modulus): it {}",
                                   part.tissue, part.tissue == 1 ? "pixel" : "pixels", part.left, part.right,
                                   part.top, part.bottom, void_share, freedom));
    }
  }
}

} // namespace

void require_held(const Level& level) {
  const Extent image = level.extent;
  if (image.width < 2 || image.height < 2) {
    throw InputError(fmt::format("the elastic energy needs at least 2 x 2 pixels, the image is {} x {}",
                                 image.width, image.height));
  }
  Hold hold;
  for (int y = 0; y < image.height && hold.is_free(); ++y) {
    for (int x = 0; x < image.width; ++x) {
      hold.add(level, x, y, least_holding);
    }
  }
  if (const std::string freedom = hold.freedom(); !freedom.empty()) {
    throw InputError(fmt::format("the conditions leave the elastic sheet free to move: all {} x {} sites {}",
                                 image.width, image.height, freedom));
  }
  require_parts_held(level);
}

std::vector<RigidMotion> free_motions(const Level& level) {
  Hold hold;
  for (int y = 0; y < level.extent.height; ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      hold.add(level, x, y, prescribing);
    }
  }
  return hold.motions(level.extent);
}

} // namespace hdmbench
