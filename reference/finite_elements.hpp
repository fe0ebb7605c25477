#pragma once

#include "kernels/data/modulus.hpp"
#include "reference/finite_elements.hpp"
#include "reference/interpolation.hpp"
#include "reference/sparse_solver.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace hdmbench {

/// A place or a vector along x, y and z, in pixels or voxels; z is 0 in an image.
using Point = std::array<double, 3>;
/// Returns where a site lies whose pixels have such sides.
[[nodiscard]] Point place(Extent extent, std::size_t site, const Point& sides = {1.0, 1.0, 1.0});

/// Where an element is integrated: unit coordinates r, s and t in [-1, 1] as in (A.1)-(A.4), and the weight.
struct QuadraturePoint {
  Point at{};
  std::size_t node = 0; ///< whose modulus it has: bit a is set at the element's upper end along axis a
  double weight = 1.0;
};

/// The physics of a bilinear (Q4) or trilinear (H8) element.
struct ElementRule {
  /// Stress (xx, yy, xy; xx, yy, zz, xy, xz, yz) from strain with engineering shears, for Young's modulus 1.
  Eigen::MatrixXd elasticity;
  /// Pressure by the divergence at an element's centre, which is its mean, for the same modulus; beside
  /// `elasticity`. An element of several moduli has their mean there, but at most twice the softest
  /// (volume.inc).
  double lame_at_centre = 0.0;
  std::vector<QuadraturePoint> points;

  /// Returns for an image plane stress with 2 x 2 Gauss points, -1 < Poisson's ratio <= 0.5, for a volume
  /// isotropic elasticity with 2 x 2 x 2, -1 < Poisson's ratio < 0.5. Throws InputError for other ratios.
  static ElementRule of(Extent extent, const ElasticModel& model);
};

/// A body whose nodes are the sites of a grid: a sheet of rectangular elements between the pixels of an
/// image, or boxes between the voxels of a volume. Every list has a value per node. Energies, forces and
/// springs are over the area or volume of an element.
struct ElasticProblem {
  Extent extent;               ///< nodes, at least 2 along each axis
  std::vector<double> modulus; ///< per node, > 0; a quadrature point has that of the nearest node
  Planes<std::uint8_t> fixed;  ///< not 0 where the component is prescribed
  ReferenceField prescribed;   ///< displacement where fixed, pixels
  ReferenceField force;        ///< load on every node, MPa * pixel * thickness or voxel; may be empty: none
  /// The stiffness of a spring from every node to `prescribed`, MPa * thickness or voxel, >= 0; may be empty:
  /// none. Read where a component is not fixed.
  ReferenceField spring{};
  /// What the spring along one axis does about the way along another: planes for x and y, x and z, y and z.
  ReferenceField spring_across{};
  Point sides{1.0, 1.0, 1.0}; ///< of an element, as Level::sides
  bool has_walls = false;     ///< as Level::has_walls
};

/// call(a, b, stiffness) for the pairs a > b of axes that the spring of a node couples, both of which are
/// free.
template <typename Call>
void for_each_coupled(const ElasticProblem& problem, std::size_t site, const Call& call) {
  const std::size_t axes = problem.extent.axes();
  for (std::size_t a = 1; a < axes && !problem.spring_across[0].empty(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (problem.fixed[a][site] == 0 && problem.fixed[b][site] == 0) {
        call(a, b, problem.spring_across[a + b - 1][site]);
      }
    }
  }
}

/// A body whose outermost nodes are all prescribed, every value a function of the node's place.
/// `prescribed` has the displacement of the nodes inside, too.
[[nodiscard]] ElasticProblem clamped_body(Extent extent, const std::function<double(const Point&)>& modulus,
                                          const std::function<Point(const Point&)>& displacement);

/// The level as an elastic body: observed components prescribed where their confidence is 1, and pulled by
/// springs (kernels/data/elastic/springs.hpp) where it is below.
[[nodiscard]] ElasticProblem elastic_problem(const Level& level);

/// The equations of the components that no condition gives.
struct ElasticSystem {
  SparseMatrix lower; ///< lower triangle of the symmetric positive definite stiffness
  Eigen::VectorXd right_side;
  std::vector<std::int32_t> unknown; ///< row of every component of every node in turn, -1 where prescribed
};

/// Throws InputError as solve_finite_elements does, but for a system without a unique solution.
[[nodiscard]] ElasticSystem assemble(const ElasticProblem& problem, const ElementRule& rule);

/// The displacement of every node in pixels: `solution` of the system, elsewhere what is prescribed.
[[nodiscard]] ReferenceField displacement_of(const ElasticProblem& problem, const ElasticSystem& system,
                                             const Eigen::VectorXd& solution);

/// The displacement of every node in pixels, from a direct factorisation. Throws InputError for less than
/// two nodes along an axis, a modulus that is not above 0 and finite, or conditions that leave the sheet free
/// to move.
[[nodiscard]] ReferenceField solve_finite_elements(const ElasticProblem& problem, const ElementRule& rule);

/// Twice the elastic energy of a displacement, u' K u without loads and that of the springs: without them 0
/// for rigid motion.
template <typename Number>
[[nodiscard]] double elastic_energy(const ElasticProblem& problem, const ElementRule& rule,
                                    const Planes<Number>& displacement);

struct IterativeSolution {
  ReferenceField displacement; ///< pixels
  int iterations = 0;
  double residual = 0.0; ///< |b - K u| / |b| over the unknowns
};

/// The same finite elements by conjugate gradients preconditioned with an incomplete Cholesky factor, from 0
/// until the residual is at most `tolerance` times the right side: what a careful user would set against the
/// direct factorisation where the last digits are not wanted. 0 < tolerance < 1. Throws InputError as
/// solve_finite_elements does, for a tolerance out of range, and where `most_iterations` do not reach it.
[[nodiscard]] IterativeSolution solve_finite_elements_iteratively(const ElasticProblem& problem,
                                                                  const ElementRule& rule, double tolerance,
                                                                  int most_iterations = 20000);

/// Throws InputError where it is not above 0 and below 1.
void require_tolerance(double tolerance);

/// Whether this build has PETSc (-DHDMBENCH_PETSC=ON).
[[nodiscard]] bool has_algebraic_multigrid();

/// The same finite elements by conjugate gradients with smoothed aggregation (PETSc's GAMG, one process) that
/// knows the rigid motions of the body: what a user of a multigrid library would set up. Its own figures
/// are left as they come, but for the smoother: Chebyshev with Jacobi. From 0 until the preconditioned
/// residual is at most `tolerance` times the first one. Throws InputError as
/// solve_finite_elements_iteratively does, and where the build has none.
[[nodiscard]] IterativeSolution solve_finite_elements_by_multigrid(const ElasticProblem& problem,
                                                                   const ElementRule& rule, double tolerance);

} // namespace hdmbench
