#include "twin/teleop/twist_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Core>

#include "twin/teleop/turn_bounds.h"

namespace twin::teleop {
namespace {

constexpr int kSweeps = 60;
constexpr int kMoreSweeps = 300;  // bounds that contradict each other converge slowly
constexpr double kVanishes = 1e-18;
constexpr double kCreeps = 1e-4;  // per s, unit of the measure: that much past a bound is none

Eigen::Map<const Eigen::Matrix<double, 6, 1>> AsEigen(const Vector6& v) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 1>>(v.data());
}

}  // namespace

std::string Describe(const ActiveBound& active) {
  switch (active.bound) {
    case Bound::kNone: return {};
    case Bound::kWorkspace: return "the workspace ends here";
    case Bound::kPress: return "something blocks the arm, which presses as hard as it may";
    case Bound::kJointEnd:
      return fmt::format("joint {} is close to the end of its range", active.joint);
    case Bound::kJointSpeed: return fmt::format("joint {} would turn too fast", active.joint);
    case Bound::kSingular: return "the arm is nearly stretched out or folded (singular)";
    case Bound::kSelf: return "the arm is close to itself";
    case Bound::kScene: return "the robot is close to a fixed body";
    case Bound::kRegion: return fmt::format("the lab's limit '{}' ends here", active.region.data());
    case Bound::kForce: return "the arm presses as hard as the lab's limit permits";
    case Bound::kTorque:
      return fmt::format("joint {} presses as hard as the lab's limit permits", active.joint);
  }
  return {};
}

void TwistBounds::Add(const Vector6& a, double b, ActiveBound bound) noexcept {
  if (count_ == kMost || !AsEigen(a).allFinite() || std::isnan(b)) return;
  Row& row = rows_[count_++];
  Eigen::Map<EigenVector6>(row.a.data()) = AsEigen(D_).cwiseProduct(AsEigen(a));
  row.b = b;
  row.bound = bound;
}

void TwistBounds::AddTo(TurnBounds& bounds, const Vector6& per_turn) const noexcept {
  const EigenVector6 scaled = AsEigen(per_turn).cwiseQuotient(AsEigen(D_));
  for (std::size_t k = 0; k < count_; ++k) {
    bounds.Add(AsEigen(rows_[k].a).dot(scaled), rows_[k].b, rows_[k].bound);
  }
}

ActiveBound TwistBounds::Project(EigenVector6& x, const EigenVector6& commanded, double least,
                                 int sweeps) const noexcept {
  std::array<double, kMost> lambda{};
  EigenVector6 too_fast = EigenVector6::Zero();  // Dykstra's correction of the balls
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    bool is_done = true;
    for (std::size_t k = 0; k < count_; ++k) {
      const EigenVector6 a = AsEigen(rows_[k].a).cwiseProduct(commanded);
      const double squared = a.squaredNorm();
      if (squared < kVanishes) continue;
      const double b = std::max(rows_[k].b, least);
      const double next = std::max(0.0, lambda[k] + (a.dot(x) - b) / squared);
      if (next == lambda[k]) continue;
      x -= (next - lambda[k]) * a;
      lambda[k] = next;
      is_done = false;
    }
    for (const Eigen::Index half : {0, 3}) {
      const Eigen::Vector3d there = (x + too_fast).segment<3>(half);
      const Eigen::Vector3d inside = there / std::max(1.0, there.norm());
      is_done = is_done && inside == x.segment<3>(half);
      too_fast.segment<3>(half) = there - inside;
      x.segment<3>(half) = inside;
    }
    if (is_done) break;
  }
  ActiveBound active;
  double most = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    const double removed = lambda[k] * AsEigen(rows_[k].a).norm();
    if (removed > most) active = rows_[k].bound;
    most = std::max(most, removed);
  }
  return active;
}

double TwistBounds::LargestShare(const EigenVector6& x) const noexcept {
  double share = 1;
  for (std::size_t k = 0; k < count_; ++k) {
    const double speed = AsEigen(rows_[k].a).dot(x);
    const double most = std::max(0.0, rows_[k].b) + kCreeps;
    if (speed > most) share = std::min(share, most / speed);
  }
  return share;
}

AllowedTwist TwistBounds::Closest(const Vector6& u) const noexcept {
  // The halves that are not commanded stay at rest.
  EigenVector6 commanded = EigenVector6::Zero();
  for (const Eigen::Index half : {0, 3}) {
    if (!AsEigen(u).segment<3>(half).isZero(0)) commanded.segment<3>(half).setOnes();
  }
  const EigenVector6 wished = AsEigen(u).cwiseQuotient(AsEigen(D_));
  EigenVector6 x = wished;
  AllowedTwist allowed;
  allowed.strongest = Project(x, commanded, -std::numeric_limits<double>::infinity(), kSweeps);
  allowed.meets_all = LargestShare(x) == 1;
  if (!allowed.meets_all) {
    x = wished;
    allowed.strongest = Project(x, commanded, 0, kMoreSweeps);
  }
  Eigen::Map<EigenVector6>(allowed.u.data()) = LargestShare(x) * x.cwiseProduct(AsEigen(D_));
  return allowed;
}

}  // namespace twin::teleop
