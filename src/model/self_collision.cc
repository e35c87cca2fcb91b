#include "twin/model/self_collision.h"

#include <algorithm>
#include <cmath>

#include "model/joint_chain.h"

namespace twin::model {
namespace {

using internal::Dot;
using internal::kFlangeOffset;
using internal::Offset;
using internal::TipToBase;
using internal::ToParent;
using internal::operator+;
using internal::operator-;
using internal::operator*;

/// A capsule in the frame of a link.
struct Capsule {
  std::size_t link;  ///< 0 the base, 1..7 by the joint before it
  Vector3 a, b;      ///< ends of its axis
  double radius;
};

/// Ordered so that the compared parts form ranges.
enum Part : std::size_t {
  kBase,
  kColumn,
  kShoulder,
  kUpperArm,
  kForearm,
  kForearmTaper,
  kWrist,
  kLink6,
  kLink6Barrel,
  kFlange,
  kPilot,
  kHand,
  kFingers,
  kParts
};

constexpr double kCos45 = 0.70710678118654752440;

/// A point of the hand, whose y axis is rotated by 45 degrees from the flange's.
constexpr Vector3 OfHand(double y, double z) {
  return {kCos45 * y, kCos45 * y, kFlangeOffset + z};
}

constexpr std::array<Capsule, kParts> kCapsules{{
    {0, {-0.10, 0, 0.05}, {0, 0, 0.05}, 0.085},
    {0, {0, 0, 0.10}, {0, 0, 0.30}, 0.075},
    {2, {0, 0, -0.07}, {0, 0, 0.07}, 0.062},
    {2, {0, 0, 0}, {0, -0.316, 0}, 0.062},
    {4, {-0.0825, 0, 0}, {-0.0825, 0.20, 0}, 0.06},
    {5, {0, 0.01, -0.18}, {0, 0.075, -0.03}, 0.055},
    {5, {0, 0, 0}, {0, 0.08, 0}, 0.055},
    {6, {0, 0, 0}, {0.088, 0.01, 0}, 0.05},
    {6, {0.088, 0.05, 0}, {0.088, 0, 0}, 0.047},
    {7, {0, 0, 0.03}, {0, 0, 0.09}, 0.047},
    {7, {0.03, 0.03, 0.076}, {0.052, 0.052, 0.076}, 0.026},
    {7, OfHand(-0.07, 0.037), OfHand(0.07, 0.037), 0.045},
    {7, OfHand(-0.05, 0.09), OfHand(0.05, 0.09), 0.022},
}};

/// Largest distance from a joint's axis of everything beyond it, m, rounded up; a test compares it
/// with the capsules.
constexpr JointVector kReach{1.2, 1.2, 0.9, 0.9, 0.4, 0.4, 0.25};

/// The capsules' axes in the base.
struct CapsuleAxes {
  std::array<Vector3, kParts> a;
  std::array<Vector3, kParts> b;
};

/// Transforms every point from its link to the base, joint by joint.
CapsuleAxes Carry(const Configuration& q, std::size_t parts) noexcept {
  CapsuleAxes axes;
  std::size_t first = parts;  // of the points in progress
  TipToBase([&]<std::size_t i>() {
    while (first > 0 && kCapsules[first - 1].link == i + 1) {
      --first;
      axes.a[first] = kCapsules[first].a;
      axes.b[first] = kCapsules[first].b;
    }
    constexpr Vector3 p = Offset(i);
    for (std::size_t k = first; k < parts; ++k) {
      axes.a[k] = p + ToParent<i>(axes.a[k], q.sin[i], q.cos[i]);
      axes.b[k] = p + ToParent<i>(axes.b[k], q.sin[i], q.cos[i]);
    }
  });
  for (std::size_t k = 0; k < first; ++k) {
    axes.a[k] = kCapsules[k].a;
    axes.b[k] = kCapsules[k].b;
  }
  return axes;
}

/// Square of the distance between the segments p + s d and q + t e, s and t in [0, 1], r = p - q.
/// Source: Ericson, Real-Time Collision Detection, 5.1.9.
double SquaredDistance(const Vector3& d, const Vector3& e, const Vector3& r) noexcept {
  const double dd = Dot(d, d);
  const double ee = Dot(e, e);
  const double de = Dot(d, e);
  const double dr = Dot(d, r);
  const double er = Dot(e, r);
  const double denominator = dd * ee - de * de;
  // Parallel segments: any s.
  double s = denominator > 1e-12 ? std::clamp((de * er - dr * ee) / denominator, 0.0, 1.0) : 0;
  double t = (de * s + er) / ee;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((de * t - dr) / dd, 0.0, 1.0);
  }
  const Vector3 apart = r + (s * d - t * e);
  return Dot(apart, apart);
}

/// Compares one pair, unless its bounding spheres suffice.
void Compare(const CapsuleAxes& axes, std::size_t k, std::size_t l, double& nearest) noexcept {
  const Vector3 d = axes.b[k] - axes.a[k];
  const Vector3 e = axes.b[l] - axes.a[l];
  const Vector3 r = axes.a[k] - axes.a[l];
  const double radii = kCapsules[k].radius + kCapsules[l].radius;
  const Vector3 between = r + 0.5 * (d - e);
  const double reach = 0.5 * (std::sqrt(Dot(d, d)) + std::sqrt(Dot(e, e))) + radii + nearest;
  if (!(Dot(between, between) < reach * reach)) return;
  nearest = std::min(nearest, std::sqrt(SquaredDistance(d, e, r)) - radii);
}

}  // namespace

double SelfDistance(const Configuration& q, bool with_hand, double horizon) noexcept {
  const std::size_t parts = with_hand ? kParts : kHand;
  const CapsuleAxes axes = Carry(q, parts);
  double nearest = horizon;
  for (std::size_t k = kForearmTaper; k < parts; ++k) {
    for (std::size_t l = kBase; l <= kUpperArm; ++l) Compare(axes, k, l, nearest);
  }
  for (std::size_t k = kHand; k < parts; ++k) {
    for (std::size_t l = kForearm; l <= kForearmTaper; ++l) Compare(axes, k, l, nearest);
  }
  return nearest;
}

double SelfDistanceWatch::Update(const JointVector& q, const Configuration& sines,
                                 double clearance) noexcept {
  double bound = distance_;
  for (std::size_t i = 0; i < kJoints; ++i) bound -= kReach[i] * std::abs(q[i] - q_[i]);
  if (is_known_ && bound >= clearance) return bound;
  distance_ = SelfDistance(sines, with_hand_);
  q_ = q;
  is_known_ = true;
  return distance_;
}

}  // namespace twin::model
