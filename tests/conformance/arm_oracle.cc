#include "conformance/arm_oracle.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace twin::test {
namespace {

constexpr double kGravity = 9.81;
constexpr std::size_t kFlange = 8;

/// Modified Denavit-Hartenberg parameters (Craig): Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d).
/// Source: FCI protocol 5, kinematics; Franka's documentation of the Panda.
struct Row {
  double a, d, alpha;
};
constexpr double kQuarter = std::numbers::pi / 2;
constexpr std::array<Row, kFlange> kRows{{{0, 0.333, 0},
                                          {0, 0, -kQuarter},
                                          {0, 0.316, kQuarter},
                                          {0.0825, 0, kQuarter},
                                          {-0.0825, 0.384, -kQuarter},
                                          {0, 0, kQuarter},
                                          {0.088, 0, kQuarter},
                                          {0, 0.107, 0}}};

/// Masses of the links and their centres in the joints' frames. Source: as
/// tests/data/model_reference.json.
struct LinkMass {
  double m;
  Vector3 c;
};
constexpr std::array<LinkMass, kJoints> kLinks{
    {{4.970684, {0.008212145719781648, -0.012489433728811434, -0.04762}},
     {0.646926, {-0.008847188777277989, -0.027478515098922834, -0.10845755996646182}},
     {3.226078812759408, {0.02841819564298921, 0.03858833128409879, -0.06679932425691104}},
     {3.588634337011673, {-0.052923582753299815, 0.1041655281882056, 0.028072528740131844}},
     {1.224660602599113, {-0.00819919810222125, 0.044849648534549445, -0.03912541618142476}},
     {1.665269602599113, {0.06064264248542852, -0.013792474511436911, -0.013276699467264706}},
     {0.7347474831348583, {0.008499343414525214, -0.0006345336526240304, 0.060901871831290526}}}};

/// What a part may meet.
enum class Side : std::uint8_t {
  kNear,     ///< before the elbow: meets what is far, and the hand
  kForearm,  ///< meets the hand
  kBoth,     ///< of the forearm its outer half: meets what is near, and the hand
  kFar,      ///< meets what is near
  kHand,     ///< meets all but what is far, and is not there without a hand
};

/// A straight line in the frame of a joint (0: of the base), with a radius.
struct Capsule {
  Side side;
  std::size_t frame;
  Vector3 a, b;
  double radius;
};

/// A point of the hand, whose y axis is the flange's x and y in equal parts.
Vector3 OfHand(double y, double z) {
  const double c = std::sqrt(0.5);
  return {c * y, c * y, 0.107 + z};
}

const std::array<Capsule, 13>& Capsules() {
  static const std::array<Capsule, 13> capsules{{
      {Side::kNear, 0, {-0.10, 0, 0.05}, {0, 0, 0.05}, 0.085},
      {Side::kNear, 0, {0, 0, 0.10}, {0, 0, 0.30}, 0.075},
      {Side::kNear, 2, {0, 0, -0.07}, {0, 0, 0.07}, 0.062},
      {Side::kNear, 2, {0, 0, 0}, {0, -0.316, 0}, 0.062},
      {Side::kForearm, 4, {-0.0825, 0, 0}, {-0.0825, 0.20, 0}, 0.06},
      {Side::kBoth, 5, {0, 0.01, -0.18}, {0, 0.075, -0.03}, 0.055},
      {Side::kFar, 5, {0, 0, 0}, {0, 0.08, 0}, 0.055},
      {Side::kFar, 6, {0, 0, 0}, {0.088, 0.01, 0}, 0.05},
      {Side::kFar, 6, {0.088, 0.05, 0}, {0.088, 0, 0}, 0.047},
      {Side::kFar, 7, {0, 0, 0.03}, {0, 0, 0.09}, 0.047},
      {Side::kFar, 7, {0.03, 0.03, 0.076}, {0.052, 0.052, 0.076}, 0.026},
      {Side::kHand, 7, OfHand(-0.07, 0.037), OfHand(0.07, 0.037), 0.045},
      {Side::kHand, 7, OfHand(-0.05, 0.09), OfHand(0.05, 0.09), 0.022},
  }};
  return capsules;
}

bool CanMeet(Side one, Side other, bool with_hand) {
  if (!with_hand && (one == Side::kHand || other == Side::kHand)) return false;
  const auto are = [&](Side a, Side b) {
    return (one == a && other == b) || (one == b && other == a);
  };
  return are(Side::kNear, Side::kBoth) || are(Side::kNear, Side::kFar) ||
         are(Side::kNear, Side::kHand) || are(Side::kForearm, Side::kHand) ||
         are(Side::kBoth, Side::kHand);
}

Vector3 Sum(const Vector3& a, const Vector3& b, double scale) {
  return {a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]};
}

