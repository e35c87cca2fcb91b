#pragma once

#include <Eigen/Core>

// Linear algebra that expected values are made of, compiled once: each of Eigen's decompositions
// takes whoever makes one 5 to 20 s to compile. All functions allocate.
namespace twin::test {

/// In falling order; as many as A has rows or columns, whichever are fewer.
[[nodiscard]] Eigen::VectorXd SingularValues(const Eigen::MatrixXd& A);

/// Of all x with the least |A x - b| the smallest, by singular values.
[[nodiscard]] Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// The x with the least |A x - b|^2 + damping |x|^2: A^T (A A^T + damping)^-1 b.
[[nodiscard]] Eigen::VectorXd DampedLeastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                                 double damping);

/// The unit vector that A makes zero, A of full rank with one column more than rows. Its sign is
/// whichever.
[[nodiscard]] Eigen::VectorXd NullVector(const Eigen::MatrixXd& A);

/// A^-1 b of a positive definite A.
[[nodiscard]] Eigen::VectorXd Solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Of a symmetric A.
[[nodiscard]] bool IsPositiveDefinite(const Eigen::MatrixXd& A);

/// The task force that accelerates the task J dq as the joint torque does:
///   (J M^-1 J^T)^-1 J M^-1 tau.
[[nodiscard]] Eigen::VectorXd TaskForce(const Eigen::MatrixXd& M, const Eigen::MatrixXd& J,
                                        const Eigen::VectorXd& tau);

}  // namespace twin::test
