#include "twin/model/transform.h"

#include <algorithm>
#include <limits>

namespace twin::model {

Transform Multiply(const Transform& X_AB, const Transform& X_BC) noexcept {
  Transform X_AC = kIdentityTransform;
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t r = 0; r < 3; ++r) {
      const double rotated =
          X_AB[r] * X_BC[4 * c] + X_AB[4 + r] * X_BC[4 * c + 1] + X_AB[8 + r] * X_BC[4 * c + 2];
      X_AC[4 * c + r] = c == 3 ? rotated + X_AB[12 + r] : rotated;
    }
  }
  return X_AC;
}

Transform Inverse(const Transform& X_AB) noexcept {
  Transform X_BA = kIdentityTransform;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) X_BA[4 * c + r] = X_AB[4 * r + c];
    X_BA[12 + r] =
        -(X_AB[4 * r] * X_AB[12] + X_AB[4 * r + 1] * X_AB[13] + X_AB[4 * r + 2] * X_AB[14]);
  }
  return X_BA;
}

namespace {

using ConstMatrix4 = Eigen::Map<const Eigen::Matrix4d>;

}  // namespace

Eigen::Quaterniond Orientation(const Transform& X) noexcept {
  const Eigen::Matrix3d R = ConstMatrix4(X.data()).topLeftCorner<3, 3>();
  return Eigen::Quaterniond(R).normalized();
}

Eigen::Vector3d Position(const Transform& X) noexcept {
  return Eigen::Vector3d(X[12], X[13], X[14]);
}

Transform Pose(const Eigen::Quaterniond& orientation, const Eigen::Vector3d& position) noexcept {
  Transform X = kIdentityTransform;
  Eigen::Map<Eigen::Matrix4d> matrix(X.data());
  matrix.topLeftCorner<3, 3>() = orientation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = position;
  return X;
}

Eigen::Vector3d Log(const Eigen::Quaterniond& rotation) noexcept {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Eigen::Quaterniond Exp(const Eigen::Vector3d& phi) noexcept {
  const double angle = phi.norm();
  // sin(x/2)/x, whose limit is 1/2.
  const double share = angle > 0 ? std::sin(angle / 2) / angle : 0.5;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(angle / 2);
  rotation.vec() = share * phi;
  return rotation;
}

Eigen::Vector3d TurnBetween(const Transform& from, const Transform& to) noexcept {
  return Log(Orientation(to) * Orientation(from).conjugate());
}

Vector6 WayTo(const Transform& X, const Transform& X_d) noexcept {
  const Eigen::Vector3d p = Position(X_d) - Position(X);
  const Eigen::Vector3d phi = TurnBetween(X, X_d);
  return {p[0], p[1], p[2], phi[0], phi[1], phi[2]};
}

Transform Turned(const Transform& X, const Eigen::Vector3d& phi,
                 const Eigen::Vector3d& position) noexcept {
  // Conversion to a quaternion and back loses a few units of rounding.
  constexpr double kResolution = 8 * std::numeric_limits<double>::epsilon();
  if (phi.norm() < kResolution) {
    Transform moved = X;
    std::copy_n(position.data(), 3, moved.begin() + 12);
    return moved;
  }
  return Pose((Exp(phi) * Orientation(X)).normalized(), position);
}

}  // namespace twin::model
