#include "reference/thesis_icm.hpp"

#include "kernels/data/input_error.hpp"
#include "reference/sparse_solver.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace hdmbench {

namespace {

/// What a triple s - t - u of one component needs, for every site t of a row: displacements of s and u, and
/// m_t / m_s, m_t / m_u.
struct Triples {
  explicit Triples(std::size_t width) : ds(width), du(width), k(width), r(width) {}

  std::vector<double> ds;
  std::vector<double> du;
  std::vector<double> k;
  std::vector<double> r;
};

/// One row of one component.
struct Row {
  explicit Row(std::size_t width) : triples{Triples(width), Triples(width), Triples(width)}, energy(width) {}

  std::array<Triples, 3> triples;
  std::vector<double> energy; ///< lowest so far
};

struct Offset {
  int x;
  int y;
};

/// Fills the triples of row y along `to`, the way from t to u. A neighbour outside the image has the
/// displacement and the modulus of t.
void gather(const Level& level, const std::vector<double>& displacement, int y, Offset to, Triples& triples) {
  const Extent extent = level.extent;
  const std::vector<float>& modulus = level.modulus.values;
  const auto neighbour = [&](int x, int dx, int dy) {
    const bool inside = x + dx >= 0 && x + dx < extent.width && y + dy >= 0 && y + dy < extent.height;
    return inside ? extent.index(x + dx, y + dy) : extent.index(x, y);
  };
  for (int x = 0; x < extent.width; ++x) {
    const std::size_t s = neighbour(x, -to.x, -to.y);
    const std::size_t u = neighbour(x, to.x, to.y);
    const auto i = static_cast<std::size_t>(x);
    const double mt = static_cast<double>(modulus[extent.index(x, y)]);
    triples.ds[i] = displacement[s];
    triples.du[i] = displacement[u];
    triples.k[i] = mt / static_cast<double>(modulus[s]);
    triples.r[i] = mt / static_cast<double>(modulus[u]);
  }
}

double square(double value) {
  return value * value;
}

/// (4.7) of one triple with d_t.
inline double potential(const Triples& triples, std::size_t i, double dt) {
  return square(triples.r[i] * (dt - triples.ds[i]) - (triples.du[i] - dt)) +
         square(triples.k[i] * (dt - triples.du[i]) - (triples.ds[i] - dt));
}

/// One row of one component: `to` becomes `from` plus the first step of the lowest energy. Confidence and
/// target begin at the row.
void choose_steps(const Level& level, Row& row, const double* from, const float* target,
                  const float* confidence, double* to) {
  const std::size_t width = row.energy.size();
  const double penalty = static_cast<double>(level.penalty);
  const auto try_step = [&](float step, auto is_first) {
#pragma omp simd
    for (std::size_t i = 0; i < width; ++i) {
      const double candidate = from[i] + static_cast<double>(step);
      const double energy =
          potential(row.triples[0], i, candidate) + potential(row.triples[1], i, candidate) +
          potential(row.triples[2], i, candidate) +
          penalty * static_cast<double>(confidence[i]) * std::abs(static_cast<double>(target[i]) - candidate);
      const bool better = is_first() || energy < row.energy[i];
      row.energy[i] = better ? energy : row.energy[i];
      to[i] = better ? candidate : to[i];
    }
  };
  const auto steps = level.steps.values();
  try_step(steps.front(), [] { return true; });
  for (const float step : steps.subspan(1)) {
    try_step(step, [] { return false; });
  }
}

void require_extent(const ReferenceField& field, Extent extent) {
  if (field.extent != extent || field.x.size() != extent.sites() || field.y.size() != extent.sites()) {
    throw InputError(fmt::format("the displacement is {} x {}, the level is {} x {}", field.extent.width,
                                 field.extent.height, extent.width, extent.height));
  }
}

/// The values of the sites of an axis from those of the coarser level.
SparseMatrix interpolation(int coarse, int fine, Alignment alignment) {
  std::vector<Eigen::Triplet<double, std::int64_t>> weights;
  for (int i = 0; i < fine; ++i) {
    double position = 0.0;
    if (alignment == Alignment::center) {
      position = (static_cast<double>(i) + 0.5) * coarse / fine - 0.5;
    } else if (fine > 1) {
      position = static_cast<double>(i) * (coarse - 1) / (fine - 1);
    }
    position = std::clamp(position, 0.0, static_cast<double>(coarse - 1));
    const int first = static_cast<int>(position);
    weights.emplace_back(i, first, 1.0 - (position - first));
    weights.emplace_back(i, std::min(first + 1, coarse - 1), position - first);
  }
  SparseMatrix result(fine, coarse);
  result.setFromTriplets(weights.begin(), weights.end());
  return result;
}

} // namespace

ReferenceField thesis_iteration(const Level& level, const ReferenceField& displacement) {
  validate(level);
  require_extent(displacement, level.extent);
  constexpr std::array<Offset, 3> triples_of_x{{{1, 0}, {1, 1}, {1, -1}}};
  constexpr std::array<Offset, 3> triples_of_y{{{0, 1}, {1, 1}, {1, -1}}};
  ReferenceField next(level.extent);
#pragma omp parallel
  {
    Row row(static_cast<std::size_t>(level.extent.width));
    const auto update = [&](int y, const std::array<Offset, 3>& triples, const std::vector<double>& from,
                            const std::vector<float>& target, const std::vector<float>& confidence,
                            std::vector<double>& to) {
      for (std::size_t i = 0; i < 3; ++i) {
        gather(level, from, y, triples[i], row.triples[i]);
      }
      const std::size_t begin = level.extent.index(0, y);
      choose_steps(level, row, from.data() + begin, target.data() + begin, confidence.data() + begin,
                   to.data() + begin);
    };
#pragma omp for schedule(static)
    for (int y = 0; y < level.extent.height; ++y) {
      update(y, triples_of_x, displacement.x, level.target.x, level.confidence.x, next.x);
      update(y, triples_of_y, displacement.y, level.target.y, level.confidence.y, next.y);
    }
  }
  return next;
}

ReferenceField thesis_prolongation(const ReferenceField& coarse, Extent fine, Alignment alignment) {
  require_extent(coarse, coarse.extent);
  if (std::min({coarse.extent.width, coarse.extent.height, fine.width, fine.height}) < 1) {
    throw InputError("a displacement cannot be interpolated from or to an image without pixels");
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const SparseMatrix across = interpolation(coarse.extent.width, fine.width, alignment);
  const SparseMatrix down = interpolation(coarse.extent.height, fine.height, alignment);
  ReferenceField result(fine);
  const auto interpolate = [&](const std::vector<double>& from, std::vector<double>& to) {
    const Rows wide =
        Eigen::Map<const Rows>(from.data(), coarse.extent.height, coarse.extent.width) * across.transpose();
    Eigen::Map<Rows>(to.data(), fine.height, fine.width) = down * wide;
  };
  interpolate(coarse.x, result.x);
  interpolate(coarse.y, result.y);
  return result;
}

} // namespace hdmbench
