#include "harness/solve/methods/remaining_error.hpp"

#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/modulus.hpp"

#include <Eigen/Eigenvalues>

namespace hdmbench {

void SmallestEigenvalue::add(double factor, double product) {
  if (!(factor > 0.0)) { // a cycle by itself
    return;
  }
  const double share = product_ > 0.0 ? product / product_ : 0.0;
  if (factor_ > 0.0) {
    beside_.push_back(std::sqrt(share) / factor_);
  }
  diagonal_.push_back(1.0 / factor + (factor_ > 0.0 ? share / factor_ : 0.0));
  factor_ = factor;
  product_ = product;
  const auto vector = [](const std::vector<double>& values) {
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  };
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(vector(diagonal_), vector(beside_), Eigen::EigenvaluesOnly);
  before_ = diagonal_.size() > 1 ? value_ : std::numeric_limits<double>::infinity();
  // Rounding can bring it to 0 or below, where nothing is left to be seen.
  value_ = std::max(solver.eigenvalues()[0], 1e-12);
}

namespace {

/// Levels are made coarser along short sides first (stride_of()): what is left of the ratio then.
double oblong_below(double longest_side) {
  while (longest_side > 2.0) {
    longest_side /= 2.0;
  }
  return longest_side;
}

/// Returns the stiffest tissue over the softest one that is not void, by which nothing is transmitted.
double contrast_of_tissue(const Level& level) {
  const float least = void_modulus(level);
  float softest = std::numeric_limits<float>::max();
  float stiffest = 0.0F;
  for (const float modulus : level.modulus.values) {
    softest = modulus >= least ? std::min(softest, modulus) : softest;
    stiffest = std::max(stiffest, modulus);
  }
  return double{stiffest} / double{softest};
}

/// Returns what steps have to bring together: tissues, or a wall and its tissue.
double contrast_of_steps(const Level& level) {
  const double of_walls = has_springs_by_direction(level) ? double{stiffness_of_walls} : 1.0;
  return std::max(contrast_of_tissue(level), of_walls);
}

/// Returns the contrast that margins go by, of the moduli or what moves as late.
double effective_contrast(const Level& level, bool is_cut) {
  constexpr double of_void = 1e4;
  constexpr double of_observations = 100.0; // what lies between them
  const double here = is_cut ? of_void : has_springs(level) && !level.has_walls ? of_observations : 1.0;
  return std::max(contrast_of_tissue(level), here);
}

} // namespace

RemainingError::RemainingError(const Level& level)
    : contrast_(contrast_of_steps(level)), oblong_(oblong_below(std::ranges::max(level.sides))),
      mistrust_(floating_part(level)), is_cut_(is_cut_by_void(level)),
      is_slender_(slenderness(level) > most_compact),
      is_free_(has_springs(level) && !free_motions(level).empty()), is_loose_(is_loose_in_walls(level)) {
  if (!mistrust_.empty()) {
    mistrust_ = "float32 cannot tell how a part of the tissue moves, " + mistrust_;
  }
}

LeftByCycles::LeftByCycles(const Level& level, double slowest)
    : slides_(level.has_walls), is_loose_(is_loose_in_walls(level)), is_cut_(is_cut_by_void(level)),
      is_slender_(slenderness(level) > most_compact_by_laws), contrast_(effective_contrast(level, is_cut_)),
      slowest_before_(contrast_ > 10.0 ? slowest : 1.0) {}

} // namespace hdmbench
