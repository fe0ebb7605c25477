#include "kernels/data/elastic/set_up.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

/// The cells of volumes: moments, and how sites respond. Loops go over `lanes` cells side by side.
namespace hdmbench {

namespace {

constexpr std::size_t lanes = 16;
constexpr std::size_t moment_count = moments_of_cells(3);
constexpr std::size_t monomials = 27; ///< r^i s^j t^k with i, j, k <= 2; four of them are never read

/// i + 3 j + 9 k of the moments in the order of CellMoments (volume.inc).
constexpr std::array<std::size_t, moment_count> place_of_moment{0, 1,  3,  9,  2,  6,  18, 4,  10, 12, 5, 11,
                                                                7, 15, 19, 21, 13, 14, 16, 22, 8,  20, 24};
/// Of those that are 0 where, and on the image only where, a cell has one modulus.
constexpr std::array<std::size_t, 7> odd_places{1, 3, 9, 4, 10, 12, 13};
/// Those of one square, which are a third of the mean where a cell has one modulus, then those of two.
constexpr std::array<std::size_t, 6> even_places{2, 6, 18, 8, 20, 24};

/// Of cells side by side, one more than lanes: what is between sites.
using CellRow = std::array<std::array<float, lanes + 1>, monomials>;

/// The same moments as members.
constexpr std::array<float VolumeInFloat::CellMoments::*, moment_count> members = [] {
  using Cell = VolumeInFloat::CellMoments;
  return std::array{&Cell::m,    &Cell::r,    &Cell::s,    &Cell::t,    &Cell::rr,  &Cell::ss,
                    &Cell::tt,   &Cell::rs,   &Cell::rt,   &Cell::st,   &Cell::rrs, &Cell::rrt,
                    &Cell::rss,  &Cell::sst,  &Cell::rtt,  &Cell::stt,  &Cell::rst, &Cell::rrst,
                    &Cell::rsst, &Cell::rstt, &Cell::rrss, &Cell::rrtt, &Cell::sstt};
}();

/// Sets the moments of one cell of the image from the moduli of its corners. A function of its own, so that
/// the loop over cells becomes one of vectors.
HDM_FUNCTION void set_image_cell(CellRow& to, const std::array<const float*, 8>& corners, int i, int step) {
  const auto cell = VolumeInFloat::image_cell(
      VolumeInFloat::corners_of([&](std::size_t corner) HDM_INLINED { return corners[corner][i * step]; }),
      1.0F);
  const auto set = [&]<std::size_t... number>(std::index_sequence<number...>) HDM_INLINED {
    ((to[place_of_moment[number]][static_cast<std::size_t>(i)] = cell.*members[number]), ...);
  };
  set(std::make_index_sequence<moment_count>());
}

/// The cells x, x + step, ... of row (y, z); 0 where there are none. Of 16 cells and a 17th where step is 1.
HDM_FUNCTION void read_cells(const ElasticLevel& level, int x, int step, int y, int z, CellRow& to) {
  const Extent cells = level.grid.cells();
  for (auto& row : to) {
    row.fill(0.0F);
  }
  if (y < 0 || z < 0 || y >= cells.height || z >= cells.depth) {
    return;
  }
  const int first = std::max(0, -x); // step is 1 where x < 0
  const int last =
      std::min(static_cast<int>(lanes) + (step == 1 ? 1 : 0), (cells.width - x + step - 1) / step);
  const std::size_t at = level.grid.index(0, y, z);
  if (level.moments.size() > 1) {
    for (std::size_t number = 0; number < moment_count; ++number) {
      const float* const from = level.moments[number].data() + at + x;
      float* const row = to[place_of_moment[number]].data();
      for (int i = first; i < last; ++i) {
        row[i] = from[i * step];
      }
    }
    return;
  }
  std::array<const float*, 8> corners;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    corners[corner] = level.moments[0].data() + at + x + level.grid.to_corner(corner);
  }
#pragma omp simd
  for (int i = first; i < last; ++i) {
    set_image_cell(to, corners, i, step);
  }
}

/// The moments of what two cells make beside each other along an axis, into the lower one; `step` is 1, 3 or
/// 9, the axis in a monomial. On the parent's scale but for a factor.
HDM_FUNCTION void join(CellRow& low, const CellRow& high, std::size_t step) {
  for (std::size_t first = 0; first < monomials; ++first) {
    if (first / step % 3 != 0) {
      continue;
    }
    auto& low_0 = low[first];
    auto& low_1 = low[first + step];
    auto& low_2 = low[first + 2 * step];
    const auto& high_0 = high[first];
    const auto& high_1 = high[first + step];
    const auto& high_2 = high[first + 2 * step];
#pragma omp simd
    for (std::size_t i = 0; i < lanes; ++i) {
      const float one = first_moment(low_0[i], low_1[i], high_0[i], high_1[i]);
      const float two = second_moment(low_0[i], low_1[i], low_2[i], high_0[i], high_1[i], high_2[i]);
      low_0[i] = low_0[i] + high_0[i];
      low_1[i] = one;
      low_2[i] = two;
    }
  }
}

/// Where the eight sites of the cells of a row have one modulus: that, else 0. Sites x ... x + lanes + 1 of
/// the part.
float one_modulus(const ModuliAround& moduli, int x, int y, int z) {
  const Extent sites = moduli.whole.extent;
  x += moduli.first[0];
  y += moduli.first[1];
  z += moduli.first[2];
  if (x < 0 || y < 0 || z < 0 || x + static_cast<int>(lanes) + 1 >= sites.width || y + 1 >= sites.height ||
      z + 1 >= sites.depth) {
    return 0.0F;
  }
  const float* const at = moduli.whole.values.data() + sites.index(x, y, z);
  const float modulus = *at;
  const std::size_t below = sites.index(0, 1, 0);
  const std::size_t behind = sites.index(0, 0, 1);
  bool same = true;
  for (const std::size_t row : {std::size_t{0}, below, behind, below + behind}) {
    const float* const site = at + row;
    for (std::size_t i = 0; i < lanes + 2; ++i) {
      same &= site[i] == modulus;
    }
  }
  return same ? modulus : 0.0F;
}

/// The stiffness of sites side by side: symmetric_entry() of 3 x 3.
using Stiffness = std::array<std::array<float, lanes>, 6>;

/// Adds what cell i + shift does to its corner at (a, b, c), each -1 or +1, which is site i. A function of
/// its own, so that the loop over sites becomes one of vectors.
HDM_FUNCTION void add_corner(Stiffness& sum, const CellRow& cells, std::size_t i, std::size_t shift, float a,
                             float b, float c, const ElasticRatios<float>& ratio) {
  const auto cell = [&](std::size_t p, std::size_t q, std::size_t r)
                        HDM_INLINED { return cells[p + 3 * q + 9 * r][i + shift]; };
  // Means of modulus * (1 + b s)^2 (1 + c t)^2 and so on.
  const auto square = [](const auto& m, float first, float second) HDM_INLINED {
    return (m(0, 0) + 2.0F * first * m(1, 0) + m(2, 0)) +
           2.0F * second * (m(0, 1) + 2.0F * first * m(1, 1) + m(2, 1)) +
           (m(0, 2) + 2.0F * first * m(1, 2) + m(2, 2));
  };
  // Of modulus * (a + r) (b + s) (1 + c t)^2 and so on.
  const auto across = [](const auto& m, float first, float second, float third) HDM_INLINED {
    const auto of = [&](std::size_t power) HDM_INLINED {
      return m(0, 0, power) + first * m(1, 0, power) + second * (m(0, 1, power) + first * m(1, 1, power));
    };
    return first * second * ((of(0) + 2.0F * third * of(1)) + of(2));
  };
  const float xx = square([&](std::size_t p, std::size_t q) HDM_INLINED { return cell(0, p, q); }, b, c);
  const float yy = ratio.y * ratio.y *
                   square([&](std::size_t p, std::size_t q) HDM_INLINED { return cell(p, 0, q); }, a, c);
  const float zz = ratio.z * ratio.z *
                   square([&](std::size_t p, std::size_t q) HDM_INLINED { return cell(p, q, 0); }, a, b);
  const float xy = across(cell, a, b, c);
  const float xz =
      across([&](std::size_t p, std::size_t q, std::size_t r) HDM_INLINED { return cell(p, r, q); }, a, c, b);
  const float yz =
      across([&](std::size_t p, std::size_t q, std::size_t r) HDM_INLINED { return cell(r, p, q); }, b, c, a);
  sum[0][i] += (2.0F + ratio.lame) * xx + (yy + zz);
  sum[1][i] += (1.0F + ratio.lame) * (ratio.y * xy);
  sum[2][i] += (1.0F + ratio.lame) * (ratio.z * xz);
  sum[3][i] += (2.0F + ratio.lame) * yy + (xx + zz);
  sum[4][i] += (1.0F + ratio.lame) * (ratio.y * ratio.z * yz);
  sum[5][i] += (2.0F + ratio.lame) * zz + (xx + yy);
}

HDM_FUNCTION void add_corners(Stiffness& sum, const CellRow& cells, std::size_t shift, float a, float b,
                              float c, const ElasticRatios<float>& given) {
  const ElasticRatios<float> ratio = given; // nothing that is written can change it
#pragma omp simd
  for (std::size_t i = 0; i < lanes; ++i) {
    add_corner(sum, cells, i, shift, a, b, c, ratio);
  }
}

/// What cells of more than one modulus count.
struct WeightOfCells {
  const VolumeRelaxation& relaxation;
  const ModuliAround& moduli;
  std::array<int, 3> whole; ///< so many cells along each axis do not stick out

