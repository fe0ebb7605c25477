#include "harness/solve/methods/residual.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace hdmbench {

namespace {

/// Which sides of a part of a row are inside the image.
struct Inside {
  bool west;
  bool east;
  bool north;
  bool south;
};

/// What the sites of row y see in each direction, each at index x of the centre.
template <typename Value>
std::array<const Value*, 9> neighbours(const std::vector<Value>& values, Extent extent, int y,
                                       Inside inside) {
  const Value* centre = values.data() + extent.index(0, y);
  const auto at = [&](int dx, int dy) {
    const bool exists = (dx >= 0 || inside.west) && (dx <= 0 || inside.east) && (dy >= 0 || inside.north) &&
                        (dy <= 0 || inside.south);
    return exists ? centre + dx + static_cast<std::ptrdiff_t>(dy) * extent.width : centre;
  };
  return {at(-1, -1), at(0, -1), at(1, -1), at(-1, 0), centre, at(1, 0), at(-1, 1), at(0, 1), at(1, 1)};
}

void evaluate_part(const Energy& energy, const ResidualRow<double>& part, int first, int end) {
  energy.host->residual_of_double(part, first, end);
}

void evaluate_part(const Energy& energy, const ResidualRow<float>& part, int first, int end) {
  energy.host->residual_of_float(part, first, end);
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
  result.row_squares.resize(static_cast<std::size_t>(extent.height));
  std::vector<double> largest(result.row_squares.size());
  const auto row_part = [&](int y, Inside inside) {
    const std::size_t row = extent.index(0, y);
    ResidualRow<typename decltype(Field::x)::value_type> part{
        .dx = neighbours(displacement.x, extent, y, inside),
        .dy = neighbours(displacement.y, extent, y, inside),
        .inverse_modulus = neighbours(inverse_modulus_, extent, y, inside),
        .inputs = {},
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
    for (std::size_t i = 0; i < level_.inputs.size(); ++i) {
      part.inputs[i] = neighbours(level_.inputs[i].values, extent, y, inside);
    }
    return part;
  };
#pragma omp parallel for schedule(static) if (extent.sites() > 4096)
  for (int y = 0; y < extent.height; ++y) {
    const bool north = y > 0;
    const bool south = y + 1 < extent.height;
    const int last = extent.width - 1;
    evaluate_part(*level_.energy, row_part(y, {false, last > 0, north, south}), 0, 1);
    if (last > 0) {
      evaluate_part(*level_.energy, row_part(y, {true, true, north, south}), 1, last);
      evaluate_part(*level_.energy, row_part(y, {true, false, north, south}), last, last + 1);
    }
    const std::size_t row = extent.index(0, y);
    const RowNorms norms =
        row_norms(result.missing.x.data() + row, result.missing.y.data() + row, extent.width);
    result.row_squares[static_cast<std::size_t>(y)] = norms.squares;
    largest[static_cast<std::size_t>(y)] = norms.largest;
  }
  double squares = 0.0;
  result.largest = 0.0;
  for (std::size_t row = 0; row < largest.size(); ++row) {
    squares += result.row_squares[row];
    result.largest = std::max(result.largest, largest[row]);
  }
  result.rms = std::sqrt(squares / static_cast<double>(extent.sites()));
}

} // namespace hdmbench
