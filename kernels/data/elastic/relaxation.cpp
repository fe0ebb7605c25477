#include "kernels/data/elastic/set_up.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace hdmbench {

namespace {

template <typename Cell>
CellMatrix image_matrix(const std::array<double, std::size_t{1} << Cell::axes>& moduli,
                        const ElasticRatios<double>& ratio, double bend) {
  const auto corners = Cell::corners_of([&](std::size_t corner) { return moduli[corner]; });
  if constexpr (Cell::axes == 3) {
    return matrix_of(Cell::image_cell(corners, bend), ratio);
  } else {
    return matrix_of(Cell::image_cell(corners), ratio);
  }
}

/// Returns the largest eigenvalue of D^-1 K of a cell of the image whose corners have these moduli, by power
/// iteration: D is what K, integrated in full, has on the diagonal in blocks of a corner. No sweep over many
/// cells has a larger one. `bend` as ElasticLevel has it.
template <typename Cell>
double largest_eigenvalue(const std::array<double, std::size_t{1} << Cell::axes>& moduli,
                          const ElasticRatios<double>& ratio, double bend) {
  constexpr std::size_t axes = Cell::axes;
  constexpr std::size_t corners = std::size_t{1} << axes;
  constexpr std::size_t components = axes * corners;
  const CellMatrix full = image_matrix<Cell>(moduli, ratio, 1.0);
  const CellMatrix matrix = image_matrix<Cell>(moduli, ratio, bend);
  std::array<std::array<double, 6>, corners> inverse;
  for (std::size_t corner = 0; corner < corners; ++corner) {
    std::array<double, 6> block{}; // of an image without a third row
    for (std::size_t a = 0; a < axes; ++a) {
      for (std::size_t b = a; b < axes; ++b) {
        block[symmetric_entry(3, a, b)] = full.at(axes * corner + a, axes * corner + b);
      }
    }
    inverse[corner] = inverse_of_symmetric(block);
  }
  std::array<double, components> vector;
  for (std::size_t i = 0; i < components; ++i) {
    vector[i] = 1.0 + static_cast<double>(i * i % 7) - static_cast<double>(i % 5);
  }
  double norm = 0.0;
  constexpr int rounds = 40;
  for (int round = 0; round < rounds; ++round) {
    std::array<double, components> force{};
    for (std::size_t i = 0; i < components; ++i) {
      for (std::size_t j = 0; j < components; ++j) {
        force[i] += matrix.at(j, i) * vector[j];
      }
    }
    double square = 0.0;
    for (std::size_t i = 0; i < components; ++i) {
      vector[i] = 0.0;
      for (std::size_t axis = 0; axis < axes; ++axis) {
        vector[i] += inverse[i / axes][symmetric_entry(3, i % axes, axis)] * force[i / axes * axes + axis];
      }
      square += vector[i] * vector[i];
    }
    norm = std::sqrt(square);
    for (double& value : vector) {
      value /= norm;
    }
  }
  return norm;
}

/// Returns which of a box's corners may be stiff, a bit each: some but not all, and of those that are each
/// other's reflections one.
std::vector<unsigned> patterns_but_for_reflections() {
  std::vector<unsigned> patterns;
  for (unsigned pattern = 1; pattern < 255; ++pattern) {
    bool is_first = true;
    for (unsigned axes = 1; axes < 8; ++axes) { // along which it is reflected
      unsigned reflected = 0;
      for (unsigned corner = 0; corner < 8; ++corner) {
        reflected |= (pattern >> corner & 1U) << (corner ^ axes);
      }
      is_first &= pattern <= reflected;
    }
    if (is_first) {
      patterns.push_back(pattern);
    }
  }
  return patterns;
}

constexpr double saturating_contrast = 1e6; // beyond it the eigenvalues change no more

} // namespace

VolumeRelaxation::VolumeRelaxation(const ElasticRatios<double>& of, double contrast, double bend)
    : ratio(of.as<float>()) {
  // The stiff corners, a bit each: of cubes all patterns but for turns and reflections.
  const std::vector<unsigned> of_cubes{1,   3,   7,   9,   15,  23,  39,  41,  67,  105,
                                       126, 129, 135, 188, 195, 214, 246, 248, 252, 254};
  const std::vector<unsigned> patterns = of.has_boxes() ? patterns_but_for_reflections() : of_cubes;
  const auto largest = [&](double stiff, double bend_of_cell) {
    double most = 0.0;
#pragma omp parallel for reduction(max : most)
    for (const unsigned pattern : patterns) {
      std::array<double, 8> moduli;
      for (unsigned corner = 0; corner < 8; ++corner) {
        moduli[corner] = (pattern >> corner & 1) != 0 ? stiff : 1.0;
      }
      most = std::max(most, largest_eigenvalue<VolumeCell>(moduli, of, bend_of_cell));
    }
    return most;
  };
  const double uniform = largest_eigenvalue<VolumeCell>({1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0}, of, 1.0);
  constexpr double share_of_limit = 1.9; // a wave grows from 2 on
  factor = static_cast<float>(share_of_limit / uniform);
  const double most = std::min(contrast, saturating_contrast);
  const double of_mixed = contrast > 1.0 ? largest(most, 1.0) : uniform;
  weight = static_cast<float>(
      (bend == 1.0 || contrast <= 1.0 ? of_mixed : std::max(of_mixed, largest(most, bend))) / uniform);
  weight_beyond = static_cast<float>(largest(saturating_contrast, 1.0) / uniform);
}

float image_relaxation(const ElasticRatios<double>& ratio) {
  if (!ratio.has_boxes()) {
    return static_cast<float>(elastic_relaxation);
  }
  constexpr double of_squares = 3.25; // the largest of all
  double largest = of_squares;
  for (unsigned pattern = 0; pattern < 15; ++pattern) { // the stiff corners, a bit each
    std::array<double, 4> moduli;
    for (unsigned corner = 0; corner < 4; ++corner) {
      moduli[corner] = (pattern >> corner & 1) != 0 ? saturating_contrast : 1.0;
    }
    largest = std::max(largest, largest_eigenvalue<ImageCell>(moduli, ratio, 1.0));
  }
  return static_cast<float>(elastic_relaxation * of_squares / largest);
}

} // namespace hdmbench