  float operator()(int x, int y, int z) const {
    return x < whole[0] && y < whole[1] && z < whole[2] ? relaxation.weight : relaxation.weight_beyond;
  }
};

/// Cells x, x + 1, ... of more than one modulus count weight(x, y, z) times. Their odd moments tell; on
/// coarse levels a cell that is alike on both sides, as with a stiff line along its middle, has none, and
/// its squares tell.
HDM_FUNCTION void weigh_mixed(CellRow& cells, int x, int y, int z, bool is_image,
                              const WeightOfCells& weight) {
  std::array<float, lanes + 1> weights;
  std::array<float, lanes + 1> factor;
  factor.fill(1.0F);
  for (std::size_t i = 0; i <= lanes; ++i) {
    weights[i] = weight(x + static_cast<int>(i), y, z);
  }
  for (const std::size_t place : odd_places) {
    for (std::size_t i = 0; i <= lanes; ++i) {
      factor[i] = cells[place][i] != 0.0F ? weights[i] : factor[i];
    }
  }
  for (std::size_t n = 0; !is_image && n < even_places.size(); ++n) {
    const float share = n < 3 ? 1.0F / 3.0F : 1.0F / 9.0F;
    constexpr float most = 0.5F; // a line of ten times the modulus has more; what has less needs no weight
    for (std::size_t i = 0; i <= lanes; ++i) {
      const float uniform = share * cells[0][i];
      const bool differs = std::abs(cells[even_places[n]][i] - uniform) > most * uniform;
      factor[i] = differs ? weights[i] : factor[i];
    }
  }
  for (auto& row : cells) {
    for (std::size_t i = 0; i <= lanes; ++i) {
      row[i] *= factor[i];
    }
  }
}

/// The stiffness of sites x, x + 1, ... of row (y, z), masked cells left out.
HDM_FUNCTION Stiffness stiffness_of(const ElasticLevel& level, int x, int y, int z,
                                    const WeightOfCells& weight) {
  Stiffness sum{};
  if (level.moments.size() == 1) {
    const auto of_cells = [&](int above, int near) {
      return one_modulus(weight.moduli, x - 1, y - 1 + above, z - 1 + near);
    };
    const float modulus = of_cells(0, 0);
    if (modulus != 0.0F && modulus == of_cells(0, 1) && modulus == of_cells(1, 0) &&
        modulus == of_cells(1, 1)) {
      const double lame = double{weight.relaxation.ratio.lame};
      const std::array<double, 3> squares{1.0, std::pow(double{weight.relaxation.ratio.y}, 2.0),
                                          std::pow(double{weight.relaxation.ratio.z}, 2.0)};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double times = (1.0 + lame) * squares[axis] + (squares[0] + squares[1] + squares[2]);
        sum[symmetric_entry(3, axis, axis)].fill(8.0F * 16.0F / 9.0F * static_cast<float>(times) * modulus);
      }
      return sum;
    }
  }
  CellRow cells;
  for (int row = 0; row < 4; ++row) {
    const int above = row % 2;
    const int near = row / 2;
    read_cells(level, x - 1, 1, y - 1 + above, z - 1 + near, cells);
    weigh_mixed(cells, x - 1, y - 1 + above, z - 1 + near, level.moments.size() == 1, weight);
    const float b = above == 0 ? 1.0F : -1.0F;
    const float c = near == 0 ? 1.0F : -1.0F;
    add_corners(sum, cells, 0, 1.0F, b, c, weight.relaxation.ratio);
    add_corners(sum, cells, 1, -1.0F, b, c, weight.relaxation.ratio);
  }
  return sum;
}

