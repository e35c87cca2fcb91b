#include "reference/quintic_path.h"

#include "twin/core/error.h"

namespace twin::reference::internal {
namespace {

// A quintic spline with dq = ddq = 0 at its ends is the path through its points with the least E =
// 1/2 integral of jerk^2. With the unknowns x_i = (dq_i, ddq_i) of the inner points, dE/dx_i = 0
// makes snap and jerk continuous there. So the equations
//   C_{i-1}^T x_{i-1} + D_i x_i + C_i x_{i+1} = b_i
// are symmetric positive definite with 2 x 2 blocks, and elimination without pivoting is stable,
// also for points 1 ms apart, as the errors do not depend on the unit of time.

/// Unknowns of one point, or a right-hand side: by component, then joint.
struct Pair {
  JointVector dq{};
  JointVector ddq{};
};

struct Matrix2 {
  double a = 0, b = 0, c = 0, d = 0;  // [a b; c d]
};

Matrix2 Product(const Matrix2& x, const Matrix2& y) {
  return {x.a * y.a + x.b * y.c, x.a * y.b + x.b * y.d, x.c * y.a + x.d * y.c,
          x.c * y.b + x.d * y.d};
}

Matrix2 Inverse(const Matrix2& x) {
  const double determinant = x.a * x.d - x.b * x.c;
  return {x.d / determinant, -x.b / determinant, -x.c / determinant, x.a / determinant};
}

Matrix2 Transposed(const Matrix2& x) {
  return {x.a, x.c, x.b, x.d};
}

Pair Product(const Matrix2& m, const Pair& x) {
  Pair y;
  for (std::size_t j = 0; j < kJoints; ++j) {
    y.dq[j] = m.a * x.dq[j] + m.b * x.ddq[j];
    y.ddq[j] = m.c * x.dq[j] + m.d * x.ddq[j];
  }
  return y;
}

void Subtract(const Pair& x, Pair& from) {
  for (std::size_t j = 0; j < kJoints; ++j) {
    from.dq[j] -= x.dq[j];
    from.ddq[j] -= x.ddq[j];
  }
}

/// D_i of a point between segments of length l and r.
Matrix2 Diagonal(double l, double r) {
  const double cross = 36 / (r * r) - 36 / (l * l);
  return {192 / (l * l * l) + 192 / (r * r * r), cross, cross, 9 / l + 9 / r};
}

/// C_i of a segment of length h.
Matrix2 Coupling(double h) {
  return {168 / (h * h * h), -24 / (h * h), 24 / (h * h), -3 / h};
}

/// b_i of a point between segments of length l and r.
Pair RightHandSide(const JointVector& q_l, const JointVector& q, const JointVector& q_r, double l,
                   double r) {
  Pair b;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double to_left = (q[j] - q_l[j]) / (l * l * l);
    const double to_right = (q_r[j] - q[j]) / (r * r * r);
    b.dq[j] = 360 * (to_right / r + to_left / l);
    b.ddq[j] = 60 * (to_right - to_left);
  }
  return b;
}

/// Velocity and acceleration at all points of a spline without inner stops.
std::vector<Pair> SolveRates(std::span<const Waypoint> points, std::span<const double> lengths_s) {
  std::vector<Pair> x(points.size());          // ends stay zero: at rest
  std::vector<Matrix2> pivots(points.size());  // inverted
  const std::size_t last = points.size() - 1;
  for (std::size_t i = 1; i < last; ++i) {
    const double l = lengths_s[i - 1];
    const double r = lengths_s[i];
    Matrix2 pivot = Diagonal(l, r);
    x[i] = RightHandSide(points[i - 1].q, points[i].q, points[i + 1].q, l, r);
    if (i > 1) {
      const Matrix2 coupling = Coupling(l);
      const Matrix2 factor = Product(Transposed(coupling), pivots[i - 1]);
      const Matrix2 update = Product(factor, coupling);
      pivot = {pivot.a - update.a, pivot.b - update.b, pivot.c - update.c, pivot.d - update.d};
      Subtract(Product(factor, x[i - 1]), x[i]);
    }
    pivots[i] = Inverse(pivot);
  }
  for (std::size_t i = last; i-- > 1;) {
    if (i + 1 < last) Subtract(Product(Coupling(lengths_s[i]), x[i + 1]), x[i]);
    x[i] = Product(pivots[i], x[i]);
  }
  return x;
}

/// Appends the segments of a spline without inner stops.
void AppendSpline(std::span<const Waypoint> points, std::span<const Duration> knots,
                  std::vector<QuinticSegment>& segments) {
  std::vector<double> lengths_s(points.size() - 1);
  for (std::size_t i = 0; i < lengths_s.size(); ++i) {
    lengths_s[i] = ToSeconds(knots[i + 1] - knots[i]);
  }
  const std::vector<Pair> rates = SolveRates(points, lengths_s);
  for (std::size_t i = 0; i < lengths_s.size(); ++i) {
    QuinticSegment& segment = segments.emplace_back();
    segment.begin = knots[i];
    segment.length_s = lengths_s[i];
    for (std::size_t j = 0; j < kJoints; ++j) {
      segment.c[j] =
          QuinticBetween(points[i].q[j], rates[i].dq[j], rates[i].ddq[j], points[i + 1].q[j],
                         rates[i + 1].dq[j], rates[i + 1].ddq[j], lengths_s[i]);
    }
  }
}

}  // namespace

std::vector<QuinticSegment> FitSpline(std::span<const Waypoint> waypoints,
                                      std::span<const Duration> knots) {
  TWIN_CHECK(waypoints.size() >= 2 && waypoints.size() == knots.size());
  std::vector<QuinticSegment> segments;
  segments.reserve(waypoints.size() - 1);
  std::size_t first = 0;
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    if (!waypoints[i].stop && i + 1 < waypoints.size()) continue;
    AppendSpline(waypoints.subspan(first, i - first + 1), knots.subspan(first, i - first + 1),
                 segments);
    first = i;
  }
  return segments;
}

}  // namespace twin::reference::internal

namespace twin::reference {

std::array<double, 6> QuinticBetween(double q0, double dq0, double ddq0, double q1, double dq1,
                                     double ddq1, double h) noexcept {
  const double d = q1 - q0;
  const double h2 = h * h;
  const double h3 = h2 * h;
  return {q0,
          dq0,
          ddq0 / 2,
          (20 * d - (12 * dq0 + 8 * dq1) * h - (3 * ddq0 - ddq1) * h2) / (2 * h3),
          (-30 * d + (16 * dq0 + 14 * dq1) * h + (3 * ddq0 - 2 * ddq1) * h2) / (2 * h3 * h),
          (12 * d - 6 * (dq0 + dq1) * h - (ddq0 - ddq1) * h2) / (2 * h3 * h2)};
}

}  // namespace twin::reference
