#include "harness/methods/residual.hpp"

#include "kernels/energy_macros.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hdmbench {

namespace {

using real = double;

HDM_FUNCTION real abs(real value) {
  return __builtin_fabs(value);
}

HDM_FUNCTION real floor(real value) {
  return __builtin_floor(value);
}

#include "kernels/energy.inc"
#include "kernels/update.inc"

/// The nine values that the sites of a row see, each at index x of the centre.
template <typename Value>
struct NeighbourPointers {
  const Value* north_west;
  const Value* north;
  const Value* north_east;
  const Value* west;
  const Value* centre;
  const Value* east;
  const Value* south_west;
  const Value* south;
  const Value* south_east;
};

/// Which sides of a part of a row are inside the image.
struct Inside {
  bool west;
  bool east;
  bool north;
  bool south;
};

template <typename Value>
NeighbourPointers<Value> neighbours(const std::vector<Value>& values, Extent extent, int y, Inside inside) {
  const Value* centre = values.data() + extent.index(0, y);
  const auto at = [&](int dx, int dy) {
    const bool exists = (dx >= 0 || inside.west) && (dx <= 0 || inside.east) && (dy >= 0 || inside.north) &&
                        (dy <= 0 || inside.south);
    return exists ? centre + dx + static_cast<std::ptrdiff_t>(dy) * extent.width : centre;
  };
  return {at(-1, -1), at(0, -1), at(1, -1), at(-1, 0), centre, at(1, 0), at(-1, 1), at(0, 1), at(1, 1)};
}

template <typename Value>
HDM_FUNCTION Neighbours fetch(const NeighbourPointers<Value>& from, int x) {
  return {from.north_west[x], from.north[x],      from.north_east[x], from.west[x],      from.centre[x],
          from.east[x],       from.south_west[x], from.south[x],      from.south_east[x]};
}

/// Part of a row: columns with the same neighbours inside the image.
template <typename Value>
struct RowPart {
  NeighbourPointers<Value> dx;
  NeighbourPointers<Value> dy;
  NeighbourPointers<double> inverse_modulus;
  const float* modulus;
  const float* target_x;
  const float* target_y;
  const float* confidence_x;
  const float* confidence_y;
  double penalty;
  double* missing_x;
  double* missing_y;
  float* held_x;
  float* held_y;
};

HDM_FUNCTION double minimiser(double centre, double gradient, double curvature, double target,
                              double penalty) {
  return closed_form(centre, gradient, 1.0 / curvature, target, penalty, 1.0);
}

// A function of its own: locals declared inside an `omp simd` loop would become arrays in memory.
template <typename Value>
HDM_FUNCTION void evaluate_site(const RowPart<Value>& part, int x) {
  const Site site{fetch(part.dx, x),
                  fetch(part.dy, x),
                  fetch(part.inverse_modulus, x),
                  part.modulus[x],
                  part.target_x[x],
                  part.target_y[x],
                  part.confidence_x[x],
                  part.confidence_y[x],
                  part.penalty,
                  0.0,
                  0.0};
  const Parabolas prior = prior_parabolas(site);
  const double penalty_x = site.penalty * site.confidence_x;
  const double penalty_y = site.penalty * site.confidence_y;
  const double to_x =
      minimiser(site.dx.centre, prior.gradient_x, prior.curvature_x, site.target_x, penalty_x);
  const double to_y =
      minimiser(site.dy.centre, prior.gradient_y, prior.curvature_y, site.target_y, penalty_y);
  part.missing_x[x] = to_x - site.dx.centre;
  part.missing_y[x] = to_y - site.dy.centre;
  const bool held_x = (penalty_x > 0.0) & (to_x == site.target_x);
  const bool held_y = (penalty_y > 0.0) & (to_y == site.target_y);
  part.held_x[x] = held_x ? 1.0F : 0.0F;
  part.held_y[x] = held_y ? 1.0F : 0.0F;
}

// The same bits with any instruction set: contraction is off. Preset `tsan` defines it to nothing: clones are
// chosen before ThreadSanitizer is ready.
#ifndef HDMBENCH_CLONES
#if defined(__x86_64__) && defined(__gnu_linux__)
#define HDMBENCH_CLONES [[gnu::target_clones("avx512f", "avx2", "default")]]
#else
#define HDMBENCH_CLONES
#endif
#endif

HDMBENCH_CLONES void evaluate_part(const RowPart<double>& part, int first, int end) {
  const RowPart<double> row = part;
#pragma omp simd
  for (int x = first; x < end; ++x) {
    evaluate_site(row, x);
  }
}

HDMBENCH_CLONES void evaluate_part(const RowPart<float>& part, int first, int end) {
  const RowPart<float> row = part;
#pragma omp simd
  for (int x = first; x < end; ++x) {
    evaluate_site(row, x);
  }
}

struct RowNorms {
  double squares = 0.0;
  double largest = 0.0;
};

RowNorms row_norms(const double* x, const double* y, int width) {
  RowNorms norms;
  for (int i = 0; i < width; ++i) {
    norms.squares += x[i] * x[i] + y[i] * y[i];
    norms.largest = std::max({norms.largest, std::abs(x[i]), std::abs(y[i])});
  }
  return norms;
}

} // namespace

