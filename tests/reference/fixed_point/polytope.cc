#include "reference/fixed_point/polytope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include <libqhull_r/libqhull_r.h>

namespace twin::reference {
namespace {

/// A convex hull, and Qhull's memory for it.
class Hull {
 public:
  explicit Hull(const Polytope::Rows& points) : points_(points) {
    qh_zero(&qh_, stderr);
    static char options[] = "qhull Qt";  // facets are triangles
    // Qhull changes the points only for options that are not asked for.
    auto* coordinates = const_cast<double*>(points_.front().data());
    failed_ = qh_new_qhull(&qh_, 3, static_cast<int>(points_.size()), coordinates, False, options,
                           nullptr, nullptr) != 0;
  }
  ~Hull() {
    qh_freeqhull(&qh_, !qh_ALL);
    int blocks = 0;
    int bytes = 0;
    qh_memfreeshort(&qh_, &blocks, &bytes);
  }
  Hull(const Hull&) = delete;
  Hull& operator=(const Hull&) = delete;

  [[nodiscard]] bool failed() const { return failed_; }

  /// @param visit  called for each facet, normal n and offset with n x + offset = 0 on it, and the
  /// points at its corners.
  template <typename Visit>
  void ForEachFacet(Visit visit) {
    for (const facetT* facet = qh_.facet_list; facet->next != nullptr; facet = facet->next) {
      std::array<std::size_t, 3> corners{};
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto* vertex = static_cast<const vertexT*>(facet->vertices->e[i].p);
        corners[i] = static_cast<std::size_t>(qh_pointid(&qh_, vertex->point));
      }
      const double* n = facet->normal;
      visit(Eigen::Vector3d(n[0], n[1], n[2]), facet->offset, corners);
    }
  }

 private:
  Polytope::Rows points_;
  qhT qh_{};
  bool failed_ = false;
};

}  // namespace

Polytope::Polytope(const Rows& rows) {
  constexpr std::size_t kFewest = 4;
  if (rows.size() < kFewest) throw std::invalid_argument("polytope: fewer than four rows");
  Hull hull(rows);
  if (hull.failed()) throw std::invalid_argument("polytope: these rows have no hull");
  constexpr std::size_t kRedundant = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> index(rows.size(), kRedundant);
  hull.ForEachFacet(
      [&](const Eigen::Vector3d& normal, double offset, const std::array<std::size_t, 3>& points) {
        constexpr double kFlat = -1e-12;
        if (!(offset < kFlat)) {
          throw std::invalid_argument("polytope: these rows bound no set around the origin");
        }
        corners_.emplace_back(normal / -offset);
        for (const std::size_t row : points) {
          if (index[row] != kRedundant) continue;
          index[row] = rows_.size();
          rows_.push_back(rows[row]);
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
          edges_.push_back(std::minmax(index[points[i]], index[points[(i + 1) % points.size()]]));
        }
      });
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
}

double Polytope::Excess(const Eigen::Vector3d& x) const noexcept {
  double most = -1;
  for (const Eigen::Vector3d& g : rows_) most = std::max(most, g.dot(x) - 1);
  return most;
}

std::pair<double, double> Polytope::Chord(const Eigen::Vector3d& x,
                                          const Eigen::Vector3d& d) const noexcept {
  double first = -std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& g : rows_) {
    const double rate = g.dot(d);
    const double slack = 1 - g.dot(x);
    if (rate > 0) {
      last = std::min(last, slack / rate);
    } else if (rate < 0) {
      first = std::max(first, slack / rate);
    } else if (slack < 0) {
      return {1, 0};
    }
  }
  return {first, last};
}

Polytope::Rows RowsBefore(const Polytope& set, const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  Polytope::Rows rows;
  rows.reserve(2 * set.rows().size());
  for (const Eigen::Vector3d& g : set.rows()) {
    rows.emplace_back(A.transpose() * g / (1 + std::abs(g.dot(b))));
  }
  for (const auto& [first, second] : set.edges()) {
    const Eigen::Vector3d& g = set.rows()[first];
    const Eigen::Vector3d& h = set.rows()[second];
    const double from_above = g.dot(b);
    const double from_below = h.dot(b);
    if (from_above * from_below >= 0) continue;
    const double share = std::abs(from_below) / (std::abs(from_above) + std::abs(from_below));
    rows.emplace_back(A.transpose() * (share * g + (1 - share) * h));
  }
  return rows;
}

}  // namespace twin::reference