/// Puts the stiffness of the sites of row (y, z) where their response will be.
HDM_WIDE_VECTORS void set_stiffness(ElasticLevel& level, int y, int z, const WeightOfCells& weight) {
  const std::size_t row = level.grid.index(0, y, z);
  const int width = level.grid.sites.width;
  constexpr int together = static_cast<int>(lanes);
  for (int x = -(weight.moduli.first[0] % together); x < width; x += together) {
    const Stiffness sum = stiffness_of(level, x, y, z, weight);
    const int before = std::max(0, -x); // sites of a part that it does not have
    const int count = std::min(together, width - x) - before;
    for (std::size_t entry = 0; entry < 6; ++entry) {
      std::copy_n(sum[entry].data() + before, count, level.response[entry].data() + row + (x + before));
    }
  }
}

/// Rows of a level's response, and where components are prescribed.
struct ResponseOfRow {
  std::array<float*, 6> entries;
  std::array<const std::uint8_t*, 3> held;
};

/// Makes the response of a site from its stiffness, which lies where it will. A function of its own, so that
/// the loop over sites becomes one of vectors.
HDM_FUNCTION void respond_at(const ResponseOfRow& row, std::size_t i, float factor) {
  const auto free = [&](std::size_t axis) HDM_INLINED { return static_cast<float>(1 - row.held[axis][i]); };
  const std::array own{free(0) * row.entries[0][i], free(1) * row.entries[3][i], free(2) * row.entries[5][i]};
  const float scale = power_to_one(std::max(std::max(own[0], own[1]), own[2]));
  const auto inverse =
      inverse_of_symmetric(std::array{scale * own[0], scale * row.entries[1][i], scale * row.entries[2][i],
                                      scale * own[1], scale * row.entries[4][i], scale * own[2]});
  for (std::size_t entry = 0; entry < 6; ++entry) {
    row.entries[entry][i] = scale * (factor * inverse[entry]);
  }
}

