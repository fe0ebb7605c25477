#include "kernels/data/elastic/free_parts.hpp"

#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace hdmbench {

namespace {

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

} // namespace

void Hold::add(const Level& level, int x, int y) {
  const std::size_t at = level.extent.index(x, y);
  if (level.confidence.x[at] > 0.0F) {
    know_x(y);
  }
  if (level.confidence.y[at] > 0.0F) {
    know_y(x);
  }
}

void Hold::know_x(int row) {
  turns_ = turns_ && (row_ < 0 || row_ == row);
  row_ = row;
}

void Hold::know_y(int column) {
  turns_ = turns_ && (column_ < 0 || column_ == column);
  column_ = column;
}

std::string Hold::freedom() const {
  if (!is_free()) {
    return "";
  }
  if (row_ < 0 || column_ < 0) {
    return fmt::format("can move in {}; a condition must give that component somewhere",
                       row_ < 0 ? 'x' : 'y');
  }
  return fmt::format("can turn about x = {}, y = {}; give x in two rows or y in two columns", column_, row_);
}

std::vector<RigidMotion> Hold::motions(Extent image) const {
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
        part.hold.add(level, x, y);
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

} // namespace hdmbench
