#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace twin::reference {

/// A bounded convex set around the origin of three dimensions: { x : g x <= 1 for every row g }.
///
/// Which rows are needed, which pairs of faces share an edge, and the corners are those of the
/// convex hull of the rows, taken as points: a row is redundant exactly when it lies inside the
/// hull of the others. The hull is Qhull's.
///
/// Threads: constant after construction.
class Polytope {
 public:
  using Rows = std::vector<Eigen::Vector3d>;

  /// @param rows  in any order; redundant ones are left out. @throws std::invalid_argument when the
  /// set is unbounded or flat.
  explicit Polytope(const Rows& rows);

  [[nodiscard]] const Rows& rows() const noexcept { return rows_; }
  [[nodiscard]] const Rows& corners() const noexcept { return corners_; }
  /// Pairs of rows whose faces share an edge; and, where more than three faces meet in a corner,
  /// some that share but the corner.
  [[nodiscard]] const std::vector<std::pair<std::size_t, std::size_t>>& edges() const noexcept {
    return edges_;
  }

  /// The most by which a row is broken, max g x - 1: negative inside, zero on the border.
  [[nodiscard]] double Excess(const Eigen::Vector3d& x) const noexcept;

  /// The t for which x + t d is in the set, first and last; first > last when the line misses it.
  [[nodiscard]] std::pair<double, double> Chord(const Eigen::Vector3d& x,
                                                const Eigen::Vector3d& d) const noexcept;

 private:
  Rows rows_;
  Rows corners_;
  std::vector<std::pair<std::size_t, std::size_t>> edges_;
};

/// The states from which one step leads into a set: { x : A x + b u in the set for a u in [-1, 1]
/// }.
///
/// Fourier-Motzkin elimination of u: each row gives one with the ends of u, and each pair of rows
/// that bound u from different sides gives one without it. Of the pairs, those whose faces share an
/// edge are enough: the set is that of sums of a point of the polytope and one of the segment -b u,
/// whose faces are those of the polytope, moved, and its edges, swept along the segment.
/// @returns rows, redundant ones among them.
[[nodiscard]] Polytope::Rows RowsBefore(const Polytope& set, const Eigen::Matrix3d& A,
                                        const Eigen::Vector3d& b);

}  // namespace twin::reference