HDM_WIDE_VECTORS void respond(ElasticLevel& level, std::size_t first, std::size_t count,
                              const Prescribed& prescribed, float factor) {
  ResponseOfRow row;
  std::ranges::transform(level.response, row.entries.begin(),
                         [&](auto& entry) { return entry.data() + first; });
  std::ranges::transform(prescribed.component, row.held.begin(),
                         [&](auto& component) { return component.data() + first; });
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) {
    respond_at(row, i, factor);
  }
}

/// Sets the moments of row (y, z) of cells from those of their children.
HDM_WIDE_VECTORS void set_parents(ElasticLevel& level, const ElasticLevel& fine, int y, int z) {
  const Extent cells = level.grid.cells();
  const auto [along_x, along_y, along_z] = level.stride;
  const float share = along_x == 2 ? 0.25F : 1.0F; // slopes along x are over the side along x
  std::array<CellRow, 8> children;
  for (int x = 0; x < cells.width; x += static_cast<int>(lanes)) {
    const auto is_child = [&](std::size_t child, std::size_t axis) {
      return level.stride[axis] == 2 || (child >> axis & 1) == 0;
    };
    for (std::size_t child = 0; child < 8; ++child) {
      const auto bit = [&](std::size_t axis) { return static_cast<int>(child >> axis & 1); };
      if (is_child(child, 0) && is_child(child, 1) && is_child(child, 2)) {
        read_cells(fine, along_x * x + bit(0), along_x, along_y * y + bit(1), along_z * z + bit(2),
                   children[child]);
      }
    }
    for (std::size_t axis = 0, step = 1; axis < 3; ++axis, step *= 3) {
      for (std::size_t child = 0; level.stride[axis] == 2 && child < 8; child += std::size_t{2} << axis) {
        join(children[child], children[child + (std::size_t{1} << axis)], step);
      }
    }
    const auto count = static_cast<std::size_t>(std::min(static_cast<int>(lanes), cells.width - x));
    for (std::size_t number = 0; number < moment_count; ++number) {
      const float* const from = children[0][place_of_moment[number]].data();
      float* const to = level.moments[number].data() + level.grid.index(x, y, z);
      for (std::size_t i = 0; i < count; ++i) {
        to[i] =
            share * from[i]; // of eight cells twice the mean: a factor of 2 a level keeps the form of forces
      }
    }
  }
}

} // namespace

void set_volume_moments(ElasticLevel& image, const Level& full) {
  const Extent sites = full.extent;
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
  for (int z = 0; z < sites.depth; ++z) {
    for (int y = 0; y < sites.height; ++y) {
      std::copy_n(full.modulus.values.data() + sites.index(0, y, z), sites.width,
                  image.moments[0].data() + image.grid.index(0, y, z));
    }
  }
}

void set_volume_parents(ElasticLevel& level, const ElasticLevel& fine) {
  const Extent cells = level.grid.cells();
#pragma omp parallel for schedule(dynamic) if (level.grid.sites.sites() > sites_worth_threads / 8)
  for (int z = 0; z < cells.depth; ++z) {
    for (int y = 0; y < cells.height; ++y) {
      set_parents(level, fine, y, z);
    }
  }
}

void set_volume_response(ElasticLevel& level, const VolumeRelaxation& relaxation, const ModuliAround& moduli,
                         const std::array<int, 3>& whole, const Prescribed& prescribed) {
  const RingedGrid& grid = level.grid;
  const WeightOfCells weight{relaxation, moduli, whole};
#pragma omp parallel for schedule(dynamic) if (grid.sites.sites() > sites_worth_threads / 8)
  for (int z = 0; z < grid.sites.depth; ++z) {
    for (int y = 0; y < grid.sites.height; ++y) {
      set_stiffness(level, y, z, weight);
      add_masked_cells(level, y, z, weight);
      respond(level, grid.index(0, y, z), static_cast<std::size_t>(grid.sites.width), prescribed,
              relaxation.factor);
    }
  }
}

} // namespace hdmbench
