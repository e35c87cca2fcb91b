#include "support/pose_samples.h"

#include <cmath>

#include <Eigen/Geometry>

namespace twin::test {

Transform PoseOf(const Eigen::Vector3d& phi, const Eigen::Vector3d& p) {
  Transform X = kIdentityTransform;
  Eigen::Map<Eigen::Matrix4d> matrix(X.data());
  const double angle = phi.norm();
  if (angle > 0) {
    matrix.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
  }
  matrix.topRightCorner<3, 1>() = p;
  return X;
}

Eigen::Matrix3d RotationOf(const Transform& X) {
  return Eigen::Map<const Eigen::Matrix4d>(X.data()).topLeftCorner<3, 3>();
}

Eigen::Vector3d PositionOf(const Transform& X) {
  return Eigen::Vector3d(X[12], X[13], X[14]);
}

Eigen::Vector3d RotationVector(const Transform& from, const Transform& to) {
  const Eigen::AngleAxisd turn(RotationOf(to) * RotationOf(from).transpose());
  return turn.angle() * turn.axis();
}

double Obliqueness(const Transform& X) {
  const Eigen::Matrix3d R = RotationOf(X);
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

Eigen::Vector3d RandomVector(const Random& random, std::uint64_t tick, std::uint32_t draw) {
  return Eigen::Vector3d(2 * random.Uniform(tick, draw) - 1, 2 * random.Uniform(tick, draw + 1) - 1,
                         2 * random.Uniform(tick, draw + 2) - 1);
}

Transform RandomPose(const Random& random, std::uint64_t tick) {
  return PoseOf(3 / std::sqrt(3.0) * RandomVector(random, tick, 0), RandomVector(random, tick, 3));
}

}  // namespace twin::test