Residual::Residual(const Level& level, Observations observations)
    : level_(level),
      penalty_(observations == Observations::counted ? static_cast<double>(level.penalty) : 0.0),
      inverse_modulus_(level.extent.sites()) {
  std::ranges::transform(level.modulus.values, inverse_modulus_.begin(),
                         [](float modulus) { return 1.0 / static_cast<double>(modulus); });
}

void Residual::evaluate(const DoubleField& displacement, ResidualField& result) const {
  evaluate_field(displacement, result);
}

void Residual::evaluate(const VectorField& displacement, ResidualField& result) const {
  evaluate_field(displacement, result);
}

template <typename Field>
void Residual::evaluate_field(const Field& displacement, ResidualField& result) const {
  const Extent extent = level_.extent;
  if (displacement.extent != extent) {
    throw std::logic_error("the residual of a field of another extent than the level's");
  }
  if (result.missing.extent != extent) {
    result.missing = DoubleField(extent);
    result.held = VectorField(extent);
  }
  std::vector<RowNorms> norms(static_cast<std::size_t>(extent.height));
  const auto row_part = [&](int y, Inside inside) {
    const std::size_t row = extent.index(0, y);
    return RowPart<typename decltype(Field::x)::value_type>{
        .dx = neighbours(displacement.x, extent, y, inside),
        .dy = neighbours(displacement.y, extent, y, inside),
        .inverse_modulus = neighbours(inverse_modulus_, extent, y, inside),
        .modulus = level_.modulus.values.data() + row,
        .target_x = level_.target.x.data() + row,
        .target_y = level_.target.y.data() + row,
        .confidence_x = level_.confidence.x.data() + row,
        .confidence_y = level_.confidence.y.data() + row,
        .penalty = penalty_,
        .missing_x = result.missing.x.data() + row,
        .missing_y = result.missing.y.data() + row,
        .held_x = result.held.x.data() + row,
        .held_y = result.held.y.data() + row};
  };
#pragma omp parallel for schedule(static) if (extent.sites() > 4096)
  for (int y = 0; y < extent.height; ++y) {
    const bool north = y > 0;
    const bool south = y + 1 < extent.height;
    const int last = extent.width - 1;
    evaluate_part(row_part(y, {false, last > 0, north, south}), 0, 1);
    if (last > 0) {
      evaluate_part(row_part(y, {true, true, north, south}), 1, last);
      evaluate_part(row_part(y, {true, false, north, south}), last, last + 1);
    }
    const std::size_t row = extent.index(0, y);
    norms[static_cast<std::size_t>(y)] =
        row_norms(result.missing.x.data() + row, result.missing.y.data() + row, extent.width);
  }
  double squares = 0.0;
  result.largest = 0.0;
  for (const RowNorms& row : norms) {
    squares += row.squares;
    result.largest = std::max(result.largest, row.largest);
  }
  result.rms = std::sqrt(squares / static_cast<double>(extent.sites()));
}

} // namespace hdmbench
