#include "twin/planning/arm_solutions.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "twin/model/transform.h"

namespace twin::planning {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kShoulder = 0.333;  // d1, m
constexpr double kUpperArm = 0.316;  // d3
constexpr double kForearm = 0.384;   // d5
constexpr double kElbow = 0.0825;    // a3 = -a4
constexpr double kWrist = 0.088;     // a6
constexpr double kFlange = 0.107;
constexpr double kPi = std::numbers::pi;

/// Sine below which the upper arm counts as upright; rounding errors are about 1e-16.
constexpr double kUpright = 1e-9;

Matrix3d TurnX(double angle) {
  return Eigen::AngleAxisd(angle, Vector3d::UnitX()).toRotationMatrix();
}

Matrix3d TurnZ(double angle) {
  return Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
}

double Wrapped(double angle) {
  return std::remainder(angle, 2 * kPi);
}

/// The arm's planar triangle: shoulder, elbow and wrist, in axes x3 and z3.
struct Triangle {
  double q4;
  double wx, wz;  ///< shoulder to wrist
  double zx, zz;  ///< axis 5

  explicit Triangle(double q4_) : q4(q4_) {
    const double s = std::sin(q4);
    const double c = std::cos(q4);
    wx = kElbow - kElbow * c - kForearm * s;
    wz = kUpperArm - kElbow * s + kForearm * c;
    zx = -s;
    zz = c;
  }
};

/// The two rotations of the triangle's plane about u for which axes 5 and 6 are perpendicular, each
/// given by the direction in the plane perpendicular to u. @returns their number.
int PlaneDirections(const Triangle& triangle, const Vector3d& u, double length, const Vector3d& z6,
                    std::array<Vector3d, 2>& n) {
  // z5 = along u + across n, so cos(phi) A + sin(phi) B = C for n = cos(phi) e1 + sin(phi) e2.
  const double along = (triangle.zx * triangle.wx + triangle.zz * triangle.wz) / length;
  const double across = (triangle.zz * triangle.wx - triangle.zx * triangle.wz) / length;
  const Vector3d e1 = u.unitOrthogonal();
  const Vector3d e2 = u.cross(e1);
  const double A = across * e1.dot(z6);
  const double B = across * e2.dot(z6);
  const double C = -along * u.dot(z6);
  const double most = std::hypot(A, B);
  if (!(std::abs(C) <= most) || most == 0) return 0;
  const double middle = std::atan2(B, A);
  const double aside = std::acos(C / most);
  n[0] = std::cos(middle + aside) * e1 + std::sin(middle + aside) * e2;
  n[1] = std::cos(middle - aside) * e1 + std::sin(middle - aside) * e2;
  return 2;
}

/// Solves R_z(q1) R_y(q2) R_z(q3) = R for q1, q2, q3, with the given sign of sin(q2).
void ShoulderAngles(const Matrix3d& R, double sign, double q1_if_free, JointVector& q) {
  const double sine = std::hypot(R(0, 2), R(1, 2));
  if (sine < kUpright) {
    q[0] = q1_if_free;
    q[1] = R(2, 2) > 0 ? 0 : kPi;
    const double turned = std::atan2(R(1, 0), R(0, 0));
    q[2] = Wrapped(R(2, 2) > 0 ? turned - q[0] : q[0] - turned + kPi);
    return;
  }
  q[0] = std::atan2(sign * R(1, 2), sign * R(0, 2));
  q[1] = std::atan2(sign * sine, R(2, 2));
  q[2] = std::atan2(sign * R(2, 1), -sign * R(2, 0));
}

}  // namespace

ArmSolutions::ArmSolutions(const Transform& O_T_F, double q7, double q1) noexcept {
  const Matrix3d O_R_F = model::Orientation(O_T_F).toRotationMatrix();
  const Matrix3d O_R_6 = O_R_F * TurnZ(-q7) * TurnX(-kPi / 2);
  const Vector3d W = model::Position(O_T_F) - kFlange * O_R_F.col(2) - kWrist * O_R_6.col(0);
  const Vector3d SW = W - Vector3d(0, 0, kShoulder);
  const double length = SW.norm();
  const double upper = std::hypot(kUpperArm, kElbow);
  const double fore = std::hypot(kForearm, kElbow);
  const double cosine = (upper * upper + fore * fore - length * length) / (2 * upper * fore);
  if (!(std::abs(cosine) <= 1)) return;
  const Vector3d u = SW / length;
  const double inner = std::acos(cosine);
  const double offset = std::atan(kElbow / kForearm) + std::atan(kElbow / kUpperArm);
  for (const double q4 : {inner - kPi - offset, kPi - offset - inner}) {
    const Triangle triangle(Wrapped(q4));
    std::array<Vector3d, 2> directions;
    const int turns = PlaneDirections(triangle, u, length, O_R_6.col(2), directions);
    for (int turn = 0; turn < turns; ++turn) {
      const Vector3d& n = directions[turn];
      Matrix3d O_R_3;
      O_R_3.col(0) = (triangle.wx * u - triangle.wz * n) / length;
      O_R_3.col(2) = (triangle.wz * u + triangle.wx * n) / length;
      O_R_3.col(1) = O_R_3.col(2).cross(O_R_3.col(0));
      // R_z(q5) R_x(pi/2) R_z(q6)
      const Matrix3d M =
          (O_R_3 * TurnX(kPi / 2) * TurnZ(triangle.q4) * TurnX(-kPi / 2)).transpose() * O_R_6;
      for (const double sign : {1.0, -1.0}) {
        JointVector& q = q_[count_++];
        ShoulderAngles(O_R_3, sign, q1, q);
        q[3] = triangle.q4;
        q[4] = std::atan2(M(0, 2), -M(1, 2));
        q[5] = std::atan2(M(2, 0), M(2, 1));
        if (q[5] <= -kPi / 2) q[5] += 2 * kPi;
        q[6] = q7;
      }
    }
  }
}

}  // namespace twin::planning
