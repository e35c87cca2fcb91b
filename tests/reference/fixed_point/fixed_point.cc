#include "reference/fixed_point/fixed_point.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "twin/core/random.h"
#include "twin/core/time.h"

namespace twin::reference {
namespace {

constexpr double kT = kCycleSeconds;

/// A step that reaches no farther into the set than this has changed nothing but by rounding.
constexpr double kConverged = 2e-11;

Polytope::Rows Box() {
  Polytope::Rows rows;
  for (int i = 0; i < 3; ++i) {
    rows.emplace_back(Eigen::Vector3d::Unit(i));
    rows.emplace_back(-Eigen::Vector3d::Unit(i));
  }
  return rows;
}

/// How far a set's corners are outside another.
double Residual(const Polytope& before, const Polytope& after) {
  double most = 0;
  for (const Eigen::Vector3d& corner : before.corners()) {
    most = std::max(most, after.Excess(corner));
  }
  return most;
}

/// States for Compare().
class Samples {
 public:
  Samples(const Polytope& set, double way, std::uint64_t seed)
      : set_(set), way_(way), random_(seed, RandomStream::kTest) {}

  Eigen::Vector3d Next() {
    const int kind = static_cast<int>(4 * Draw());
    if (kind == 3) return {Signed(), Signed(), Signed()};
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(kind);
    for (;;) {
      const Eigen::Vector3d x = Anywhere();
      const auto [first, last] = set_.Chord(x, along);
      if (first > last) continue;  // no state is viable there
      const double end = Draw() < 0.5 ? first : last;
      const double off = std::pow(10, -2 - 7 * Draw());
      return x + (end + (Draw() < 0.5 ? off : -off)) * along;
    }
  }

 private:
  double Draw() { return random_.Uniform(++draws_); }
  double Signed() { return 2 * Draw() - 1; }

  /// Where the borders are: half of them not farther from the range's ends than twice the way that
  /// the joint needs to stop, and a third of them at full acceleration.
  Eigen::Vector3d Anywhere() {
    Eigen::Vector3d x(Signed(), Signed(), Signed());
    if (Draw() < 0.5) x[0] = std::copysign(1 - std::min(1.0, 2 * way_ * Draw()), x[0]);
    if (Draw() < 0.3) x[2] = std::copysign(1.0, x[2]);
    return x;
  }

  const Polytope& set_;
  double way_;
  Random random_;
  std::uint64_t draws_ = 0;
};

/// The closed form's set for another range: its faces keep their distance from the range's ends.
Polytope OfRange(const Polytope& wide, double half_wide, double half) {
  Polytope::Rows rows = Box();
  for (const Eigen::Vector3d& g : wide.rows()) {
    const double of_q = std::abs(g[0]);
    if (of_q < 1e-12) {  // a face of speed or acceleration alone
      rows.push_back(g);
      continue;
    }
    const double slack = half_wide / of_q - half_wide + half;  // rad, at rest in the middle
    rows.emplace_back(Eigen::Vector3d(std::copysign(half, g[0]), half_wide * g[1] / of_q,
                                      half_wide * g[2] / of_q) /
                      slack);
  }
  return Polytope(rows);
}

AxisBounds WithRange(AxisBounds bounds, double range) {
  bounds.q_min = -range / 2;
  bounds.q_max = range / 2;
  return bounds;
}

}  // namespace

ScaledJoint::ScaledJoint(const AxisBounds& bounds)
    : middle((bounds.q_min + bounds.q_max) / 2),
      units((bounds.q_max - bounds.q_min) / 2, bounds.dq_max, bounds.ddq_max) {
  Eigen::Matrix3d step;
  step << 1, kT, kT * kT, 0, 1, kT, 0, 0, 1;
  const Eigen::Vector3d of_jerk(kT * kT * kT, kT * kT, kT);
  A = units.cwiseInverse().asDiagonal() * step * units.asDiagonal();
  b = units.cwiseInverse().cwiseProduct(of_jerk) * bounds.dddq_max;
}

Eigen::Vector3d ScaledJoint::Scaled(const AxisState& x) const {
  return Eigen::Vector3d(x.q - middle, x.dq, x.ddq).cwiseQuotient(units);
}

AxisState ScaledJoint::Unscaled(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d si = x.cwiseProduct(units);
  return {.q = middle + si[0], .dq = si[1], .ddq = si[2]};
}

Polytope Shrunk(const Polytope& set, const ScaledJoint& joint, int lost) {
  Polytope::Rows once = RowsBefore(set, joint.A, joint.b);
  const Polytope::Rows box = Box();
  once.insert(once.end(), box.begin(), box.end());
  const Polytope answered(once);
  Polytope::Rows rows;
  rows.reserve(answered.rows().size() * static_cast<std::size_t>(lost + 1));
  for (Eigen::Vector3d g : answered.rows()) {
    rows.push_back(g);
    for (int i = 0; i < lost; ++i) rows.emplace_back(g = joint.A.transpose() * g);
  }
  return Polytope(rows);
}

FixedPoint FixedPointOf(const AxisBounds& bounds, int lost) {
  const ScaledJoint joint(bounds);
  FixedPoint found{.set = Polytope(Box())};
  constexpr int kMostSteps = 1000;
  while (found.steps < kMostSteps) {
    Polytope next = Shrunk(found.set, joint, lost);
    found.residual = Residual(found.set, next);
    if (found.residual < kConverged) return found;
    found.set = std::move(next);
    ++found.steps;
  }
  throw std::runtime_error("fixed point: no end after 1000 steps");
}

Agreement Compare(const FixedPoint& found, const ViableAxis& axis, std::uint64_t states,
                  std::uint64_t seed) {
  const ScaledJoint joint(axis.kept());
  Samples samples(found.set, axis.longest_way() / joint.units[0], seed);
  Agreement agreement{.states = states};
  for (std::uint64_t i = 0; i < states; ++i) {
    const Eigen::Vector3d scaled = samples.Next();
    const AxisState x = joint.Unscaled(scaled);
    const double excess = found.set.Excess(scaled);
    const bool viable = axis.Contains(x);
    agreement.viable += viable ? 1 : 0;
    agreement.near_border += std::abs(excess) < 1e-2 ? 1 : 0;
    if (viable == (excess <= 0)) continue;
    const double off = std::max(std::abs(excess), std::abs(axis.Margin(x)));
    agreement.differ_within = std::max(agreement.differ_within, off);
    agreement.disagreements += off > kBeyond ? 1 : 0;
  }
  return agreement;
}

double LeastRange(const AxisBounds& bounds, int lost) {
  // From full speed a joint stops within V^2 / (2 A) and what the losses of four commands add.
  const double way =
      bounds.dq_max * bounds.dq_max / (2 * bounds.ddq_max) + 4 * (lost + 1) * kT * bounds.dq_max;
  const double half_wide = 2 * way;
  const Polytope wide = FixedPointOf(WithRange(bounds, 2 * half_wide), lost).set;
  double too_small = 0;
  double enough = 2 * half_wide;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings && enough - too_small > 1e-6 * enough; ++i) {
    const double range = (too_small + enough) / 2;
    const Polytope set = OfRange(wide, half_wide, range / 2);
    const ScaledJoint joint(WithRange(bounds, range));
    const bool stays = Residual(set, Shrunk(set, joint, lost)) < kBeyond;
    (stays ? enough : too_small) = range;
  }
  return enough;
}

}  // namespace twin::reference
