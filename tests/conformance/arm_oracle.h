#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>

#include "twin/core/joint_vector.h"

namespace twin::test {

/// A mass, and where it is in the flange's frame.
struct PointMass {
  double m = 0;  ///< kg
  Vector3 F_x_C{};
};

/// The arm once more, without the product's model: frames multiplied up from the published table of
/// Denavit-Hartenberg parameters, Jacobian and gravity by cross products of what they give, the
/// distance of its parts by looking at every feature of their axes. The figures are data, written
/// down a second time: masses are those of tests/data/model_reference.json, capsules those of
/// model/self_collision.h.
class ArmOracle {
 public:
  explicit ArmOracle(const JointVector& q);

  /// O_T_X.
  [[nodiscard]] Transform Pose(const Transform& F_T_X = kIdentityTransform) const;
  /// Column by column, of X's origin, base axes: [v; w] for each rad/s of a joint.
  [[nodiscard]] std::array<Vector6, kJoints> Jacobian(
      const Transform& F_T_X = kIdentityTransform) const;
  [[nodiscard]] Vector6 Twist(const JointVector& dq, const Transform& F_T_X) const;
  /// The torque that holds links and what is beyond the flange, Nm.
  [[nodiscard]] JointVector Gravity(std::initializer_list<PointMass> beyond) const;
  /// Between the parts that can meet, m; negative when they overlap.
  [[nodiscard]] double SelfDistance(bool with_hand) const;
  /// The same from above, by points along the parts' axes: at most `spacing` (m) too much.
  [[nodiscard]] double SampledSelfDistance(bool with_hand, double spacing) const;

 private:
  /// 0 the base, 1 to 7 the frame of the joint, 8 the flange.
  std::array<Transform, 9> O_T_;
};

/// X Y.
[[nodiscard]] Transform Product(const Transform& X, const Transform& Y);

}  // namespace twin::test
