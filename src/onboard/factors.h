#pragma once

#include <Eigen/Core>

/// Requests unrolling of the following loop: g++ otherwise vectorises short sums, at twice the
/// cost.
#if defined(__GNUC__) && !defined(__clang__)
#define TWIN_UNROLL _Pragma("GCC unroll 8")
#else
#define TWIN_UNROLL
#endif

namespace twin::onboard::internal {

/// Factors A = L diag(1/d) L^T of a symmetric positive definite matrix, L unit lower triangular.
/// Loops of fixed length: for six and seven rows ten times as fast as Eigen's factorisations, and
/// without a square root.
///
/// Real-time: noexcept, allocates nothing.
template <int n>
struct Factors {
  using Square = Eigen::Matrix<double, n, n, Eigen::RowMajor>;
  using Column = Eigen::Matrix<double, n, 1>;

  Square L;                 ///< below the diagonal; the rest is unset
  Column d;                 ///< inverses of the pivots
  bool is_definite = true;  ///< else the factors are invalid

  /// @param A  its lower triangle is read.
  explicit Factors(const Square& A) noexcept {
    TWIN_UNROLL
    for (int i = 0; i < n; ++i) {
      Column scaled;  // L(i, j) / d(j)
      double pivot = A(i, i);
      TWIN_UNROLL
      for (int j = 0; j < i; ++j) {
        double sum = A(i, j);
        TWIN_UNROLL
        for (int k = 0; k < j; ++k) sum -= scaled[k] * L(j, k);
        scaled[j] = sum;
        L(i, j) = sum * d[j];
        pivot -= sum * L(i, j);
      }
      is_definite = is_definite && pivot > 0;
      d[i] = 1 / pivot;
    }
  }
};

/// The inverse of a symmetric positive definite matrix: A^-1 = U^T diag(d) U, U = L^-1.
///
/// Real-time: noexcept, allocates nothing.
template <int n>
class Inverse {
 public:
  using Square = typename Factors<n>::Square;
  using Column = typename Factors<n>::Column;

  /// @param A  its lower triangle is read.
  explicit Inverse(const Square& A) noexcept : factors_(A) {
    TWIN_UNROLL
    for (int i = 0; i < n; ++i) {
      TWIN_UNROLL
      for (int j = 0; j < i; ++j) {
        double sum = factors_.L(i, j);
        TWIN_UNROLL
        for (int k = j + 1; k < i; ++k) sum += factors_.L(i, k) * U_(k, j);
        U_(i, j) = -sum;
      }
      U_(i, i) = 1;
    }
  }

  /// Whether A was positive definite; else the inverse is invalid.
  [[nodiscard]] bool is_definite() const noexcept { return factors_.is_definite; }

  /// The diagonal of A^-1.
  [[nodiscard]] Column Diagonal() const noexcept {
    Column diagonal = Column::Zero();
    TWIN_UNROLL
    for (int k = 0; k < n; ++k) {
      TWIN_UNROLL
      for (int j = 0; j <= k; ++j) diagonal[j] += factors_.d[k] * U_(k, j) * U_(k, j);
    }
    return diagonal;
  }

  /// A^-1 x.
  [[nodiscard]] Column Times(const Column& x) const noexcept {
    Column y = Column::Zero();
    TWIN_UNROLL
    for (int k = 0; k < n; ++k) {
      double sum = 0;
      TWIN_UNROLL
      for (int j = 0; j <= k; ++j) sum += U_(k, j) * x[j];
      TWIN_UNROLL
      for (int j = 0; j <= k; ++j) y[j] += factors_.d[k] * sum * U_(k, j);
    }
    return y;
  }

 private:
  Factors<n> factors_;
  Square U_;  // on and below the diagonal
};

}  // namespace twin::onboard::internal
