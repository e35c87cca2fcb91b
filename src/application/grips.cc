#include "application/pick.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "twin/core/hand_command.h"
#include "twin/model/transform.h"

namespace twin::application {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Dimensions of the Franka Hand from the midpoint of its fingertips: models/robots/hand/hand.urdf.
constexpr double kPalm = 0.0374;      // m, up to the palm
constexpr double kTip = 0.0088;       // m, down to the tips
constexpr double kLeastHold = 0.004;  // m, least height of the object above this midpoint

/// A cylinder stands if the cosine of its axis's angle from the vertical is larger.
constexpr double kStands = 0.7;

/// An axis along which the fingers close, and the object's width between them.
struct Closing {
  Vector3d axis;
  double width = 0;
};

/// The object's axis that points up; of a lying cylinder the upward direction across its axis.
Vector3d UpOf(const plant::SceneObject& object, const Vector3d& up) {
  Vector3d nearest = Vector3d::Zero();
  if (object.shape == plant::ObjectShape::kCylinder && std::abs(up.z()) < kStands) {
    return Vector3d(up.x(), up.y(), 0).normalized();
  }
  Eigen::Index axis = 2;
  if (object.shape == plant::ObjectShape::kBox) up.cwiseAbs().maxCoeff(&axis);
  nearest[axis] = up[axis] < 0 ? -1 : 1;
  return nearest;
}

std::vector<Closing> ClosingsOf(const plant::SceneObject& object, const Vector3d& up) {
  std::vector<Closing> closings;
  if (object.shape == plant::ObjectShape::kBox) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (std::abs(up[axis]) > 0.5) continue;
      closings.push_back({Vector3d::Unit(axis), object.size[static_cast<std::size_t>(axis)]});
    }
  } else if (std::abs(up.z()) > 0.5) {
    for (int eighth = 0; eighth < 4; ++eighth) {
      const double angle = eighth * std::numbers::pi / 4;
      closings.push_back({Vector3d(std::cos(angle), std::sin(angle), 0), object.size[0]});
    }
  } else {
    closings.push_back({up.cross(Vector3d::UnitZ()), object.size[0]});
    closings.push_back({Vector3d::UnitZ(), object.size[2]});
  }
  return closings;
}

/// Half of the object's extent along `up`, object's axes.
double HalfAlong(const plant::SceneObject& object, const Vector3d& up) {
  if (object.shape != plant::ObjectShape::kBox) {
    return (std::abs(up.z()) > 0.5 ? object.size[2] : object.size[0]) / 2;
  }
  return up.cwiseAbs().dot(Vector3d(object.size.data())) / 2;
}

}  // namespace

std::vector<Grip> GripsOf(const plant::SceneObject& object, const Vector3& up,
                          const GripRoom& room) {
  const Matrix3d O_R_B = model::Orientation(object.X_WB).toRotationMatrix();
  const Vector3d B_up = UpOf(object, O_R_B.transpose() * Vector3d(up.data()));
  const double half = HalfAlong(object, B_up);
  const double height = std::max({0.0, half - (kPalm - room.palm), kTip + room.below - half});
  std::vector<Grip> grips;
  if (height > half - kLeastHold) return grips;
  for (const Closing& closing : ClosingsOf(object, B_up)) {
    if (closing.width > kHandStroke - 2 * room.beside) continue;
    for (const double sign : {1.0, -1.0}) {
      Matrix3d B_R_NE;
      B_R_NE.col(1) = sign * closing.axis;
      B_R_NE.col(2) = -B_up;
      B_R_NE.col(0) = B_R_NE.col(1).cross(B_R_NE.col(2));
      grips.push_back({.B_T_NE = model::Pose(Eigen::Quaterniond(B_R_NE), height * B_up),
                       .B_up = {B_up.x(), B_up.y(), B_up.z()},
                       .width = closing.width});
    }
  }
  return grips;
}

}  // namespace twin::application
