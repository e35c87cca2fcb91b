#include "support/dense.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

// Products are lazy, the singular values those of a square: Eigen's code for large products and for
// what is not square is much to compile, and of no use here.
namespace twin::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Svd = Eigen::JacobiSVD<MatrixXd, Eigen::NoQRPreconditioner>;

/// A with zeros below or beside it until it is square: they add singular values of zero.
MatrixXd Squared(const MatrixXd& A) {
  const Eigen::Index n = std::max(A.rows(), A.cols());
  MatrixXd square = MatrixXd::Zero(n, n);
  square.topLeftCorner(A.rows(), A.cols()) = A;
  return square;
}

}  // namespace

VectorXd SingularValues(const MatrixXd& A) {
  return Svd(Squared(A)).singularValues().head(std::min(A.rows(), A.cols()));
}

VectorXd LeastSquares(const MatrixXd& A, const VectorXd& b) {
  const Svd svd(Squared(A), Eigen::ComputeFullU | Eigen::ComputeFullV);
  VectorXd scaled = svd.matrixU().topRows(b.size()).transpose().lazyProduct(b);
  for (Eigen::Index i = 0; i < scaled.size(); ++i) {
    scaled[i] = i < svd.rank() ? scaled[i] / svd.singularValues()[i] : 0;
  }
  return svd.matrixV().topRows(A.cols()).lazyProduct(scaled);
}

VectorXd DampedLeastSquares(const MatrixXd& A, const VectorXd& b, double damping) {
  MatrixXd square = A.lazyProduct(A.transpose());
  square.diagonal().array() += damping;
  return A.transpose().lazyProduct(Solve(square, b));
}

VectorXd NullVector(const MatrixXd& A) {
  return Svd(Squared(A), Eigen::ComputeFullV).matrixV().rightCols<1>();
}

VectorXd Solve(const MatrixXd& A, const VectorXd& b) {
  return A.ldlt().solve(b);
}

bool IsPositiveDefinite(const MatrixXd& A) {
  return A.ldlt().vectorD().minCoeff() > 0;
}

VectorXd TaskForce(const MatrixXd& M, const MatrixXd& J, const VectorXd& tau) {
  MatrixXd weighted(J.cols(), J.rows());  // M^-1 J^T
  for (Eigen::Index i = 0; i < J.rows(); ++i) weighted.col(i) = Solve(M, J.row(i).transpose());
  return Solve(J.lazyProduct(weighted), weighted.transpose().lazyProduct(tau));
}

}  // namespace twin::test
