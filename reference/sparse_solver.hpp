#pragma once

#include <Eigen/SparseCore>

#include <cstdint>
#include <optional>
#include <string_view>

namespace hdmbench {

/// Who factorises. Both are direct, so their solutions differ by rounding only.
enum class SparseSolver {
  suitesparse, ///< CHOLMOD's supernodal LL', UMFPACK's LU: needs HDMBENCH_SUITESPARSE
  eigen,       ///< Eigen's simplicial LDL' and LU: always there, several times slower on large images
};

/// The faster one this build has.
[[nodiscard]] SparseSolver default_sparse_solver();
[[nodiscard]] bool is_available(SparseSolver solver);
/// "CHOLMOD and UMFPACK", for people.
[[nodiscard]] std::string_view name_of(SparseSolver solver);

/// 64-bit indices: the factors of a 1200 x 1200 image have more than 2^28 entries.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;

/// The solution of a symmetric positive definite system of which the lower triangle is given; nothing where
/// the matrix is singular to working precision or not positive definite. Throws InputError where the solver
/// is not in this build.
[[nodiscard]] std::optional<Eigen::VectorXd>
solve_symmetric(const SparseMatrix& lower, const Eigen::VectorXd& right_side, SparseSolver solver);

/// The same for any square matrix.
[[nodiscard]] std::optional<Eigen::VectorXd>
solve_general(const SparseMatrix& matrix, const Eigen::VectorXd& right_side, SparseSolver solver);

} // namespace hdmbench