double DotOf(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector3 Cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double Length(const Vector3& v) {
  return std::sqrt(DotOf(v, v));
}

Vector3 Column(const Transform& X, std::size_t column) {
  return {X[4 * column], X[4 * column + 1], X[4 * column + 2]};
}

Vector3 Image(const Transform& X, const Vector3& p) {
  Vector3 image = Column(X, 3);
  for (std::size_t c = 0; c < 3; ++c) image = Sum(image, Column(X, c), p[c]);
  return image;
}

struct Segment {
  Vector3 a, b;
};

double DistanceOf(const Vector3& p, const Segment& s) {
  const Vector3 along = Sum(s.b, s.a, -1);
  const double t = std::clamp(DotOf(Sum(p, s.a, -1), along) / DotOf(along, along), 0.0, 1.0);
  return Length(Sum(Sum(p, s.a, -1), along, -t));
}

/// The least of: an end of one and the other, and the two lines, where their feet lie inside.
double DistanceOf(const Segment& s, const Segment& t) {
  double least =
      std::min({DistanceOf(s.a, t), DistanceOf(s.b, t), DistanceOf(t.a, s), DistanceOf(t.b, s)});
  const Vector3 u = Sum(s.b, s.a, -1);
  const Vector3 v = Sum(t.b, t.a, -1);
  const Vector3 normal = Cross(u, v);
  const double area = DotOf(normal, normal);
  if (area <= 1e-20) return least;
  const Vector3 between = Sum(t.a, s.a, -1);
  const double on_s = DotOf(Cross(between, v), normal) / area;
  const double on_t = DotOf(Cross(between, u), normal) / area;
  if (on_s > 0 && on_s < 1 && on_t > 0 && on_t < 1) {
    least = std::min(least, std::abs(DotOf(between, normal)) / std::sqrt(area));
  }
  return least;
}

double SampledDistanceOf(const Segment& s, const Segment& t, double spacing) {
  const auto points = [spacing](const Segment& segment) {
    const Vector3 along = Sum(segment.b, segment.a, -1);
    const int steps = static_cast<int>(std::ceil(Length(along) / spacing));
    std::vector<Vector3> all;
    for (int k = 0; k <= steps; ++k)
      all.push_back(Sum(segment.a, along, static_cast<double>(k) / steps));
    return all;
  };
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3& p : points(s)) {
    for (const Vector3& q : points(t)) least = std::min(least, Length(Sum(p, q, -1)));
  }
  return least;
}

template <typename Distance>
double LeastDistance(const std::array<Transform, 9>& O_T, bool with_hand, Distance distance) {
  double least = std::numeric_limits<double>::infinity();
  const std::array<Capsule, 13>& capsules = Capsules();
  std::array<Segment, 13> axes;
  for (std::size_t k = 0; k < capsules.size(); ++k) {
    const Transform& X = O_T[capsules[k].frame];
    axes[k] = {Image(X, capsules[k].a), Image(X, capsules[k].b)};
  }
  for (std::size_t k = 0; k < capsules.size(); ++k) {
    for (std::size_t l = 0; l < k; ++l) {
      if (!CanMeet(capsules[k].side, capsules[l].side, with_hand)) continue;
      least = std::min(least, distance(axes[k], axes[l]) - capsules[k].radius - capsules[l].radius);
    }
  }
  return least;
}

}  // namespace

Transform Product(const Transform& X, const Transform& Y) {
  Transform XY{};
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t r = 0; r < 4; ++r) {
      for (std::size_t k = 0; k < 4; ++k) XY[4 * c + r] += X[4 * k + r] * Y[4 * c + k];
    }
  }
  return XY;
}

ArmOracle::ArmOracle(const JointVector& q) {
  O_T_[0] = kIdentityTransform;
  for (std::size_t i = 0; i < kFlange; ++i) {
    const auto& [a, d, alpha] = kRows[i];
    const double theta = i < kJoints ? q[i] : 0;
    const double c = std::cos(theta);
    const double s = std::sin(theta);
    const double ca = std::cos(alpha);
    const double sa = std::sin(alpha);
    const Transform step{c, s * ca, s * sa, 0, -s, c * ca,  c * sa, 0,
                         0, -sa,    ca,     0, a,  -d * sa, d * ca, 1};
    O_T_[i + 1] = Product(O_T_[i], step);
  }
}

Transform ArmOracle::Pose(const Transform& F_T_X) const {
  return Product(O_T_[kFlange], F_T_X);
}

std::array<Vector6, kJoints> ArmOracle::Jacobian(const Transform& F_T_X) const {
  const Vector3 point = Column(Pose(F_T_X), 3);
  std::array<Vector6, kJoints> J;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Vector3 axis = Column(O_T_[i + 1], 2);
    const Vector3 v = Cross(axis, Sum(point, Column(O_T_[i + 1], 3), -1));
    J[i] = {v[0], v[1], v[2], axis[0], axis[1], axis[2]};
  }
  return J;
}

Vector6 ArmOracle::Twist(const JointVector& dq, const Transform& F_T_X) const {
  const std::array<Vector6, kJoints> J = Jacobian(F_T_X);
  Vector6 twist{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (std::size_t r = 0; r < 6; ++r) twist[r] += J[i][r] * dq[i];
  }
  return twist;
}

JointVector ArmOracle::Gravity(std::initializer_list<PointMass> beyond) const {
  JointVector g{};
  // The power that lifting m at c takes for each rad/s of a joint: m g z . (axis x (c - origin)).
  const auto add = [&](double m, const Vector3& c, std::size_t joints) {
    for (std::size_t i = 0; i < joints; ++i) {
      const Vector3 v = Cross(Column(O_T_[i + 1], 2), Sum(c, Column(O_T_[i + 1], 3), -1));
      g[i] += m * kGravity * v[2];
    }
  };
  for (std::size_t k = 0; k < kJoints; ++k)
    add(kLinks[k].m, Image(O_T_[k + 1], kLinks[k].c), k + 1);
  for (const PointMass& mass : beyond) add(mass.m, Image(O_T_[kFlange], mass.F_x_C), kJoints);
  return g;
}

double ArmOracle::SelfDistance(bool with_hand) const {
  return LeastDistance(O_T_, with_hand,
                       [](const Segment& s, const Segment& t) { return DistanceOf(s, t); });
}

double ArmOracle::SampledSelfDistance(bool with_hand, double spacing) const {
  return LeastDistance(O_T_, with_hand, [spacing](const Segment& s, const Segment& t) {
    return SampledDistanceOf(s, t, spacing);
  });
}

}  // namespace twin::test
