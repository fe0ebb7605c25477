#pragma once

#include <Eigen/SparseCore>

#include <cstdint>
#include <optional>

namespace hdmbench {

/// 64-bit indices: the factors of a 1200 x 1200 image have more than 2^28 entries.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;

// Direct factorisations: CHOLMOD's supernodal LL' and UMFPACK's LU where the build has them
// (HDMBENCH_SUITESPARSE), else Eigen's simplicial LL' and LU, several times slower on large images. Nothing
// where the matrix is singular to working precision.

/// Solves for a symmetric positive definite matrix, of which the lower triangle is given; nothing for any
/// other.
[[nodiscard]] std::optional<Eigen::VectorXd> solve_symmetric(const SparseMatrix& lower,
                                                             const Eigen::VectorXd& right_side);
/// Solves for any square matrix.
[[nodiscard]] std::optional<Eigen::VectorXd> solve_general(const SparseMatrix& matrix,
                                                           const Eigen::VectorXd& right_side);
/// Solves for a square matrix of a volume, whose factors would be many times larger than itself, by
/// stabilised biconjugate gradients. Nothing where these do not converge.
[[nodiscard]] std::optional<Eigen::VectorXd> solve_without_factors(const SparseMatrix& matrix,
                                                                   const Eigen::VectorXd& right_side);

} // namespace hdmbench
